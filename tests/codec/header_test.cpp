#include "header.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>

#include "format.h"

namespace tsc {
namespace {

using Bytes = std::vector<std::byte>;

Header smallHeader() {
  Header h;
  h.positions.predictor = Predictor::kAverage;
  h.step = 0.25f;
  h.origin = {1, 2, 3};
  h.counts.table_vertex_count = {3};
  h.counts.primitive_table = {0};
  h.counts.primitive_face_count = {1};
  h.counts.one_vertex_per_position = true;
  h.index_types = {ComponentType::kUint16};
  h.surface = {4, 3, 1};
  return h;
}

Bytes written(const Header& header) {
  Bytes bytes;
  writeHeader(header, bytes);
  return bytes;
}

Status read(const Bytes& bytes, Header& header, const DecodeLimits& limits = {}) {
  std::size_t size = 0;
  const Status status = readHeader(bytes, limits, header, size);
  EXPECT_LE(size, bytes.size());
  if (!status) {
    EXPECT_EQ(size, bytes.size());
  }
  return status;
}

ErrorCode errorOf(const Bytes& bytes) {
  Header header;
  const Status status = read(bytes, header);
  EXPECT_TRUE(status);
  return status ? status->code : ErrorCode::kBoundNotMet;
}

// lattice, gate, average, traversal; float32, one vertex per position, dummies; step 0.25, origin 1 2 3; 1 table, 1
// primitive; 3 vertices; table 0 with 2-byte indices, 1 face; as many surface vertices and 1 dummy; 4 vertices - 4 / 2
// faces (zigzag 4).
TEST(Header, ByHand) {
  const std::uint8_t expected[] = {0,    3 << 2, 5 | 1 << 5 | 1 << 7,
                                   0,    0,      0x80,
                                   0x3e, 0,      0,
                                   0x80, 0x3f,   0,
                                   0,    0,      0x40,
                                   0,    0,      0x40,
                                   0x40, 1,      1,
                                   3,    1,      1,
                                   0,    1,      4};
  const Bytes bytes = written(smallHeader());
  ASSERT_EQ(bytes.size(), std::size(expected));
  for (std::size_t i = 0; i < bytes.size(); ++i) EXPECT_EQ(static_cast<std::uint8_t>(bytes[i]), expected[i]) << i;
}

TEST(Header, EveryFieldComesBack) {
  std::mt19937 random(1);
  for (int i = 0; i < 3000; ++i) {
    Header h;
    const bool integer = random() % 3 == 0;
    h.positions.mode = !integer && random() % 2 == 0 ? Mode::kTangent : Mode::kLattice;
    if (h.positions.mode == Mode::kTangent) {
      h.positions.basis = random() % 2 == 0 ? Basis::kGate : Basis::kTip;
      h.positions.normal_scale = 1 + random() % kMaxNormalScale;
      h.positions.fine_bits = kFineBits;
    }
    h.positions.predictor = static_cast<Predictor>(1 + random() % 5);
    h.positions.order = random() % 2 == 0 ? Order::kTraversal : Order::kDegree;
    h.positions.effort = static_cast<Effort>(random() % 2);
    h.positions.candidates = h.positions.effort == Effort::kDefault && random() % 2 == 0;
    h.positions.exact_hits = h.positions.candidates && random() % 2 == 0;
    h.position_type = integer ? static_cast<ComponentType>(random() % 4) : ComponentType::kFloat32;
    h.has_references = random() % 2 == 0;
    h.anchored = integer || random() % 2 == 0;
    if (!integer)
      h.step = std::ldexp(1.0f + static_cast<float>(random() % 100) / 100, static_cast<int>(random() % 60) - 30);
    for (int a = 0; a < 3; ++a) {
      if (h.anchored) {
        h.anchor[a] = (static_cast<std::int64_t>(random()) - (std::int64_t{1} << 31)) << random() % 16;
      } else {
        h.origin[a] = -static_cast<float>(random()) / 3;
      }
    }
    std::uint32_t vertices = 0, faces = 0;
    for (std::uint32_t t = random() % 4; t > 0; --t)
      vertices += h.counts.table_vertex_count.emplace_back(random() % 9999);
    const auto tables = static_cast<std::uint32_t>(h.counts.table_vertex_count.size());
    for (std::uint32_t p = tables > 0 ? random() % 4 : 0; p > 0; --p) {
      h.counts.primitive_table.push_back(random() % tables);
      faces += h.counts.primitive_face_count.emplace_back(random() % 9999);
      const ComponentType types[] = {ComponentType::kUint8, ComponentType::kUint16, ComponentType::kUint32};
      const bool narrow = h.counts.table_vertex_count[h.counts.primitive_table.back()] <= 256;
      h.index_types.push_back(types[narrow ? random() % 3 : 1 + random() % 2]);
    }
    h.surface.faces = faces > 0 ? random() % faces * 2 : 0;
    h.surface.real_vertices = h.surface.faces > 0 ? random() % h.surface.faces : 0;
    h.surface.dummies = h.surface.faces > 0 && random() % 2 == 0 ? random() % h.surface.faces : 0;

    const Bytes bytes = written(h);
    Header back;
    const Status status = read(bytes, back);
    ASSERT_FALSE(status) << describe(*status);
    ASSERT_EQ(back.positions.mode, h.positions.mode);
    ASSERT_EQ(back.positions.basis, h.positions.basis);
    ASSERT_EQ(back.positions.predictor, h.positions.predictor);
    ASSERT_EQ(back.positions.order, h.positions.order);
    ASSERT_EQ(back.positions.exact_hits, h.positions.exact_hits);
    ASSERT_EQ(back.positions.candidates, h.positions.candidates);
    ASSERT_EQ(back.positions.normal_scale, h.positions.normal_scale);
    ASSERT_EQ(back.positions.fine_bits, h.positions.fine_bits);
    ASSERT_EQ(back.positions.effort, h.positions.effort);
    ASSERT_EQ(back.position_type, h.position_type);
    ASSERT_EQ(back.has_references, h.has_references);
    ASSERT_EQ(back.anchored, h.anchored);
    ASSERT_EQ(back.step, h.step);
    ASSERT_EQ(back.origin, h.origin);
    ASSERT_EQ(back.anchor, h.anchor);
    ASSERT_EQ(back.surface, h.surface);
    ASSERT_EQ(back.counts.table_vertex_count, h.counts.table_vertex_count);
    ASSERT_EQ(back.counts.primitive_table, h.counts.primitive_table);
    ASSERT_EQ(back.counts.primitive_face_count, h.counts.primitive_face_count);
    ASSERT_EQ(back.index_types, h.index_types);
    ASSERT_EQ(written(back), bytes);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      Header cut;
      const Status truncated = read(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)), cut);
      ASSERT_TRUE(truncated);
      ASSERT_EQ(truncated->code, ErrorCode::kTruncated);
    }
  }
}

