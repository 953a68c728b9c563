// What `encode` accepts and refuses, its bounds at the ends of the range of floats, and its choices.
#include <gtest/gtest.h>

#include <limits>

#include "codec_checks.h"
#include "tsc/codec.h"

namespace tsc::test {
namespace {

using meshes::Triangles;

EncodeOptions withStep(double step) {
  EncodeOptions options;
  options.step = step;
  return options;
}

ErrorCode errorOf(const OwnedMesh& mesh, const EncodeOptions& options) {
  const auto encoded = encode(mesh.mesh(), options);
  EXPECT_FALSE(encoded);
  return encoded ? ErrorCode::kTruncated : encoded.error().code;
}

/// x -> origin + scale * x, rounded to float.
OwnedMesh placed(Triangles triangles, double origin, double scale) {
  for (float& x : triangles.positions) x = static_cast<float>(origin + scale * x);
  return OwnedMesh(triangles);
}

void expectEveryChoiceHolds(const OwnedMesh& mesh, double step) {
  for (const bool anchored : {false, true}) {
    for (const auto& [choice, forced] : allChoices()) {
      EncodeOptions options = forced;
      options.step = step;
      options.anchored = anchored;
      const RoundTrip trip = roundTrip(mesh, options);
      ASSERT_EQ(trip.fault, "") << choice << (anchored ? ", anchored" : "");
    }
  }
}

// ------------------------------------------------------------------------------------------------- Little or nothing

TEST(Encode, NothingAtAll) {
  for (const auto& [choice, forced] : allChoices()) {
    EncodeOptions options = forced;
    options.step = 1;
    const RoundTrip trip = roundTrip({}, options);
    EXPECT_EQ(trip.fault, "") << choice;
    EXPECT_LE(trip.encoded.bytes.size(), 40u);
  }
}

TEST(Encode, TablesAndPrimitivesWithoutContent) {
  OwnedMesh mesh;
  mesh.tables.resize(3);
  mesh.primitives = {{2, {}, ComponentType::kUint8}, {0, {}, ComponentType::kUint16}};
  EXPECT_EQ(roundTrip(mesh, withStep(1)).fault, "");
}

TEST(Encode, VerticesWithoutFaces) {
  OwnedMesh mesh;
  mesh.tables = {{1, 2, 3, 1, 2, 3, -4, 5, 6}, {1, 2, 3}};
  EXPECT_EQ(roundTrip(mesh, withStep(0.1)).fault, "");
}

TEST(Encode, OnlyDegenerateFaces) {
  OwnedMesh mesh(Triangles{{0, 0, 0, 1, 1, 1, 2, 2, 2, 0, 0, 0}, {0, 0, 0, 0, 0, 1, 1, 2, 1, 0, 3, 2, 2, 2, 2}});
  expectEveryChoiceHolds(mesh, 0.01);
}

TEST(Encode, UnusedVerticesBesideAMesh) {
  Triangles triangles = meshes::torus(4, 5);
  for (int i = 0; i < 30; ++i) triangles.addVertex(static_cast<float>(i % 7), static_cast<float>(i % 3), 9);
  expectEveryChoiceHolds(OwnedMesh(triangles), 0.01);
}

TEST(Encode, AllVerticesAtOnePoint) {
  expectEveryChoiceHolds(OwnedMesh(Triangles{{5, 5, 5, 5, 5, 5, 5, 5, 5}, {0, 1, 2, 2, 1, 0}}), 1);
}

TEST(Encode, SmallMeshesHaveSmallHeaders) {
  const RoundTrip trip = roundTrip(OwnedMesh(meshes::triangle()), withStep(0.001));
  EXPECT_EQ(trip.fault, "");
  EXPECT_LE(trip.encoded.bits.header / 8, 28);
}

TEST(Encode, DuplicatesAndFlipSides) {
  Triangles triangles = meshes::twoSided(meshes::grid(4, 4));
  const std::vector<std::uint32_t> once = triangles.indices;
  for (int i = 0; i < 3; ++i) triangles.indices.insert(triangles.indices.end(), once.begin(), once.end());
  expectEveryChoiceHolds(OwnedMesh(triangles), 0.01);
}

// ------------------------------------------------------------------------------------------- The ends of the float
// range

TEST(Encode, FarFromTheOrigin) { expectEveryChoiceHolds(placed(meshes::torus(7, 6), 6e6, 100), 0.5); }

TEST(Encode, FarFromTheOriginWithAStepBelowFloatSpacing) {
  expectEveryChoiceHolds(placed(meshes::torus(7, 6), 6e6, 100), 0.01);
}

TEST(Encode, HugeCoordinates) { expectEveryChoiceHolds(placed(meshes::torus(7, 6), 0, 8e37), 1e34); }

TEST(Encode, TinyCoordinates) { expectEveryChoiceHolds(placed(meshes::torus(7, 6), 0, 1e-30), 1e-34); }

TEST(Encode, DenormalCoordinates) {
  expectEveryChoiceHolds(placed(meshes::torus(7, 6), 0, 1e-41), 1e-43);
  // Even the rounding of the output is then as coarse as the step.
  const double smallest = std::numeric_limits<float>::denorm_min();
  expectEveryChoiceHolds(placed(meshes::torus(7, 6), 0, 100 * smallest), smallest);
}

TEST(Encode, StepAboveTheExtent) { expectEveryChoiceHolds(placed(meshes::torus(7, 6), 3, 1), 1000); }

TEST(Encode, NeedlesAndSlivers) {
  Triangles triangles = meshes::grid(10, 10);
  for (std::size_t i = 1; i < triangles.positions.size(); i += 3) triangles.positions[i] *= 1e-6f;
  for (std::size_t i = 2; i < triangles.positions.size(); i += 3) triangles.positions[i] = 0;
  expectEveryChoiceHolds(OwnedMesh(triangles), 1e-5);
}

TEST(Encode, FinestLattice) {
  OwnedMesh mesh(Triangles{{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5f}, {0, 1, 2, 2, 1, 3}});
  // 2^25 steps: lattice mode only, whatever was asked for.
  expectEveryChoiceHolds(mesh, std::ldexp(1.0, -25));
  EXPECT_EQ(errorOf(mesh, withStep(std::ldexp(0.999, -25))), ErrorCode::kLatticeTooFine);
  // 2^19 steps: one too many for tangent mode.
  EncodeOptions options = withStep(std::ldexp(1.0, -19));
  options.mode = Mode::kTangent;
  EXPECT_EQ(roundTrip(mesh, options).encoded.modes.mode, Mode::kLattice);
  options.normal_scale = 16;
  EXPECT_EQ(roundTrip(mesh, options).fault, "");
  options.step *= 1.001;
  const RoundTrip trip = roundTrip(mesh, options);
  EXPECT_EQ(trip.fault, "");
  EXPECT_EQ(trip.encoded.modes.mode, Mode::kTangent);
}

TEST(Encode, AnchorTooFarAway) {
  EncodeOptions options = withStep(1e-6);
  options.anchored = true;
  EXPECT_EQ(errorOf(placed(meshes::triangle(), 1e12, 0), options), ErrorCode::kLatticeTooFine);
  options.anchored = false;
  EXPECT_EQ(roundTrip(placed(meshes::triangle(), 1e12, 0), options).fault, "");
}

// -------------------------------------------------------------------------------------------------------- Bad input

TEST(Encode, RefusesNonFinitePositions) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    for (std::size_t i = 0; i < 9; ++i) {
      OwnedMesh mesh(meshes::triangle());
      mesh.tables[0][i] = bad;
      const auto encoded = encode(mesh.mesh(), withStep(0.1));
      ASSERT_FALSE(encoded);
      EXPECT_EQ(encoded.error().code, ErrorCode::kNonFinitePosition);
      EXPECT_EQ(encoded.error().found, static_cast<std::int64_t>(i / 3)) << "the vertex";
    }
  }
}

