// Packing what was unpacked, again and again, at the same step.
#include <gtest/gtest.h>

#include <cmath>

#include "assets.h"
#include "compare_assets.h"

namespace tsc::test {
namespace {

/// A bumpy sheet cut into two primitives with tables of their own, an unindexed one beside them; no coordinate lies on
/// a lattice.
Asset sheetAsset() {
  AssetBuilder builder;
  std::vector<float> xyz = gridPositions(16);
  for (float& value : xyz) value = value * 0.731F + 0.0137F;
  const std::vector<std::uint32_t> all = gridIndices(16);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 6 * 3);
  const std::size_t left = builder.addPositions(xyz), right = builder.addPositions(xyz);
  std::vector<float> loose(xyz.begin(), xyz.begin() + 3 * 30);
  builder.addMesh({{{"attributes", {{"POSITION", left}}}, {"indices", builder.addIndices16({all.begin(), middle})}},
                   {{"attributes", {{"POSITION", right}}}, {"indices", builder.addIndices16({middle, all.end()})}},
                   {{"attributes", {{"POSITION", builder.addPositions(loose)}}}}});
  Asset asset = builder.build();
  addVertexIds(asset);
  return asset;
}

PackOptions withStep(Mode mode, double step) {
  PackOptions options;
  options.precision = {Precision::Kind::kStep, step};
  options.mode = mode;
  return options;
}

/// Packs, writes, reads and unpacks. `report` gets that of the stream.
Asset nextGeneration(const Asset& asset, const PackOptions& options, StreamReport& report) {
  Asset packed = asset;
  const Expected<PackReport> done = packAsset(packed, options);
  EXPECT_TRUE(done) << done.failure().message;
  if (done) report = done->streams.at(0);
  const Expected<std::vector<std::byte>> glb = writeGlb(packed);
  EXPECT_TRUE(glb);
  const Expected<std::vector<std::byte>> plain = expand(*glb);
  EXPECT_TRUE(plain) << plain.failure().message;
  return *loadAsset(*plain, "generation");
}

/// The largest distance between the same vertices of two assets.
double largestMove(const Asset& a, const Asset& b) {
  const std::vector<PrimitiveContent> before = contentOf(a), after = contentOf(b);
  EXPECT_EQ(before.size(), after.size());
  double largest = 0;
  for (std::size_t p = 0; p < before.size(); ++p) {
    EXPECT_EQ(before[p].triangles, after[p].triangles) << p;
    for (const auto& [id, position] : before[p].positions) {
      const std::array<float, 3>& other = after[p].positions.at(id);
      largest = std::max(largest, std::hypot(double{position[0]} - other[0], double{position[1]} - other[1],
                                             double{position[2]} - other[2]));
    }
  }
  return largest;
}

constexpr int kGenerations = 6;

TEST(Generations, OnTheLatticeNothingMovesAgain) {
  const Asset original = sheetAsset();
  for (const double step : {0.01, 0.25, 1.0 / 3}) {
    const PackOptions options = withStep(Mode::kLattice, step);
    StreamReport report;
    const Asset first = nextGeneration(original, options, report);
    EXPECT_GT(largestMove(original, first), 0);
    Asset last = first;
    for (int generation = 1; generation < kGenerations; ++generation) {
      last = nextGeneration(last, options, report);
      EXPECT_EQ(report.max_error, 0) << "generation " << generation << " at step " << step;
      EXPECT_EQ(largestMove(first, last), 0) << "generation " << generation << " at step " << step;
    }
  }
}

/// In tangent mode points lie where the local bases put them, and may move once more if the bases differ.
TEST(Generations, InTangentModeEachStaysWithinTheBoundOfTheLast) {
  const Asset original = sheetAsset();
  for (const Mode mode : {Mode::kTangent, Mode::kAuto}) {
    for (const double step : {0.01, 0.25}) {
      const PackOptions options = withStep(mode, step);
      Asset last = original;
      for (int generation = 0; generation < kGenerations; ++generation) {
        StreamReport report;
        const Asset next = nextGeneration(last, options, report);
        EXPECT_LE(largestMove(last, next), report.guaranteed_error) << "generation " << generation;
        last = next;
      }
    }
  }
}

}  // namespace
}  // namespace tsc::test
