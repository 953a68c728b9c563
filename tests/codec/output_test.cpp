#include "output.h"

#include <gtest/gtest.h>

#include "checksum.h"
#include "codec_checks.h"

namespace tsc {
namespace {

using test::loadAt;

struct Written {
  Status status;
  std::vector<std::vector<std::byte>> outputs;
};

Written write(const Header& header, const std::vector<std::uint32_t>& numbers, const std::vector<Vec3>& positions,
              const std::vector<std::uint32_t>& indices) {
  Assignment assignment;
  assignment.table_position = {numbers};
  assignment.primitive_indices.emplace_back(indices.begin(), indices.end());
  Written result;
  for (const OutputInfo& info : outputsOf(header)) result.outputs.emplace_back(info.byte_length, std::byte{0xee});
  result.status = writeOutputs(header, assignment, {{}, positions}, test::spansOf(result.outputs));
  return result;
}

Header headerFor(std::uint32_t vertices, std::uint32_t faces, ComponentType positions, ComponentType indices) {
  Header header;
  header.position_type = positions;
  header.counts.table_vertex_count = {vertices};
  header.counts.primitive_table = {0};
  header.counts.primitive_face_count = {faces};
  header.index_types = {indices};
  return header;
}

TEST(Output, FloatsAreRoundedOnce) {
  Header header = headerFor(2, 0, ComponentType::kFloat32, ComponentType::kUint32);
  header.step = 0.1f;
  header.origin = {1, -2, 0.25f};
  header.positions.fine_bits = 6;
  const Written written = write(header, {1, 0}, {{0, 0, 0}, {640, 1, -3}}, {});
  ASSERT_FALSE(written.status);
  const double step = double{0.1f} / 64;
  EXPECT_EQ(loadAt<float>(written.outputs[0], 0), static_cast<float>(1 + 640 * step));
  EXPECT_EQ(loadAt<float>(written.outputs[0], 4), static_cast<float>(-2 + step));
  EXPECT_EQ(loadAt<float>(written.outputs[0], 8), static_cast<float>(0.25 - 3 * step));
  EXPECT_EQ(loadAt<float>(written.outputs[0], 12), 1.0f);
}

TEST(Output, AnchoredLatticesStartAtMultiplesOfTheStep) {
  Header header = headerFor(1, 0, ComponentType::kFloat32, ComponentType::kUint32);
  header.step = 0.5f;
  header.anchored = true;
  header.anchor = {-100, 7, 0};
  const Written written = write(header, {0}, {{3, -7, 9}}, {});
  EXPECT_EQ(loadAt<float>(written.outputs[0], 0), -48.5f);
  EXPECT_EQ(loadAt<float>(written.outputs[0], 4), 0.0f);
  EXPECT_EQ(loadAt<float>(written.outputs[0], 8), 4.5f);
}

TEST(Output, IntegersArePaddedWithZeros) {
  Header header = headerFor(2, 0, ComponentType::kInt8, ComponentType::kUint32);
  header.anchor = {-128, 0, 100};
  const Written written = write(header, {0, 0}, {{0, 5, 27}}, {});
  ASSERT_FALSE(written.status);
  const std::byte expected[] = {std::byte{0x80}, std::byte{5}, std::byte{127}, std::byte{0}};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(written.outputs[0][i], expected[i % 4]);
}

TEST(Output, IntegersOutOfRangeAreAnError) {
  for (const auto& [type, bad] : std::vector<std::pair<ComponentType, int>>{{ComponentType::kInt8, 128},
                                                                            {ComponentType::kUint8, -1},
                                                                            {ComponentType::kUint8, 256},
                                                                            {ComponentType::kInt16, -32769},
                                                                            {ComponentType::kUint16, 65536}}) {
    const Header header = headerFor(1, 0, type, ComponentType::kUint32);
    const Written written = write(header, {0}, {{0, 0, bad}}, {});
    ASSERT_TRUE(written.status);
    EXPECT_EQ(written.status->code, ErrorCode::kInvalidCount);
    EXPECT_EQ(written.status->found, bad);
  }
}

TEST(Output, IndicesOfEveryType) {
  const std::vector<std::uint32_t> indices = {0, 1, 254, 3, 2, 1};
  for (const ComponentType type : {ComponentType::kUint8, ComponentType::kUint16, ComponentType::kUint32}) {
    const Written written = write(headerFor(0, 2, ComponentType::kFloat32, type), {}, {}, indices);
    ASSERT_FALSE(written.status);
    ASSERT_EQ(written.outputs[1].size(), 6 * componentSize(type));
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_EQ(test::component(written.outputs[1], type, i * componentSize(type)), indices[i]);
    }
  }
}

TEST(Output, ChecksumIsChained) {
  std::vector<std::vector<std::byte>> outputs = {{std::byte{1}, std::byte{2}}, {}, {std::byte{3}}};
  const std::byte header[] = {std::byte{9}};
  const std::uint64_t expected = xxh64(outputs[2], xxh64(outputs[1], xxh64(outputs[0], xxh64(header, 0))));
  EXPECT_EQ(checksumOf(header, test::spansOf(outputs)), static_cast<std::uint32_t>(expected));
  const std::uint32_t before = checksumOf(header, test::spansOf(outputs));
  outputs[0].push_back(std::byte{0});
  EXPECT_NE(checksumOf(header, test::spansOf(outputs)), before);
}

}  // namespace
}  // namespace tsc
