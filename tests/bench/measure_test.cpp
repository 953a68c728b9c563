// Codecs under measurement.
#include "measure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

namespace tsc::bench {
namespace {

TEST(SelectVariants, knowsItsNames) {
  EXPECT_EQ(selectVariants("auto,max", Effort::kDefault).size(), 2u);
  EXPECT_GE(selectVariants("all", Effort::kDefault).size(), 12u);
  EXPECT_EQ(selectVariants("auto", Effort::kMax)[0].options.effort, Effort::kMax);
  EXPECT_THROW(selectVariants("nonsense", Effort::kDefault), std::runtime_error);
}

TEST(MakeCodec, ofEveryVariantHasAnErrorNearItsStep) {
  const BenchMesh mesh = subdivide(makePlane(20, 17.5));
  const double step = stepForBits(codecMesh(mesh), 11);
  for (const Variant& variant : selectVariants("all", Effort::kDefault)) {
    const CodecPoint point = makeCodec(mesh, variant)(step);
    EXPECT_GT(point.bits, 0) << variant.name;
    // Uniform rounding gives step^2 / 4; least squares smears the Laplacian's errors out over the mesh.
    EXPECT_GT(point.mse, 0) << variant.name;
    EXPECT_LT(point.mse, (variant.is_laplacian ? 1000 : 0.5) * step * step) << variant.name;
  }
}

TEST(PointAtRate, hitsTheRate) {
  const BenchMesh mesh = makePlane(20, 0);
  const StepCodec codec = [](double step) {
    CodecPoint point;
    point.step = step;
    point.bits = 1e5 - 1e4 * std::log2(step);
    point.mse = step * step;
    return point;
  };
  for (const double target : {3e4, 1e5, 1.7e5}) {
    std::vector<CodecPoint> runs = {codec(1), codec(2)};
    EXPECT_NEAR(pointAtRate(codec, runs, target).bits / target, 1, kRateTolerance);
  }
}

TEST(DracoCache, remembersAndSurvivesACutLine) {
  const auto folder = std::filesystem::temp_directory_path() / "tsc_bench_cache_test";
  std::filesystem::remove_all(folder);
  const BenchMesh mesh = makePlane(20, 17.5);
  const auto first = DracoCache(folder).rate(mesh, "key", 10, 11);
  std::ofstream(folder / "draco-rate.csv", std::ios::app) << "\nkey-cl10-qp11,12";
  const auto second = DracoCache(folder).rate(mesh, "key", 10, 11);
  EXPECT_EQ(first.bits, second.bits);
  EXPECT_NEAR(first.mse / second.mse, 1, 1e-12);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace tsc::bench
