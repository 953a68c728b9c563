// Streams that nobody wrote: cut short, with bits flipped, with random payloads and with headers that claim too much.
// Each must end in an error, soon and with little memory.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <random>

#include "codec_checks.h"
#include "header.h"

namespace tsc::test {
namespace {

using Bytes = std::vector<std::byte>;

struct Sample {
  const char* name;
  Bytes bytes;
};

meshes::Triangles cubeWithHole() {
  meshes::Triangles mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.addVertex(static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1), static_cast<float>(i >> 2));
  }
  const std::uint32_t sides[5][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}};
  for (const auto& s : sides) {
    mesh.addFace(s[0], s[1], s[2]);
    mesh.addFace(s[0], s[2], s[3]);
  }
  return mesh;
}

/// Two primitives over two tables that meet along a line of equal positions.
OwnedMesh seams() {
  OwnedMesh mesh(meshes::grid(4, 3));
  meshes::Triangles beside = meshes::grid(4, 3);
  for (std::size_t i = 1; i < beside.positions.size(); i += 3) beside.positions[i] = -beside.positions[i];
  mesh.tables.push_back(beside.positions);
  mesh.primitives.push_back({1, beside.indices, ComponentType::kUint8});
  return mesh;
}

Bytes coded(const OwnedMesh& mesh, double step, Mode mode, Predictor predictor, Effort effort = Effort::kDefault) {
  EncodeOptions options;
  options.effort = effort;
  options.step = step;
  options.mode = mode;
  options.predictor = predictor;
  RoundTrip trip = roundTrip(mesh, options);
  EXPECT_EQ(trip.fault, "");
  return trip.encoded.bytes;
}

std::vector<Sample> sixSamples() {
  OwnedMesh integers(meshes::torus(4, 4));
  integers.position_type = ComponentType::kInt16;
  for (float& x : integers.tables[0]) x = std::round(100 * x);
  return {
      {"cube with a hole", coded(OwnedMesh(cubeWithHole()), 0.01, Mode::kLattice, Predictor::kAverage)},
      {"two primitives", coded(seams(), 0.01, Mode::kAuto, Predictor::kAuto)},
      {"non-manifold soup", coded(OwnedMesh(meshes::soup(14, 40, 3)), 0.5, Mode::kTangent, Predictor::kWeighted)},
      {"integers", coded(integers, 0, Mode::kLattice, Predictor::kAdaptive)},
      {"sphere", coded(OwnedMesh(meshes::sphere(5, 6)), 0.001, Mode::kTangent, Predictor::kAdaptive)},
      {"effort max", coded(OwnedMesh(cubeWithHole()), 0.01, Mode::kAuto, Predictor::kAuto, Effort::kMax)},
  };
}

std::int64_t peakMemoryBytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

TEST(Hostile, EveryTruncationIsAnError) {
  for (const Sample& sample : sixSamples()) {
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      const auto outputs = decode(std::span(sample.bytes).first(size));
      ASSERT_FALSE(outputs) << sample.name << ", first " << size << " bytes";
      EXPECT_LE(outputs.error().byte_offset, size);
    }
  }
}

TEST(Hostile, EverySingleBitFlipIsAnError) {
  for (const Sample& sample : sixSamples()) {
    Bytes bytes = sample.bytes;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= std::byte{1} << bit % 8;
      ASSERT_FALSE(decode(bytes)) << sample.name << ", bit " << bit;
      bytes[bit / 8] ^= std::byte{1} << bit % 8;
    }
  }
}

/// Surfaces with handles name nodes of the front by number or by a distance along a loop, which has two ends: another
/// stream may stand for the same mesh, but none for another one.
TEST(Hostile, EveryByteValueOnSurfacesWithHandles) {
  for (std::uint32_t u = 3; u < 12; ++u) {
    Bytes bytes = coded(OwnedMesh(meshes::torus(u, 3 + u * 7 % 5)), 0.25, Mode::kLattice, Predictor::kAverage);
    const auto right = decode(bytes);
    ASSERT_TRUE(right);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (int value = 1; value < 256; ++value) {
        bytes[i] ^= static_cast<std::byte>(value);
        const auto found = decode(bytes);
        ASSERT_TRUE(!found || *found == *right) << u << ", byte " << i;
        bytes[i] ^= static_cast<std::byte>(value);
      }
    }
  }
}

TEST(Hostile, EveryByteValueIsAnErrorButTheRightOne) {
  for (const Sample& sample : sixSamples()) {
    Bytes bytes = sample.bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (int value = 1; value < 256; ++value) {
        bytes[i] ^= static_cast<std::byte>(value);
        ASSERT_FALSE(decode(bytes)) << sample.name << ", byte " << i;
        bytes[i] ^= static_cast<std::byte>(value);
      }
    }
  }
}

TEST(Hostile, TrailingBytesAreAnError) {
  for (const Sample& sample : sixSamples()) {
    Bytes bytes = sample.bytes;
    for (int count = 1; count < 20; ++count) {
      bytes.push_back(std::byte{0});
      const auto outputs = decode(bytes);
      ASSERT_FALSE(outputs) << sample.name;
      EXPECT_EQ(outputs.error().code, ErrorCode::kTrailingData);
    }
  }
}

