// The paper's Figure 2, on a small plane.
#include "plane.h"

#include <gtest/gtest.h>

#include "plane_model.h"

namespace tsc::bench {
namespace {

TEST(Plane, measuresEveryRowAtTheRateWanted) {
  PlaneOptions options;
  options.side = 24;
  options.bits_per_vertex = 15;
  const std::vector<PlaneRow> rows = measurePlane(options);
  EXPECT_GE(rows.size(), 8u);
  for (const PlaneRow& row : rows) {
    EXPECT_EQ(row.error, "") << row.codec;
    const bool is_draco = row.codec.starts_with("draco");  // its settings are whole numbers
    EXPECT_NEAR(row.bits_per_vertex, 15, is_draco ? 2 : 0.3) << row.codec;
    EXPECT_GT(row.rms, 0) << row.codec;
  }
  EXPECT_NE(planeTable(rows).find("world space"), std::string::npos);
}

TEST(PaperModel, keepsAPlaneWhoseFirstTriangleIsExact) {
  const BenchMesh mesh = makePlane(30, 17.5);
  const double step = stepForBits(codecMesh(mesh), 9);
  const CodecPoint exact = makePaperModel(mesh, {})(step);
  const CodecPoint rounded = makePaperModel(mesh, {.exact_start = false})(step);
  const double dame_exact = measureDistortion(mesh, exact.positions).dame;
  const double dame_rounded = measureDistortion(mesh, rounded.positions).dame;
  EXPECT_LT(dame_exact, 0.01 * dame_rounded);
  EXPECT_LT(exact.bits, rounded.bits);
  EXPECT_LT(exact.mse, step * step);
}

TEST(PaperModel, refusesAMeshInTwoParts) {
  BenchMesh mesh = makePlane(3, 0);
  const auto count = static_cast<std::uint32_t>(mesh.vertexCount());
  const BenchMesh other = mesh;
  for (const float value : other.positions) mesh.positions.push_back(value + 5);
  for (const std::uint32_t index : other.indices) mesh.indices.push_back(index + count);
  EXPECT_THROW(makePaperModel(mesh, {})(0.1), std::runtime_error);
}

}  // namespace
}  // namespace tsc::bench
