// Whatever cannot be measured is refused by name, by every reader and every measure; no figure is made up.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <ostream>
#include <string>

#include "meshes.h"

namespace tsc {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ------------------------------------------------------------------------------------------------- Files

const MeshArrays kTetrahedron = {{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}};

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string asPly(const MeshArrays& mesh, bool binary) {
  std::string bytes = "ply\nformat ";
  bytes.append(binary ? "binary_little_endian" : "ascii").append(" 1.0\nelement vertex ");
  bytes.append(std::to_string(mesh.vertexCount())).append("\nproperty float x\nproperty float y\nproperty float z\n");
  bytes.append("element face ").append(std::to_string(mesh.indices.size() / 3));
  bytes.append("\nproperty list uchar int vertex_indices\nend_header\n");
  for (const double value : mesh.positions) {
    if (binary) put(bytes, static_cast<float>(value));
    else bytes += std::to_string(value) + "\n";
  }
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    if (binary && i % 3 == 0) put(bytes, std::uint8_t{3});
    if (binary) put(bytes, static_cast<std::int32_t>(mesh.indices[i]));
    else bytes.append(i % 3 == 0 ? "3 " : "").append(std::to_string(mesh.indices[i])).append("\n");
  }
  return bytes;
}

std::string asObj(const MeshArrays& mesh) {
  std::string bytes;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    bytes.append(i % 3 == 0 ? "\nv " : " ").append(std::to_string(mesh.positions[i]));
  }
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    bytes.append(i % 3 == 0 ? "\nf " : " ").append(std::to_string(mesh.indices[i] + 1));
  }
  return bytes.append("\n");
}

std::string asStl(const MeshArrays& mesh, bool binary) {
  std::string bytes = binary ? std::string(80, ' ') : "solid mesh\n";
  if (binary) put(bytes, static_cast<std::uint32_t>(mesh.indices.size() / 3));
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    if (binary && i % 3 == 0) bytes.append(12, '\0');
    if (!binary) bytes += "vertex";
    for (int k = 0; k < 3; ++k) {
      const double value = mesh.positions[3 * mesh.indices[i] + static_cast<std::size_t>(k)];
      if (binary) put(bytes, static_cast<float>(value));
      else bytes.append(" ").append(std::to_string(value));
    }
    if (!binary) bytes += "\n";
    if (binary && i % 3 == 2) bytes.append(2, '\0');
  }
  return bytes + (binary ? "" : "endsolid mesh\n");
}

struct Format {
  const char* name;
  std::string (*write)(const MeshArrays& mesh);
};
void PrintTo(const Format& format, std::ostream* os) { *os << format.name; }

const Format kFormats[] = {
    {"ascii.ply", [](const MeshArrays& mesh) { return asPly(mesh, false); }},
    {"binary.ply", [](const MeshArrays& mesh) { return asPly(mesh, true); }},
    {"mesh.obj", asObj},
    {"ascii.stl", [](const MeshArrays& mesh) { return asStl(mesh, false); }},
    {"binary.stl", [](const MeshArrays& mesh) { return asStl(mesh, true); }},
};

class BadFile : public testing::TestWithParam<Format> {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  Measured<NamedSurface> readBack(const MeshArrays& mesh) const {
    std::ofstream(path(), std::ios::binary) << GetParam().write(mesh);
    return readSurfaceFile(path());
  }
  fs::path path() const { return folder_ / GetParam().name; }

  /// What comparing this file with the good mesh, either way round, is refused with. Each part is a clear cause.
  void expectRefused(const Measured<NamedSurface>& mesh, QualityErrorCode code) const {
    ASSERT_TRUE(mesh) << mesh.error().message;
    const NamedSurface good = kTetrahedron.named();
    for (const bool first : {false, true}) {
      const NamedSurface pair[2] = {first ? *mesh : good, first ? good : *mesh};
      const auto result = compareScenes(std::span(pair, 1), std::span(pair + 1, 1));
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code, code) << result.error().message;
      EXPECT_NE(result.error().message.find(first ? "first file" : "second file"), std::string::npos)
          << result.error().message;
    }
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / ("tsc_quality_bad_files_" + std::to_string(getpid()));
};

TEST_P(BadFile, theGoodMeshIsRead) {
  const auto mesh = readBack(kTetrahedron);
  ASSERT_TRUE(mesh) << mesh.error().message;
  const NamedSurface a = kTetrahedron.named(), b = *mesh;
  const auto result = compareScenes(std::span(&a, 1), std::span(&b, 1));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->total.vertices->max, 0);
}

TEST_P(BadFile, withoutFaces) {
  MeshArrays mesh = kTetrahedron;
  mesh.indices.clear();
  expectRefused(readBack(mesh), QualityErrorCode::kNoFaces);
}

TEST_P(BadFile, withoutArea) {
  MeshArrays mesh = kTetrahedron;
  for (double& value : mesh.positions) value = 1;
  const auto read = readBack(mesh);
  ASSERT_TRUE(read) << read.error().message;
  const NamedSurface good = kTetrahedron.named();
  const auto result = compareScenes(std::span(&good, 1), std::span(&*read, 1));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, QualityErrorCode::kNoFaces) << result.error().message;
}

TEST_P(BadFile, withCoordinatesThatAreNotFinite) {
  for (const double value : {kNan, kInfinity, -kInfinity}) {
    for (const std::size_t at : {0u, 5u, 11u}) {
      MeshArrays mesh = kTetrahedron;
      mesh.positions[at] = value;
      expectRefused(readBack(mesh), QualityErrorCode::kNonFinitePosition);
    }
  }
}