TEST(Header, RefusesWhatIsUndefined) {
  const Bytes good = written(smallHeader());
  const auto changed = [&](std::size_t at, int value) {
    Bytes bytes = good;
    bytes[at] = static_cast<std::byte>(value);
    return errorOf(bytes);
  };
  EXPECT_EQ(changed(0, 1), ErrorCode::kUnsupportedVersion);
  EXPECT_EQ(changed(1, 5 << 2), ErrorCode::kReservedBits) << "predictor 5";
  EXPECT_EQ(changed(1, 3 << 2 | 2), ErrorCode::kReservedBits) << "a basis in lattice mode";
  EXPECT_EQ(changed(25, 0), ErrorCode::kReservedBits) << "no dummies where there should be some";
  for (const int type : {4, 6, 7}) EXPECT_EQ(changed(2, type), ErrorCode::kReservedBits);
  EXPECT_EQ(changed(2, 2), ErrorCode::kReservedBits) << "integers that are not anchored";
  EXPECT_EQ(changed(6, 0xbe), ErrorCode::kReservedBits) << "negative step";
  EXPECT_EQ(changed(6, 0x7f), ErrorCode::kReservedBits) << "step that is no number";
  EXPECT_EQ(changed(22, 3), ErrorCode::kReservedBits) << "index type";
  EXPECT_EQ(changed(22, 1 | 1 << 2), ErrorCode::kInvalidCount) << "table 1 of 1";
}

