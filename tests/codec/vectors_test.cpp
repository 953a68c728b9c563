// The vectors beside the format's description: each stream decodes to the arrays in its JSON file, and encoding the
// same input again gives the same bytes. A change of the format on purpose runs `tsc-make-vectors FOLDER --write`.
#include "vectors.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

namespace tsc::test {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = TSC_VECTORS_FOLDER;

Bytes bytesOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string textAt(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Vectors, DecodeToWhatTheirFilesSay) {
  for (const Vector& vector : allVectors()) {
    SCOPED_TRACE(vector.name);
    const Bytes stream = bytesOf(kFolder / (vector.name + ".tsc"));
    ASSERT_FALSE(stream.empty()) << "no such vector in " << kFolder;
    const Json expected = Json::parse(textAt(kFolder / (vector.name + ".json")));
    const auto info = readStreamInfo(stream);
    const auto outputs = decode(stream);
    ASSERT_TRUE(info);
    ASSERT_TRUE(outputs) << describe(outputs.error());
    const DecodedMesh decoded = toNumbers(info->outputs, *outputs);
    ASSERT_EQ(outputs->size(), expected["outputs"].size());
    for (std::size_t o = 0; o < outputs->size(); ++o) {
      const Json& output = expected["outputs"][o];
      EXPECT_EQ(hexOf(xxh64((*outputs)[o], 0), 16), output["xxh64"]);
      EXPECT_EQ((*outputs)[o].size(), output["byte length"]);
      if (output["kind"] == "positions") {
        EXPECT_EQ(decoded.tables[o], output["data"].get<std::vector<Point>>());
      } else {
        EXPECT_EQ(decoded.primitives[o - decoded.tables.size()], output["data"].get<std::vector<std::uint32_t>>());
      }
    }
    EXPECT_EQ(describeStream(vector, stream), expected) << "header fields and checksum too";
  }
}

TEST(Vectors, EncodingAgainGivesTheSameBytes) {
  for (const Vector& vector : allVectors()) {
    const RoundTrip trip = roundTrip(vector.mesh, vector.options);
    ASSERT_EQ(trip.fault, "") << vector.name;
    EXPECT_EQ(trip.encoded.bytes, bytesOf(kFolder / (vector.name + ".tsc"))) << vector.name;
  }
}

TEST(Vectors, ChecksumIsWhatTheCoderEndsWith) {
  for (const Vector& vector : allVectors()) {
    const Json expected = Json::parse(textAt(kFolder / (vector.name + ".json")));
    EXPECT_EQ(expected["checksum"].get<std::string>().size(), 8u);
    EXPECT_EQ(expected["header bytes"], HeaderWalk(bytesOf(kFolder / (vector.name + ".tsc"))).size());
  }
}

TEST(Vectors, NoOthersLieAround) {
  std::set<std::string> names;
  for (const Vector& vector : allVectors()) {
    names.insert(vector.name + ".tsc");
    names.insert(vector.name + ".json");
  }
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(names.contains(name) || name == "README.md") << name;
  }
}

TEST(Vectors, CoverWhatTheyAreFor) {
  for (const Vector& vector : allVectors()) {
    const RoundTrip trip = roundTrip(vector.mesh, vector.options);
    ASSERT_EQ(trip.fault, "");
    const StreamBits& bits = trip.encoded.bits;
    const HeaderWalk header(trip.encoded.bytes);
    const auto flag = [&](const char* name) {
      for (const Json& field : header.fields()) {
        if (field["field"] == name) return field["value"].get<int>();
      }
      return -1;
    };
    EXPECT_EQ(bits.references > 0, vector.name == "non-manifold" || vector.name == "max-tips") << vector.name;
    EXPECT_EQ(bits.side_faces > 0, vector.name == "side-faces") << vector.name;
    EXPECT_EQ(bits.corners > 0, vector.name == "seams" || vector.name == "side-faces") << vector.name;
    EXPECT_TRUE(flag("exact hits") == 1 || vector.name != "hits");
    EXPECT_EQ(flag("anchored"), vector.name == "anchored-degree" || vector.name == "int16") << vector.name;
    EXPECT_EQ(flag("order"), vector.name == "anchored-degree") << vector.name;
    EXPECT_EQ(flag("normal scale - 1"), vector.name == "sheet-paper"            ? 1
                                        : vector.options.mode == Mode::kTangent ? 0
                                                                                : -1);
    EXPECT_EQ(flag("position type"), vector.name == "int16" ? 2 : 5) << vector.name;
    EXPECT_LT(trip.encoded.bytes.size(), 1000u);
  }
}

}  // namespace
}  // namespace tsc::test