TEST_P(BadFile, ofOtherConnectivityIsMeasuredByMetroAlone) {
  MeshArrays open = kTetrahedron;
  open.indices.resize(9);
  const auto mesh = readBack(open);
  ASSERT_TRUE(mesh) << mesh.error().message;
  const NamedSurface good = kTetrahedron.named();
  const auto result = compareScenes(std::span(&good, 1), std::span(&*mesh, 1));
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_FALSE(result->total.correspondence);
  EXPECT_FALSE(result->total.vertices);
  EXPECT_FALSE(result->total.dame);
  EXPECT_GT(result->total.metro.rms(), 0);
}

TEST_P(BadFile, thatIsMissingEmptyOrAFolder) {
  const auto missing = readSurfaceFile(path());
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, QualityErrorCode::kUnreadableFile);
  EXPECT_NE(missing.error().message.find(path().string()), std::string::npos) << missing.error().message;

  std::ofstream(path(), std::ios::binary).flush();
  const auto empty = readSurfaceFile(path());
  if (empty) expectRefused(empty, QualityErrorCode::kNoFaces);  // an empty OBJ file is one without vertices
  else EXPECT_EQ(empty.error().code, QualityErrorCode::kInvalidFile) << empty.error().message;

  fs::remove(path());
  fs::create_directory(path());
  const auto folder = readSurfaceFile(path());
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code, QualityErrorCode::kUnreadableFile) << folder.error().message;
}

INSTANTIATE_TEST_SUITE_P(Formats, BadFile, testing::ValuesIn(kFormats), [](const auto& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

// ---------------------------------------------------------------------------------------------- Measures

struct BadInput {
  const char* name;
  MeshArrays mesh;
  QualityErrorCode code;
};
void PrintTo(const BadInput& input, std::ostream* os) { *os << input.name; }

std::vector<BadInput> badInputs() {
  std::vector<BadInput> inputs;
  const auto add = [&](const char* name, QualityErrorCode code) -> MeshArrays& {
    inputs.push_back({name, kTetrahedron, code});
    return inputs.back().mesh;
  };
  add("NoFaces", QualityErrorCode::kNoFaces).indices.clear();
  add("OnlyDegenerateFaces", QualityErrorCode::kNoFaces).indices = {0, 0, 1, 2, 3, 3};
  add("NotANumber", QualityErrorCode::kNonFinitePosition).positions[4] = kNan;
  add("Infinite", QualityErrorCode::kNonFinitePosition).positions[4] = kInfinity;
  add("IndexPastTheEnd", QualityErrorCode::kInvalidIndex).indices[5] = 4;
  add("LargestIndex", QualityErrorCode::kInvalidIndex).indices[5] = 0xffffffff;
  add("HalfATriangle", QualityErrorCode::kInvalidIndex).indices.pop_back();
  return inputs;
}

class BadMeasure : public testing::TestWithParam<BadInput> {
 protected:
  const SurfaceView bad_ = GetParam().mesh.view();
  const SurfaceView good_ = kTetrahedron.view();
};

TEST_P(BadMeasure, metroRefusesEitherSide) {
  EXPECT_EQ(metro(bad_, good_).error().code, GetParam().code);
  EXPECT_EQ(metro(good_, bad_).error().code, GetParam().code);
  EXPECT_EQ(distancesToSurface(good_.positions, bad_).error().code, GetParam().code);
}

TEST_P(BadMeasure, dameRefusesEitherSide) {
  EXPECT_EQ(dame(bad_, good_.positions).error().code, GetParam().code);
  if (GetParam().code == QualityErrorCode::kNonFinitePosition) {
    EXPECT_EQ(dame(good_, bad_.positions).error().code, GetParam().code);
  }
}

TEST_P(BadMeasure, matchingRefusesEitherSide) {
  EXPECT_EQ(matchVertices(bad_, good_).error().code, GetParam().code);
  EXPECT_EQ(matchVertices(good_, bad_).error().code, GetParam().code);
}

TEST_P(BadMeasure, scenesRefuseEitherSide) {
  const NamedSurface bad = GetParam().mesh.named(), good = kTetrahedron.named();
  EXPECT_EQ(compareScenes(std::span(&bad, 1), std::span(&good, 1)).error().code, GetParam().code);
  EXPECT_EQ(compareScenes(std::span(&good, 1), std::span(&bad, 1)).error().code, GetParam().code);
}

INSTANTIATE_TEST_SUITE_P(Inputs, BadMeasure, testing::ValuesIn(badInputs()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(BadMeasure, vertexErrorsRefuseWhatDoesNotCorrespond) {
  const std::vector<double> two(6, 0.0), three(9, 0.0), none, nan = {0, 0, kNan};
  EXPECT_EQ(vertexErrors(two, three).error().code, QualityErrorCode::kCountMismatch);
  EXPECT_EQ(vertexErrors(none, none).error().code, QualityErrorCode::kNoFaces);
  EXPECT_EQ(vertexErrors(nan, std::vector<double>(3, 0.0)).error().code, QualityErrorCode::kNonFinitePosition);
  EXPECT_EQ(vertexErrors(std::vector<double>(3, 0.0), nan).error().code, QualityErrorCode::kNonFinitePosition);
  EXPECT_EQ(dame(kTetrahedron.view(), two).error().code, QualityErrorCode::kCountMismatch);
}

TEST(BadMeasure, verticesThatNoTriangleUsesMayBeAnything) {
  MeshArrays loose = kTetrahedron;
  loose.positions.insert(loose.positions.end(), {kNan, 0, 0});
  const NamedSurface a = loose.named(), b = kTetrahedron.named();
  const auto result = compareScenes(std::span(&a, 1), std::span(&b, 1));
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->total.vertices->max, 0);
  EXPECT_NEAR(result->total.metro.rms(), 0, 1e-15);
}

}  // namespace
}  // namespace tsc
