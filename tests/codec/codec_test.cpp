// Encoding and decoding from end to end, on procedural meshes and on random triangle soups.
#include "tsc/codec.h"

#include <gtest/gtest.h>

#include <random>

#include "codec_checks.h"

namespace tsc::test {
namespace {

using meshes::Triangles;

OwnedMesh randomSoup(std::mt19937& random) {
  const std::uint32_t tables = 1 + random() % 3;
  OwnedMesh mesh;
  const std::uint32_t spread = 1u << (1 + random() % 10);  // few distinct coordinates make many equal positions
  for (std::uint32_t t = 0; t < tables; ++t) {
    std::vector<float>& positions = mesh.tables.emplace_back();
    const std::uint32_t count = random() % 40;
    for (std::uint32_t i = 0; i < 3 * count; ++i) {
      const float x = (static_cast<float>(random() % spread) - static_cast<float>(spread / 2)) / 16;
      positions.push_back(x == 0 && random() % 2 == 0 ? -0.0f : x);
    }
  }
  const ComponentType types[] = {ComponentType::kUint8, ComponentType::kUint16, ComponentType::kUint32};
  for (std::uint32_t p = random() % 5; p > 0; --p) {
    OwnedMesh::Faces faces{static_cast<std::uint32_t>(random() % tables), {}, types[random() % 3]};
    const auto count = static_cast<std::uint32_t>(mesh.tables[faces.table].size() / 3);
    if (count > 0) {
      for (std::uint32_t i = 3 * (random() % 60); i > 0; --i) faces.indices.push_back(random() % count);
    }
    mesh.primitives.push_back(std::move(faces));
  }
  return mesh;
}

EncodeOptions randomOptions(std::mt19937& random) {
  EncodeOptions options;
  options.step = std::ldexp(1.0 + random() % 1000 / 1000.0, -static_cast<int>(random() % 12));
  options.anchored = random() % 2 == 0;
  options.normal_scale = 1 + random() % 16;
  options.mode = static_cast<Mode>(random() % 3);
  options.basis = static_cast<Basis>(random() % 3);
  options.predictor = static_cast<Predictor>(random() % 6);
  options.order = static_cast<Order>(random() % 3);
  options.effort = static_cast<Effort>(random() % 2);
  return options;
}

TEST(Codec, SamplesWithEveryChoice) {
  for (const auto& [name, triangles] : meshes::samples()) {
    const OwnedMesh mesh(triangles);
    for (const auto& [choice, forced] : allChoices()) {
      EncodeOptions options = forced;
      options.step = stepForBits(mesh.mesh(), 11);
      const RoundTrip trip = roundTrip(mesh, options);
      ASSERT_EQ(trip.fault, "") << name << ", " << choice;
      EXPECT_EQ(trip.encoded.modes.mode, options.mode);
      EXPECT_EQ(trip.encoded.modes.basis, options.basis);
      EXPECT_EQ(trip.encoded.modes.predictor, options.predictor);
      EXPECT_EQ(trip.encoded.modes.order, options.order);
    }
  }
}

TEST(Codec, SamplesAsTheEncoderChooses) {
  for (const auto& [name, triangles] : meshes::samples()) {
    for (const int bits : {1, 6, 14, 20}) {
      for (const bool anchored : {false, true}) {
        EncodeOptions options;
        options.step = stepForBits(triangles.mesh(), bits);
        options.anchored = anchored;
        ASSERT_EQ(roundTrip(OwnedMesh(triangles), options).fault, "") << name << ", " << bits << " bits";
      }
    }
  }
}

TEST(Codec, EveryNormalScale) {
  const OwnedMesh mesh(meshes::torus(9, 11));
  for (std::uint32_t scale = 1; scale <= 16; ++scale) {
    EncodeOptions options;
    options.step = 0.01;
    options.normal_scale = scale;
    const RoundTrip trip = roundTrip(mesh, options);
    ASSERT_EQ(trip.fault, "") << scale;
    EXPECT_EQ(trip.encoded.modes.normal_scale, trip.encoded.modes.mode == Mode::kTangent ? scale : 1);
  }
}

TEST(Codec, RandomSoupsWithRandomOptions) {
  std::mt19937 random(1);
  for (int i = 0; i < 4000; ++i) {
    const OwnedMesh mesh = randomSoup(random);
    const EncodeOptions options = randomOptions(random);
    const RoundTrip trip = roundTrip(mesh, options);
    ASSERT_EQ(trip.fault, "") << "soup " << i;
    if (i % 8 == 0) {
      const auto again = encode(mesh.mesh(), options);
      ASSERT_TRUE(again);
      ASSERT_EQ(again->bytes, trip.encoded.bytes) << "soup " << i;
    }
  }
}

TEST(Codec, IntegerPositionsComeBackExactly) {
  struct Range {
    ComponentType type;
    std::int32_t lowest, highest;
  };
  const Range ranges[] = {{ComponentType::kInt8, -128, 127},
                          {ComponentType::kUint8, 0, 255},
                          {ComponentType::kInt16, -32768, 32767},
                          {ComponentType::kUint16, 0, 65535}};
  std::mt19937 random(2);
  for (const Range& range : ranges) {
    for (int i = 0; i < 100; ++i) {
      OwnedMesh mesh = randomSoup(random);
      mesh.position_type = range.type;
      const auto width = static_cast<std::uint32_t>(range.highest - range.lowest + 1);
      for (std::vector<float>& table : mesh.tables) {
        for (float& x : table) x = static_cast<float>(range.lowest + static_cast<std::int32_t>(random() % width));
        if (table.size() >= 3) {
          table[0] = static_cast<float>(range.lowest);
          table[1] = static_cast<float>(range.highest);
        }
      }
      EncodeOptions options = randomOptions(random);
      options.step = 0;  // ignored
      ASSERT_EQ(guaranteedError(mesh.mesh(), options), 0);
      const RoundTrip trip = roundTrip(mesh, options);
      ASSERT_EQ(trip.fault, "") << "type " << static_cast<int>(range.type) << ", soup " << i;
      EXPECT_EQ(trip.encoded.modes.mode, Mode::kLattice);
    }
  }
}

TEST(Codec, EqualPositionsStayEqualAcrossTablesAndPrimitives) {
  // The same sheet in two tables, once with -0 for 0; a third primitive with its own corner vertices.
  const Triangles sheet = meshes::grid(6, 5, [](float x, float y) { return x * 0.37f - y * 0.21f; });
  OwnedMesh mesh(sheet);
  mesh.tables.push_back(sheet.positions);
  for (float& x : mesh.tables[1]) x = x == 0 ? -0.0f : x;
  mesh.primitives.push_back({1, sheet.indices});
  std::vector<float> loose;
  OwnedMesh::Faces faces{2, {}};
  for (const std::uint32_t index : sheet.indices) {
    faces.indices.push_back(static_cast<std::uint32_t>(loose.size() / 3));
    for (std::uint32_t a = 0; a < 3; ++a) loose.push_back(sheet.positions[3 * index + a]);
  }
  mesh.tables.push_back(loose);
  mesh.primitives.push_back(faces);
  for (const auto& [choice, forced] : allChoices()) {
    EncodeOptions options = forced;
    options.step = 0.003;
    const RoundTrip trip = roundTrip(mesh, options);
    ASSERT_EQ(trip.fault, "") << choice;
    EXPECT_EQ(trip.encoded.unique_positions, 42u);
  }
}

TEST(Codec, LatticeModeHasNoGenerationLoss) {
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    OwnedMesh mesh = i < 50 ? OwnedMesh(meshes::torus(5 + i % 7, 6)) : randomSoup(random);
    EncodeOptions options = randomOptions(random);
    if (i < 50) options.step = 0.001 * (i + 1);
    options.mode = Mode::kLattice;
    options.anchored = true;
    const RoundTrip first = roundTrip(mesh, options);
    ASSERT_EQ(first.fault, "") << i;
    const RoundTrip second = roundTrip(toInput(first.decoded, mesh), options);
    ASSERT_EQ(second.fault, "") << i;
    ASSERT_EQ(second.encoded.max_error, 0) << i;
  }
}

TEST(Codec, TangentModeStaysWithinTheBoundOverGenerations) {
  OwnedMesh mesh(meshes::sphere(12, 15));
  EncodeOptions options;
  options.step = 0.01;
  options.mode = Mode::kTangent;
  options.anchored = true;
  for (int generation = 0; generation < 5; ++generation) {
    const RoundTrip trip = roundTrip(mesh, options);
    ASSERT_EQ(trip.fault, "") << generation;
    mesh = toInput(trip.decoded, mesh);
  }
}

TEST(Codec, ThePaperRunsAsPublished) {
  EncodeOptions paper;
  paper.mode = Mode::kTangent;
  paper.predictor = Predictor::kWeighted;
  paper.basis = Basis::kTip;
  paper.order = Order::kTraversal;
  paper.normal_scale = 2;
  for (const auto& [name, triangles] : meshes::samples()) {
    paper.step = stepForBits(triangles.mesh(), 12);
    const RoundTrip trip = roundTrip(OwnedMesh(triangles), paper);
    ASSERT_EQ(trip.fault, "") << name;
    EXPECT_EQ(trip.encoded.modes.mode, Mode::kTangent);
    EXPECT_EQ(trip.encoded.modes.predictor, Predictor::kWeighted);
    EXPECT_EQ(trip.encoded.modes.basis, Basis::kTip);
    EXPECT_EQ(trip.encoded.modes.order, Order::kTraversal);
    EXPECT_EQ(trip.encoded.modes.normal_scale, 2u);
  }
}

TEST(Codec, SizesAndNames) {
  EXPECT_EQ(componentSize(ComponentType::kInt8), 1u);
  EXPECT_EQ(componentSize(ComponentType::kUint16), 2u);
  EXPECT_EQ(componentSize(ComponentType::kFloat32), 4u);
  EXPECT_EQ(positionStride(ComponentType::kUint8), 4u);
  EXPECT_EQ(positionStride(ComponentType::kInt16), 8u);
  EXPECT_EQ(positionStride(ComponentType::kFloat32), 12u);
  EXPECT_EQ(describe({ErrorCode::kTrailingData, "end of stream", 17, 21, 17}),
            "trailing data in end of stream at byte 17: found 21, expected 17");
  EXPECT_EQ(describe({ErrorCode::kOutputMismatch, "an output", 0, 1, 2}),
            "output size mismatch in an output at byte 0: found 1, expected 2");
  EXPECT_EQ(describe({ErrorCode::kInvalidArgument, "step", 0, 0, 1}), "invalid argument in step: found 0, expected 1");
}

}  // namespace
}  // namespace tsc::test
