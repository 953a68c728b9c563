#include "precision.h"

#include <gtest/gtest.h>

#include "assets.h"

namespace tsc::test {
namespace {

PackReport packWith(Precision::Kind kind, double value) {
  Asset asset = gridAsset(20);
  PackOptions options;
  options.precision = {kind, value};
  Expected<PackReport> report = packAsset(asset, options);
  EXPECT_TRUE(report) << (report ? "" : report.failure().message);
  return report ? *report : PackReport{};
}

TEST(PrecisionOptions, BoundsAreMetAndUsed) {
  for (const double bound : {1.0, 0.01, 0.0001}) {
    const PackReport report = packWith(Precision::Kind::kMaxError, bound);
    ASSERT_EQ(report.streams.size(), 1U);
    EXPECT_LE(report.streams[0].max_error, bound);
    EXPECT_LE(report.streams[0].guaranteed_error, bound);
    EXPECT_GT(report.streams[0].guaranteed_error, bound * 0.9);
  }
  const PackReport relative = packWith(Precision::Kind::kRelativeError, 0.001);
  ASSERT_EQ(relative.streams.size(), 1U);
  EXPECT_LE(relative.streams[0].max_error, 0.001 * relative.streams[0].diagonal);
}

TEST(PrecisionOptions, BoundsBelowFloatPrecisionAreRefused) {
  AssetBuilder builder;
  const std::size_t position = builder.addPositions(gridPositions(4, 6.0e6F));
  const std::size_t indices = builder.addIndices16(gridIndices(4));
  builder.addMesh(Json::array({Json{{"attributes", {{"POSITION", position}}}, {"indices", indices}}}));
  Asset asset = builder.build();
  PackOptions options;
  options.precision = {Precision::Kind::kMaxError, 1e-9};
  const Expected<PackReport> report = packAsset(asset, options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.failure().kind, FailureKind::kBound);
}

TEST(PrecisionOptions, TargetRateIsApproached) {
  const PackReport report = packWith(Precision::Kind::kTargetBpv, 6);
  ASSERT_EQ(report.streams.size(), 1U);
  const double rate =
      static_cast<double>(report.streams[0].stream_bytes) * 8 / static_cast<double>(report.streams[0].vertices);
  EXPECT_LE(rate, 6);
  EXPECT_GT(rate, 5);
}

TEST(PrecisionOptions, ImpossibleOnesAreUsageFailures) {
  for (const Precision precision :
       {Precision{Precision::Kind::kPositionBits, 0}, Precision{Precision::Kind::kPositionBits, 25},
        Precision{Precision::Kind::kPositionBits, 7.5}, Precision{Precision::Kind::kStep, 0},
        Precision{Precision::Kind::kMaxError, -1}}) {
    Asset asset = gridAsset();
    PackOptions options;
    options.precision = precision;
    const Expected<PackReport> report = packAsset(asset, options);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.failure().kind, FailureKind::kUsage);
  }
}

}  // namespace
}  // namespace tsc::test
