// The peers are run as their own tools run them.
#include "peers.h"

#include <gtest/gtest.h>

#include "measure.h"

namespace tsc::bench {
namespace {

class Peers : public testing::TestWithParam<int> {
 protected:
  const BenchMesh mesh_ = subdivide(makePlane(30, 17.5));
};

TEST_P(Peers, dracoInPartsGivesDracosBytes) {
  const DracoMesh draco(mesh_);
  const DracoStream whole = encodeDraco(draco, GetParam(), 11), parts = encodeDracoInParts(draco, GetParam(), 11);
  EXPECT_EQ(whole.bytes, parts.bytes);
  EXPECT_GT(parts.connectivity_bytes, 0u);
  EXPECT_LT(parts.connectivity_bytes, parts.bytes.size());
}

TEST_P(Peers, dracosDistortionByItsDecoderIsThatOfItsGrid) {
  for (const int bits : {8, 11, 14, 16}) {
    const DecodedDraco decoded = decodeDraco(encodeDraco(DracoMesh(mesh_), GetParam(), bits).bytes);
    const DracoDistortion distortion = dracoDistortion(mesh_, decoded, bits);
    EXPECT_EQ(decoded.face_count, mesh_.faceCount());
    EXPECT_EQ(distortion.dropped_vertices, 0u);
    EXPECT_NEAR(distortion.mse_by_decoder / distortion.mse_by_grid, 1, 0.01);
  }
}

INSTANTIATE_TEST_SUITE_P(Levels, Peers, testing::Values(7, 10));

TEST(Meshopt, decodesWhatItEncodes) {
  const BenchMesh mesh = makePlane(20, 17.5);
  const auto stream = MeshoptCodec::encode(mesh);
  EXPECT_GT(stream.bytes(), 0u);
  EXPECT_EQ(stream.vertex_count, mesh.vertexCount());
  MeshoptCodec::decode(stream);
}

}  // namespace
}  // namespace tsc::bench
