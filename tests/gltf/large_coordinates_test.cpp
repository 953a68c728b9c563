// Georeferenced meshes: offsets of millions of metres, millimetre detail, large node translations.
#include <gtest/gtest.h>

#include <cmath>

#include "assets.h"
#include "compare_assets.h"

namespace tsc::test {
namespace {

/// A grid of `spacing` around 6 378 137 m, 3 000 000 m, 6e6 m; floats are half a metre apart there.
Asset farGrid(float spacing) {
  AssetBuilder builder;
  std::vector<float> xyz = gridPositions(12);
  for (std::size_t i = 0; i < xyz.size(); i += 3) {
    xyz[i] = 6378137.0F + xyz[i] * spacing;
    xyz[i + 1] = -3000000.0F + xyz[i + 1] * spacing;
    xyz[i + 2] = 6000000.0F + xyz[i + 2] * spacing;
  }
  const std::size_t position = builder.addPositions(xyz);
  const std::size_t indices = builder.addIndices16(gridIndices(12));
  builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", indices}}});
  return builder.build();
}

TEST(LargeCoordinates, TheBoundHoldsForEveryPrecision) {
  using Kind = Precision::Kind;
  for (const float spacing : {0.5F, 10.0F, 1000.0F}) {
    for (const Precision precision : {Precision{Kind::kPositionBits, 8}, Precision{Kind::kPositionBits, 14},
                                      Precision{Kind::kStep, 0.25}, Precision{Kind::kMaxError, 2.0}}) {
      for (const Mode mode : {Mode::kLattice, Mode::kTangent}) {
        PackOptions options;
        options.precision = precision;
        options.mode = mode;
        const PackReport report = expectRoundTrip(farGrid(spacing), options);  // compares with the bound
        ASSERT_EQ(report.streams.size(), 1U);
        if (precision.kind == Kind::kMaxError) {
          EXPECT_LE(report.streams[0].guaranteed_error, precision.value);
          EXPECT_LE(report.streams[0].max_error, precision.value);
        }
      }
    }
  }
}

TEST(LargeCoordinates, ABoundFinerThanTheFloatsIsRefused) {
  PackOptions options;
  options.precision = {Precision::Kind::kMaxError, 1e-3};
  Asset asset = farGrid(10);
  const Expected<PackReport> report = packAsset(asset, options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.failure().kind, FailureKind::kBound);
  EXPECT_NE(report.failure().message.find("coarser"), std::string::npos) << report.failure().message;
}

TEST(LargeCoordinates, LocalDetailUnderALargeTranslationIsMillimetres) {
  AssetBuilder builder;
  std::vector<float> xyz = gridPositions(12);
  for (float& value : xyz) value = value * 0.01F + 1.0F / 3;
  const std::size_t position = builder.addPositions(xyz);
  const std::size_t indices = builder.addIndices16(gridIndices(12));
  builder.addMesh({{{"attributes", {{"POSITION", position}}}, {"indices", indices}}});
  builder.document()["nodes"] =
      Json::parse(R"([{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,4187562.123456789,-1234567.000000001,6e6,1]},
                      {"translation":[6378137.123456789,0.1,-3000000.0000001],"children":[0]}])");
  PackOptions options;
  options.precision = {Precision::Kind::kMaxError, 1e-4};
  const Asset asset = builder.build();
  const PackReport report = expectRoundTrip(asset, options);
  ASSERT_EQ(report.streams.size(), 1U);
  EXPECT_LE(report.streams[0].max_error, 1e-4);
  Asset packed = asset;
  ASSERT_TRUE(packAsset(packed, options));
  EXPECT_EQ(writeJson(packed.document["nodes"]), writeJson(asset.document["nodes"]));
}

}  // namespace
}  // namespace tsc::test
