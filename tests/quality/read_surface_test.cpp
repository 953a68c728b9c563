#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "meshes.h"

namespace tsc {
namespace {

std::filesystem::path written(const std::string& name, const std::string& bytes) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("tsc_quality_" + name);
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

const std::vector<double> kQuadPositions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5};
const std::vector<std::uint32_t> kQuadIndices = {0, 1, 2, 0, 2, 3};

void expectQuad(const Measured<NamedSurface>& mesh) {
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->positions, kQuadPositions);
  EXPECT_EQ(mesh->indices, kQuadIndices);
}

QualityErrorCode codeOf(const std::string& name, const std::string& bytes) {
  const auto mesh = readSurfaceFile(written(name, bytes));
  EXPECT_FALSE(mesh);
  return mesh ? QualityErrorCode::kNoFaces : mesh.error().code;
}

template <class T>
void put(std::string& bytes, T value, bool big) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string binaryPly(bool big) {
  std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\ncomment x\nelement vertex 4\nproperty double z\nproperty float x\n"
                      "property uchar red\nproperty float y\nelement face 1\nproperty list uchar int vertex_indices\n"
                      "element edge 1\nproperty int vertex1\nend_header\n";
  for (int v = 0; v < 4; ++v) {
    put<double>(bytes, kQuadPositions[3 * v + 2], big);
    put<float>(bytes, static_cast<float>(kQuadPositions[3 * v]), big);
    put<std::uint8_t>(bytes, 200, big);
    put<float>(bytes, static_cast<float>(kQuadPositions[3 * v + 1]), big);
  }
  put<std::uint8_t>(bytes, 4, big);
  for (int k = 0; k < 4; ++k) put<std::int32_t>(bytes, k, big);
  put<std::int32_t>(bytes, 7, big);
  return bytes;
}

TEST(ReadSurface, PlyInBothByteOrders) {
  expectQuad(readSurfaceFile(written("little.ply", binaryPly(false))));
  expectQuad(readSurfaceFile(written("big.PLY", binaryPly(true))));
}

const std::string kAsciiPly =
    "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
    "element face 2\r\nproperty list uchar uint vertex_index\r\nend_header\r\n"
    "0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0.5\r\n3 0 1 2\r\n3 0 2 3\r\n";

TEST(ReadSurface, PlyAscii) { expectQuad(readSurfaceFile(written("ascii.ply", kAsciiPly))); }

TEST(ReadSurface, PlyCutAtAnyLength) {
  const std::string binary = binaryPly(false);
  for (std::size_t length = 0; length < binary.size(); ++length) {
    EXPECT_EQ(codeOf("cut.ply", binary.substr(0, length)), QualityErrorCode::kInvalidFile) << length;
  }
}

TEST(ReadSurface, PlyWithHostileCounts) {
  std::string huge = binaryPly(false);
  huge.replace(huge.find("vertex 4"), 8, "vertex 9999999999999");
  EXPECT_EQ(codeOf("huge.ply", huge), QualityErrorCode::kInvalidFile);
  std::string past = kAsciiPly;
  past.replace(past.find("3 0 2 3"), 7, "3 0 2 4");
  EXPECT_EQ(codeOf("past.ply", past), QualityErrorCode::kInvalidFile);
  past.replace(past.find("3 0 2 4"), 7, "3 0 2 -1");
  EXPECT_EQ(codeOf("negative.ply", past), QualityErrorCode::kInvalidFile);
}

TEST(ReadSurface, Obj) {
  expectQuad(readSurfaceFile(written("quad.obj",
                                     "# quad\no part\nv 0 0 0\nv 1 0 0\nv 1 1 0 1\nvn 0 0 1\nvt 0 0\nv 0 1 .5\n"
                                     "g side\nusemtl m\nf 1/1/1 2//1 -2/1 4\n")));
  EXPECT_EQ(codeOf("past.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4\n"), QualityErrorCode::kInvalidFile);
  EXPECT_EQ(codeOf("zero.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 0 1 2\n"), QualityErrorCode::kInvalidFile);
  EXPECT_EQ(codeOf("word.obj", "v 0 zero 0\n"), QualityErrorCode::kInvalidFile);
}

TEST(ReadSurface, StlOfBothKindsIsWelded) {
  std::string ascii = "solid quad\n", binary(80, ' ');
  put<std::uint32_t>(binary, 2, false);
  for (int t = 0; t < 2; ++t) {
    ascii += " facet normal 0 0 1\n  outer loop\n";
    for (int k = 0; k < 3; ++k) put<float>(binary, 0, false);
    for (int k = 0; k < 3; ++k) {
      const double* p = &kQuadPositions[3 * kQuadIndices[3 * t + k]];
      ascii += "   vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
      for (int axis = 0; axis < 3; ++axis) put<float>(binary, static_cast<float>(p[axis]), false);
    }
    ascii += "  endloop\n endfacet\n";
    put<std::uint16_t>(binary, 0, false);
  }
  expectQuad(readSurfaceFile(written("ascii.stl", ascii + "endsolid quad\n")));
  expectQuad(readSurfaceFile(written("binary.stl", binary)));
  EXPECT_EQ(codeOf("cut.stl", binary.substr(0, binary.size() - 1)), QualityErrorCode::kInvalidFile);
}

TEST(ReadSurface, MissingAndUnknownFiles) {
  EXPECT_EQ(readSurfaceFile("/nowhere/at/all.ply").error().code, QualityErrorCode::kUnreadableFile);
  EXPECT_EQ(readSurfaceFile(testing::TempDir()).error().code, QualityErrorCode::kUnsupportedFile);
  EXPECT_EQ(codeOf("mesh.step", ""), QualityErrorCode::kUnsupportedFile);
}

}  // namespace
}  // namespace tsc