TEST(Hostile, RandomPayloadsBehindValidHeaders) {
  std::mt19937 random(1);
  for (const Sample& sample : sixSamples()) {
    Header header;
    std::size_t size = 0;
    ASSERT_FALSE(readHeader(sample.bytes, {}, header, size));
    for (int i = 0; i < 2000; ++i) {
      Bytes bytes(sample.bytes.begin(), sample.bytes.begin() + static_cast<std::ptrdiff_t>(size));
      for (std::uint32_t count = random() % 400; count > 0; --count) bytes.push_back(static_cast<std::byte>(random()));
      // Every second keeps its payload's beginning, so that decoding comes farther.
      if (i % 2 == 0) {
        const std::size_t kept = std::min(sample.bytes.size(), size + random() % (sample.bytes.size() - size));
        bytes.resize(std::max(bytes.size(), kept));
        std::copy_n(sample.bytes.begin(), kept, bytes.begin());
      }
      ASSERT_FALSE(decode(bytes)) << sample.name;
    }
  }
}

TEST(Hostile, HeadersThatAreEdited) {
  std::mt19937 random(2);
  for (const Sample& sample : sixSamples()) {
    Header header;
    std::size_t size = 0;
    ASSERT_FALSE(readHeader(sample.bytes, {}, header, size));
    for (int i = 0; i < 3000; ++i) {
      Bytes bytes = sample.bytes;
      for (std::uint32_t edits = 1 + random() % 4; edits > 0; --edits) {
        bytes[random() % size] = static_cast<std::byte>(random());
      }
      if (bytes == sample.bytes) continue;
      ASSERT_FALSE(decode(bytes)) << sample.name;
    }
  }
}

TEST(Hostile, RandomBytes) {
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(random() % 100);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    if (!bytes.empty() && i % 4 != 0) bytes[0] = std::byte{0};
    ASSERT_FALSE(decode(bytes));
  }
}

/// A header of one table and one primitive that claims these counts.
Bytes headerThatClaims(std::uint32_t vertices, std::uint32_t faces, std::uint32_t surface_vertices,
                       std::uint32_t surface_faces, bool one_vertex_per_position) {
  Header header;
  header.counts.table_vertex_count = {vertices};
  header.counts.primitive_table = {0};
  header.counts.primitive_face_count = {faces};
  header.counts.one_vertex_per_position = one_vertex_per_position;
  header.index_types = {ComponentType::kUint32};
  header.surface = {surface_faces, surface_vertices, 0};
  Bytes bytes;
  writeHeader(header, bytes);
  return bytes;
}

TEST(Hostile, HugeCountsFailWithLittleMemory) {
  constexpr std::uint32_t kMany = 80'000'000;
  std::mt19937 random(4);
  const std::int64_t memory_before = peakMemoryBytes();
  for (const bool one_vertex_per_position : {false, true}) {
    for (const Bytes& header : {headerThatClaims(kMany, 0, 0, 0, one_vertex_per_position),
                                headerThatClaims(kMany, kMany, kMany, 2 * kMany, one_vertex_per_position),
                                headerThatClaims(0, kMany, kMany, 2 * kMany, one_vertex_per_position),
                                headerThatClaims(3, kMany, 3, 2, one_vertex_per_position),
                                headerThatClaims(kMany, 2, 4, 4, one_vertex_per_position)}) {
      EXPECT_TRUE(readStreamInfo(header)) << "these are claims that only decoding can refute";
      for (int i = 0; i < 20; ++i) {
        Bytes bytes = header;
        for (int j = 0; j < 4 * i; ++j) bytes.push_back(i % 3 == 0 ? std::byte{0} : static_cast<std::byte>(random()));
        EXPECT_FALSE(decode(bytes));
      }
    }
  }
  EXPECT_LT(peakMemoryBytes() - memory_before, 400 << 20);
}

TEST(Hostile, LimitsHold) {
  const Bytes bytes = sixSamples()[4].bytes;
  const auto info = readStreamInfo(bytes);
  ASSERT_TRUE(info);
  std::uint64_t total = 0;
  for (const OutputInfo& output : info->outputs) total += output.byte_length;
  EXPECT_TRUE(readStreamInfo(bytes, {total}));
  EXPECT_TRUE(decode(bytes, {total}));
  const auto refused = decode(bytes, {total - 1});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
  EXPECT_FALSE(readStreamInfo(bytes, {total - 1}));
  EXPECT_FALSE(readStreamInfo(headerThatClaims(1u << 29, 1u << 29, 0, 0, true))) << "above the default limit";
}

TEST(Hostile, OutputsMustHaveTheirSizes) {
  for (const Sample& sample : sixSamples()) {
    const auto info = readStreamInfo(sample.bytes);
    ASSERT_TRUE(info);
    std::vector<Bytes> outputs;
    for (const OutputInfo& output : info->outputs) outputs.emplace_back(output.byte_length);
    EXPECT_FALSE(decode(sample.bytes, spansOf(outputs)));
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      for (const int change : {-1, 1}) {
        std::vector<Bytes> wrong = outputs;
        wrong[o].resize(outputs[o].size() + static_cast<std::size_t>(change));
        const Status status = decode(sample.bytes, spansOf(wrong));
        ASSERT_TRUE(status);
        EXPECT_EQ(status->code, ErrorCode::kOutputMismatch);
      }
    }
    outputs.pop_back();
    const Status status = decode(sample.bytes, spansOf(outputs));
    ASSERT_TRUE(status);
    EXPECT_EQ(status->code, ErrorCode::kOutputMismatch);
  }
}

}  // namespace
}  // namespace tsc::test
