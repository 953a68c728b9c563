// Positions repeated along cuts.
#include "references.h"

#include <gtest/gtest.h>

#include <numeric>

#include "surface_builders.h"

namespace tsc::test {
namespace {

/// Codes and decodes; returns the bits spent.
double roundTrip(const Surface& surface, const std::vector<std::uint32_t>& vertex_welded, std::uint32_t welded_count) {
  std::vector<std::uint32_t> welded_position;
  const PositionMap map = numberPositions(vertex_welded, welded_count, welded_position);
  if (map.isIdentity()) return 0;
  EntropyWriter writer;
  encodeReferences(surface, map, true, writer);
  std::vector<std::byte> bytes;
  writer.finish(7, bytes);
  EntropyReader reader(bytes);
  PositionMap decoded;
  EXPECT_FALSE(decodeReferences(surface, true, reader, decoded));
  EXPECT_EQ(decoded.vertex_position, map.vertex_position);
  EXPECT_EQ(decoded.position_count, map.position_count);
  EXPECT_TRUE(reader.atEnd());
  EXPECT_EQ(reader.state(), finalState(7));
  return writer.bitsSince(0);
}

std::vector<std::uint32_t> ownPositions(const Surface& surface) {
  std::vector<std::uint32_t> welded(surface.vertexCount());
  std::iota(welded.begin(), welded.end(), 0);
  for (std::uint32_t v = 0; v < welded.size(); ++v) {
    if (surface.isDummy(v)) welded[v] = kNone;
  }
  return welded;
}

TEST(References, WithoutRepeatsNothingIsCoded) {
  const Surface surface = grid(5, 4);
  EntropyWriter writer;
  std::vector<std::uint32_t> welded_position;
  const PositionMap map = numberPositions(ownPositions(surface), 20, welded_position);
  encodeReferences(surface, map, false, writer);
  EXPECT_EQ(writer.mark(), 0u);
  std::vector<std::byte> bytes;
  writer.finish(0, bytes);
  EntropyReader reader(bytes);
  PositionMap decoded;
  ASSERT_FALSE(decodeReferences(surface, false, reader, decoded));
  EXPECT_TRUE(map.isIdentity());
  EXPECT_TRUE(decoded.isIdentity());
  EXPECT_EQ(decoded.position_count, 20u);
}

TEST(References, NumbersPositionsByFirstAppearance) {
  std::vector<std::uint32_t> welded_position;
  const std::vector<std::uint32_t> welded = {5, 2, 5, kNone, 0};
  const PositionMap map = numberPositions(welded, 6, welded_position);
  EXPECT_EQ(map.vertex_position, (std::vector<std::uint32_t>{0, 1, 0, kNone, 2}));
  EXPECT_EQ(map.position_count, 3u);
  EXPECT_EQ(welded_position, (std::vector<std::uint32_t>{2, kNone, 1, kNone, kNone, 0}));
}

TEST(References, FollowACut) {
  // A grid whose last column repeats its first: a cylinder cut open. The second side costs next to nothing a vertex.
  const std::uint32_t width = 12, height = 200;
  const Surface surface = grid(width, height);
  std::vector<std::uint32_t> welded = ownPositions(surface);
  for (std::uint32_t y = 0; y < height; ++y) welded[y * width + width - 1] = y * width;
  const double bits = roundTrip(surface, welded, width * height);
  EXPECT_LT(bits / (width * height), 0.14);
}

TEST(References, ReachAnyPosition) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Surface surface = trial % 2 ? grid(3 + trial % 7, 3 + trial % 5) : torus(3 + trial % 7, 3 + trial % 5);
    std::vector<std::uint32_t> welded = ownPositions(surface);
    for (auto& w : welded) {
      if (w != kNone) w = random() % (1 + random() % welded.size());
    }
    roundTrip(surface, welded, surface.vertexCount());
  }
}

TEST(References, HostileBytesEndInAnErrorOrInAMap) {
  std::mt19937 random(2);
  const Surface surface = grid(9, 8);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<std::byte> bytes(random() % 64);
    for (auto& b : bytes) b = static_cast<std::byte>(random() % (trial % 3 ? 256 : 3));
    EntropyReader reader(bytes);
    PositionMap map;
    const Status status = decodeReferences(surface, true, reader, map);
    if (status) {
      EXPECT_TRUE(status->code == ErrorCode::kTruncated || status->code == ErrorCode::kInvalidSymbol);
      continue;
    }
    for (std::uint32_t v = 0; v < surface.vertexCount(); ++v) {
      if (!surface.isDummy(v)) {
        EXPECT_LT(map.vertex_position[v], map.position_count);
      }
    }
  }
}

}  // namespace
}  // namespace tsc::test