TEST(Header, RefusesCandidatesAtEffortMax) {
  Header header = smallHeader();
  header.positions.candidates = true;
  Header back;
  EXPECT_FALSE(read(written(header), back));
  header.positions.effort = Effort::kMax;
  EXPECT_EQ(errorOf(written(header)), ErrorCode::kReservedBits);
}

TEST(Header, RefusesExactHitsWithoutCandidates) {
  Header header = smallHeader();
  header.positions.exact_hits = true;
  EXPECT_EQ(errorOf(written(header)), ErrorCode::kReservedBits);
  header.positions.candidates = true;
  Header back;
  EXPECT_FALSE(read(written(header), back));
}

TEST(Header, RefusesBadNumbers) {
  const auto refuses = [](ErrorCode code, const std::function<void(Header&)>& change) {
    Header header = smallHeader();
    change(header);
    EXPECT_EQ(errorOf(written(header)), code);
  };
  refuses(ErrorCode::kReservedBits, [](Header& h) { h.step = 0; });
  refuses(ErrorCode::kReservedBits, [](Header& h) { h.origin[2] = std::numeric_limits<float>::infinity(); });
  refuses(ErrorCode::kReservedBits, [](Header& h) {
    h.positions.mode = Mode::kTangent;
    h.positions.normal_scale = 17;
  });
  refuses(ErrorCode::kLimitExceeded, [](Header& h) {
    h.anchored = true;
    h.anchor[1] = (std::int64_t{1} << 48) + 1;
  });
  refuses(ErrorCode::kLimitExceeded, [](Header& h) { h.counts.table_vertex_count[0] = (1u << 29) + 1; });
  refuses(ErrorCode::kLimitExceeded, [](Header& h) { h.counts.primitive_face_count[0] = (1u << 29) + 1; });
  refuses(ErrorCode::kInvalidCount, [](Header& h) { h.surface.faces = 6; });
  refuses(ErrorCode::kInvalidCount, [](Header& h) { h.surface.real_vertices = 12; });
  refuses(ErrorCode::kInvalidCount, [](Header& h) { h.surface.dummies = 10; });
  refuses(ErrorCode::kLimitExceeded, [](Header& h) { h.surface.dummies = (1u << 29) + 1; });
}

TEST(Header, RefusesVarintsOfNonMinimalLength) {
  Bytes bytes = written(smallHeader());
  bytes[20] = std::byte{0x81};  // primitive count 1 as 81 00
  bytes.insert(bytes.begin() + 21, std::byte{0});
  EXPECT_EQ(errorOf(bytes), ErrorCode::kReservedBits);
}

TEST(Header, Outputs) {
  Header header = smallHeader();
  header.position_type = ComponentType::kUint8;
  header.counts.primitive_face_count = {7};
  const std::vector<OutputInfo> outputs = outputsOf(header);
  ASSERT_EQ(outputs.size(), 2u);
  EXPECT_EQ(outputs[0].count, 3u);
  EXPECT_EQ(outputs[0].byte_stride, 4u);
  EXPECT_EQ(outputs[0].byte_length, 12u);
  EXPECT_EQ(outputs[1].count, 21u);
  EXPECT_EQ(outputs[1].byte_stride, 2u);
  EXPECT_EQ(outputs[1].byte_length, 42u);
}

}  // namespace
}  // namespace tsc
