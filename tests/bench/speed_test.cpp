// Timing: who takes part, and what is made of the times. Times themselves are asserted nowhere.
#include "speed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "heap.h"

namespace tsc::bench {
namespace {

MeshSpeed someSpeed(const std::string& name, std::size_t vertices, double ours, double draco) {
  MeshSpeed mesh{name, "c", vertices, 2 * vertices, {}};
  for (const char* codec : {"draco-cl7", "draco-cl10", "meshopt", "memcpy"}) {
    mesh.codecs.push_back({codec, "", 1000, draco, draco, 8e3, 4e3});
  }
  mesh.codecs.push_back({"auto", "", 900, ours, ours, 6e3, 2e3});
  return mesh;
}

TEST(MeasureSpeed, timesEveryCodecOnTheSameMesh) {
  const BenchMesh mesh = subdivide(makePlane(10, 17.5));
  SpeedOptions options;
  options.variants = selectVariants("auto,laplacian", Effort::kDefault);
  options.runs = 1;
  const MeshSpeed speed = measureSpeed(mesh, options);
  EXPECT_EQ(speed.vertices, mesh.vertexCount());
  ASSERT_EQ(speed.codecs.size(), 5u) << "the Laplacian baseline has no stream to time";
  for (const char* name : {"draco-cl7", "draco-cl10", "meshopt", "memcpy", "auto"}) {
    const CodecSpeed& codec = speed.codec(name);
    EXPECT_EQ(codec.error, "") << name;
    EXPECT_GT(codec.bytes, 0) << name;
    // Each decoder holds its result at least: 12 bytes a vertex, or 8 of meshoptimizer's.
    EXPECT_GE(codec.decode_peak_bytes, 8.0 * double(mesh.vertexCount())) << name;
  }
  EXPECT_EQ(speed.codec("memcpy").bytes, 12.0 * double(mesh.vertexCount() + mesh.faceCount()));
  EXPECT_THROW(speed.codec("none"), std::runtime_error);
}

TEST(MeasureSpeed, keepsGoingWhenACodecRefuses) {
  const BenchMesh mesh = makePlane(10, 0);
  SpeedOptions options;
  options.variants = selectVariants("auto", Effort::kDefault);
  options.variants[0].options.normal_scale = 99;  // out of range
  options.runs = 1;
  const MeshSpeed speed = measureSpeed(mesh, options);
  EXPECT_NE(speed.codec("auto").error, "");
  EXPECT_EQ(speed.codec("draco-cl10").error, "");
  EXPECT_NE(speedLines(speed).find("error"), std::string::npos);
  EXPECT_FALSE(speedMedians({speed}, "auto"));
}

TEST(SpeedMedians, areOfTheMeshesRatios) {
  const std::vector<MeshSpeed> meshes = {someSpeed("a", 100, 1e3, 4e3), someSpeed("b", 100, 1e3, 2e3),
                                         someSpeed("c", 200, 2e3, 2e3)};
  const auto medians = speedMedians(meshes, "auto");
  ASSERT_TRUE(medians);
  EXPECT_EQ(medians->meshes, 3u);
  EXPECT_DOUBLE_EQ(medians->decode_speed, 2);
  EXPECT_DOUBLE_EQ(medians->encode_time, 0.5);
  EXPECT_DOUBLE_EQ(medians->decode_peak_bytes_a_vertex, 20);
  EXPECT_FALSE(speedMedians(meshes, "max"));
  EXPECT_TRUE(speedSummary({}).empty());
  EXPECT_NE(speedSummary(meshes).find("3 meshes of 100 vertices"), std::string::npos);
}

TEST(SpeedJson, comesBackAsItWas) {
  MeshSpeed mesh = someSpeed("a", 100, 1.0 / 3, 7);
  mesh.codecs[4].error = "a \"quoted\" reason";
  const auto back = nlohmann::json::parse(nlohmann::json(mesh).dump()).get<MeshSpeed>();
  EXPECT_EQ(speedCsv({back}), speedCsv({mesh}));
  EXPECT_EQ(back.codec("auto").decode_ns, 1.0 / 3);
  EXPECT_EQ(back.codec("auto").error, mesh.codecs[4].error);
}

TEST(SizeSeries, growsFromPatchesToSubdivisions) {
  const std::vector<BenchMesh> series = sizeSeries(makePlane(60, 0), 10000);
  ASSERT_EQ(series.size(), 3u);
  for (std::size_t i = 0; i < series.size(); ++i) {
    const double wanted[] = {1000, 3000, 10000};
    EXPECT_NEAR(double(series[i].vertexCount()), wanted[i], 0.01 * wanted[i]);
  }
}

TEST(PeakHeap, countsWhatIsHeldAtATime) {
  const std::size_t peak = peakHeapBytes([] {
    for (int i = 0; i < 3; ++i) std::vector<char>(1 << 20).data()[0] = 1;
    const std::vector<char> first(1 << 20), second(1 << 20);
  });
  EXPECT_GE(peak, std::size_t{2} << 20);
  EXPECT_LT(peak, std::size_t{3} << 20);
}

}  // namespace
}  // namespace tsc::bench
