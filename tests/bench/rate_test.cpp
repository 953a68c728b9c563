// One mesh measured, and sets of measurements summarised.
#include "rate.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

namespace tsc::bench {
namespace {

VariantRate variantRate(const std::string& name, double bd10, double mse7) {
  VariantRate rate;
  rate.name = name;
  rate.curve.resize(1);
  rate.curve[0].bits = 100;
  rate.curve[0].parts.connectivity = 10;
  rate.curve[0].parts.header = 5;
  rate.bd7 = rate.bd10 = bd10;
  rate.at7.mse = mse7;
  return rate;
}

MeshRate meshRate(const std::string& class_name, const std::string& name, std::vector<VariantRate> variants) {
  MeshRate mesh;
  mesh.class_name = class_name;
  mesh.name = name;
  mesh.vertices = 10;
  mesh.bits = {kReferenceBits};
  mesh.draco7 = mesh.draco10 = {{200, 20, 1}};
  mesh.variants = std::move(variants);
  return mesh;
}

TEST(Summarize, countsAVariantWhereItWasMeasured) {
  std::vector<MeshRate> meshes = {
      meshRate("cad", "a", {variantRate("auto", -0.1, 0.5)}),
      meshRate("cad", "b", {variantRate("auto", 0.3, 2)}),
      meshRate("organic", "c", {variantRate("auto", -0.2, 0.125)}),
  };
  mergeRates(meshes, {meshRate("cad", "b", {variantRate("max", -0.4, 0.25)})});
  ASSERT_EQ(meshes.size(), 3u);
  ASSERT_EQ(meshes[1].variants.size(), 2u);

  const std::vector<RateSummary> summaries = summarize(meshes);
  ASSERT_EQ(summaries.size(), 5u);  // cad auto and max, organic auto, all auto and max
  EXPECT_EQ(summaries[0].variant, "auto");
  EXPECT_EQ(summaries[0].meshes, 2u);
  EXPECT_DOUBLE_EQ(summaries[0].bd10.worst, 0.3);
  EXPECT_EQ(summaries[0].worst_bd10_mesh, "b");
  EXPECT_DOUBLE_EQ(summaries[0].mse7.mean, 1);  // geometric
  EXPECT_DOUBLE_EQ(summaries[0].connectivity_ratio, 0.5);
  EXPECT_DOUBLE_EQ(summaries[0].connectivity_all_ratio, 0.75);
  EXPECT_EQ(summaries[1].variant, "max");
  EXPECT_EQ(summaries[1].meshes, 1u);
  EXPECT_EQ(summaries[3].group, "all");
  EXPECT_EQ(summaries[3].meshes, 3u);
}

TEST(Summarize, leavesFailuresOutOfTheFigures) {
  VariantRate broken;
  broken.name = "auto";
  broken.error = "refused";
  const std::vector<RateSummary> summaries =
      summarize({meshRate("c", "a", {variantRate("auto", -0.1, 0.5)}), meshRate("c", "b", {broken})});
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0].failed, 1u);
  EXPECT_EQ(summaries[0].bd10.count, 1u);
  EXPECT_NE(summaryTable(summaries).find("FAILED"), std::string::npos);
}

class MeasureRate : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("tsc_bench_rate_test_" + std::to_string(getpid()));
  const BenchMesh mesh_ = subdivide(makePlane(12, 17.5));
};

TEST_F(MeasureRate, givesEveryRatioOfEveryVariant) {
  DracoCache cache(folder_);
  RateOptions options;
  options.bits = {10, 11, 12};
  options.variants = selectVariants("auto,paper-eq7-n2,laplacian", Effort::kDefault);
  const MeshRate rate = measureRate(mesh_, options, cache);
  ASSERT_EQ(rate.variants.size(), 3u);
  for (const VariantRate& variant : rate.variants) {
    EXPECT_EQ(variant.error, "") << variant.name;
    EXPECT_EQ(variant.curve.size(), 3u) << variant.name;
    EXPECT_TRUE(variant.curve[0].positions.empty()) << variant.name;
    EXPECT_TRUE(variant.at7.mse && variant.at7.metro && variant.at7.dame) << variant.name;
    EXPECT_TRUE(variant.at10.mse && variant.at10.metro && variant.at10.dame) << variant.name;
  }
  EXPECT_TRUE(rate.variants[0].bd7 && rate.variants[0].bd10);
  EXPECT_EQ(measureRate(mesh_, options, cache).variants[0].bd10, rate.variants[0].bd10);
}

TEST_F(MeasureRate, fastLeavesMetroAndDameOut) {
  DracoCache cache(folder_);
  RateOptions options;
  options.variants = selectVariants("auto", Effort::kDefault);
  options.with_metrics = false;
  const MeshRate rate = measureRate(mesh_, options, cache);
  EXPECT_TRUE(rate.variants[0].at7.mse);
  EXPECT_FALSE(rate.variants[0].at10.metro);
  EXPECT_FALSE(rate.variants[0].at10.dame);
}

}  // namespace
}  // namespace tsc::bench