TEST(Encode, RefusesBadSteps) {
  for (const double step :
       {0.0, -1.0, 1e-50, 1e300, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(errorOf(OwnedMesh(meshes::triangle()), withStep(step)), ErrorCode::kInvalidArgument) << step;
  }
}

TEST(Encode, RefusesBadOptions) {
  const OwnedMesh mesh(meshes::torus(4, 4));
  const auto refuses = [&](auto change) {
    EncodeOptions options = withStep(0.1);
    change(options);
    EXPECT_EQ(errorOf(mesh, options), ErrorCode::kInvalidArgument);
  };
  refuses([](EncodeOptions& o) { o.normal_scale = 0; });
  refuses([](EncodeOptions& o) { o.normal_scale = 17; });
  refuses([](EncodeOptions& o) { o.mode = static_cast<Mode>(3); });
  refuses([](EncodeOptions& o) { o.basis = static_cast<Basis>(3); });
  refuses([](EncodeOptions& o) { o.predictor = static_cast<Predictor>(6); });
  refuses([](EncodeOptions& o) { o.order = static_cast<Order>(3); });
  refuses([](EncodeOptions& o) { o.effort = static_cast<Effort>(2); });
}

TEST(Encode, RefusesBadMeshes) {
  const OwnedMesh good(meshes::triangle());
  const auto refuses = [&](auto change) {
    OwnedMesh mesh = good;
    change(mesh);
    EXPECT_EQ(errorOf(mesh, withStep(0.1)), ErrorCode::kInvalidArgument);
  };
  refuses([](OwnedMesh& m) { m.primitives[0].indices[1] = 3; });
  refuses([](OwnedMesh& m) { m.primitives[0].indices[1] = 0xffffffffu; });
  refuses([](OwnedMesh& m) { m.primitives[0].indices.push_back(0); });
  refuses([](OwnedMesh& m) { m.primitives[0].table = 1; });
  refuses([](OwnedMesh& m) { m.tables[0].push_back(1); });
  refuses([](OwnedMesh& m) { m.tables.clear(); });
  for (const ComponentType type : {ComponentType::kInt8, ComponentType::kInt16, ComponentType::kFloat32}) {
    refuses([&](OwnedMesh& m) { m.primitives[0].index_type = type; });
  }
  refuses([](OwnedMesh& m) { m.position_type = ComponentType::kUint32; });
  refuses([](OwnedMesh& m) { m.position_type = static_cast<ComponentType>(6); });
  refuses([](OwnedMesh& m) {
    m.tables[0].resize(3 * 257);
    m.primitives[0].index_type = ComponentType::kUint8;
  });
}

TEST(Encode, RefusesIntegerPositionsThatTheirTypeDoesNotHold) {
  for (const auto& [type, bad] : std::vector<std::pair<ComponentType, float>>{{ComponentType::kInt8, 128},
                                                                              {ComponentType::kInt8, -129},
                                                                              {ComponentType::kUint8, -1},
                                                                              {ComponentType::kUint8, 256},
                                                                              {ComponentType::kInt16, 32768},
                                                                              {ComponentType::kUint16, 65536},
                                                                              {ComponentType::kUint16, 0.5f},
                                                                              {ComponentType::kInt16, 1e30f}}) {
    OwnedMesh mesh(meshes::triangle());
    mesh.position_type = type;
    mesh.tables[0][4] = bad;
    EXPECT_EQ(errorOf(mesh, {}), ErrorCode::kInvalidArgument) << bad;
  }
}

// ---------------------------------------------------------------------------------------------- Steps, bounds, choices

TEST(Encode, StepForBits) {
  OwnedMesh mesh(Triangles{{-1, 0, 0, 1, 0.5f, 0, 0, 0, 0.25f}, {0, 1, 2}});
  EXPECT_EQ(stepForBits(mesh.mesh(), 10), 2.0 / 1023);
  EXPECT_EQ(stepForBits(mesh.mesh(), 1), 2.0);
  EXPECT_EQ(stepForBits({}, 10), 1.0);
  mesh.tables.push_back({0, 7, 0});
  EXPECT_EQ(stepForBits(mesh.mesh(), 2), 7.0 / 3) << "all tables count";
}

TEST(Encode, GuaranteedError) {
  const OwnedMesh mesh(Triangles{{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}});
  EncodeOptions options = withStep(0.125);
  options.mode = Mode::kLattice;
  EXPECT_NEAR(guaranteedError(mesh.mesh(), options), 0.125 * std::sqrt(0.75), 1e-6);
  options.mode = Mode::kTangent;
  const double scale_1 = guaranteedError(mesh.mesh(), options);
  EXPECT_GT(scale_1, 0.125 * std::sqrt(0.75));
  EXPECT_LT(scale_1, 0.125 * std::sqrt(0.75) * 1.05);
  options.normal_scale = 16;
  EXPECT_LT(guaranteedError(mesh.mesh(), options), 0.125 * 0.75);
  options.mode = Mode::kAuto;
  EXPECT_GE(guaranteedError(mesh.mesh(), options), 0.125 * std::sqrt(0.75));
}

TEST(Encode, ErrorsComeNearTheBound) {
  // A bound that were far too large would be of no use to anyone who asks for the largest step within an error.
  for (const auto& [choice, forced] : allChoices()) {
    const OwnedMesh mesh(meshes::torus(60, 50));
    EncodeOptions options = forced;
    options.step = 0.02;
    const RoundTrip trip = roundTrip(mesh, options);
    ASSERT_EQ(trip.fault, "") << choice;
    EXPECT_GT(trip.encoded.max_error, 0.85 * guaranteedError(mesh.mesh(), options)) << choice;
  }
}

TEST(Encode, AFinerNormalMakesTangentModeTheChoice) {
  EncodeOptions options = withStep(0.01);
  options.normal_scale = 4;
  EXPECT_EQ(roundTrip(OwnedMesh(meshes::grid(8, 8)), options).encoded.modes.mode, Mode::kTangent);
}

TEST(Encode, TheChoiceIsNotWorseThanEachThatWasTried) {
  for (const auto& [name, triangles] : meshes::samples()) {
    // Nothing is predicted there, so tangent mode is exact, and costs what that costs.
    if (name == "loose triangles" || name == "torus in shreds") continue;
    const OwnedMesh mesh(triangles);
    EncodeOptions options = withStep(stepForBits(mesh.mesh(), 12));
    const RoundTrip chosen = roundTrip(mesh, options);
    ASSERT_EQ(chosen.fault, "") << name;
    options.mode = Mode::kLattice;
    options.predictor = Predictor::kAverage;
    options.order = Order::kTraversal;
    const RoundTrip lattice = roundTrip(mesh, options);
    // Bits are compared at equal error; tangent mode's is about the same at the same step.
    EXPECT_LE(chosen.encoded.bits.positions, lattice.encoded.bits.positions * 1.05 + 16) << name;
  }
}

TEST(Encode, SmoothSurfacesCostLessInTangentMode) {
  const OwnedMesh mesh(meshes::grid(60, 60, [](float x, float y) { return 0.7f * x + 0.4f * y; }));
  EncodeOptions options = withStep(0.001);
  options.predictor = Predictor::kParallelogram;
  options.mode = Mode::kTangent;
  const double tangent = roundTrip(mesh, options).encoded.bits.positions;
  EXPECT_LT(tangent / (61 * 61), 8);
}

TEST(Encode, EffortIsAFieldOfTheStream) {
  EncodeOptions options = withStep(0.01);
  options.effort = Effort::kMax;
  const RoundTrip trip = roundTrip(OwnedMesh(meshes::torus(6, 6)), options);
  EXPECT_EQ(trip.fault, "");
  EXPECT_EQ(trip.encoded.modes.effort, Effort::kMax);
}

}  // namespace
}  // namespace tsc::test
