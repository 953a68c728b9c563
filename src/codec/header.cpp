// Each field stands once, in `fields`, for writing and for reading.
#include "header.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "format.h"

namespace tsc {
namespace {

constexpr std::uint32_t kMaxCount = 1u << 29;  // of vertices, faces: ids stay below the 2^30 of IntegerModel
constexpr std::int64_t kMaxAnchor = std::int64_t{1} << 48;

class HeaderWriter {
 public:
  static constexpr bool kReads = false;
  explicit HeaderWriter(std::vector<std::byte>& bytes) : bytes_(bytes) {}

  void byte(std::uint8_t& value) { bytes_.push_back(std::byte{value}); }
  void varint(std::uint64_t& value) {
    std::uint64_t rest = value;
    for (; rest >= 0x80; rest >>= 7) bytes_.push_back(static_cast<std::byte>(rest | 0x80));
    bytes_.push_back(static_cast<std::byte>(rest));
  }
  void float32(float& value) {
    const auto word = std::bit_cast<std::uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8) bytes_.push_back(static_cast<std::byte>(word >> shift));
  }
  void check(bool, ErrorCode, const char*, std::int64_t, std::int64_t) {}
  bool failed() const { return false; }

 private:
  std::vector<std::byte>& bytes_;
};

/// Remembers the first error and then reads zeros.
class HeaderReader {
 public:
  static constexpr bool kReads = true;
  explicit HeaderReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  void byte(std::uint8_t& value) { value = next(); }
  void varint(std::uint64_t& value) {
    value = 0;
    for (int shift = 0; shift < 56; shift += 7) {
      const std::uint8_t part = next();
      value |= std::uint64_t{part & 0x7fu} << shift;
      if (part < 0x80) {
        // One number has one form: no trailing zero groups.
        check(part != 0 || shift == 0, ErrorCode::kReservedBits, "header varint", part, 1);
        return;
      }
    }
    check(false, ErrorCode::kInvalidCount, "header varint", 9, 8);
  }
  void float32(float& value) {
    std::uint32_t word = 0;
    for (int shift = 0; shift < 32; shift += 8) word |= std::uint32_t{next()} << shift;
    value = std::bit_cast<float>(word);
  }
  void check(bool holds, ErrorCode code, const char* where, std::int64_t found, std::int64_t expected) {
    if (!holds && !error_) error_ = Error{code, where, position_, found, expected};
  }
  bool failed() const { return error_.has_value(); }
  const Status& error() const { return error_; }
  std::size_t position() const { return position_; }

 private:
  std::uint8_t next() {
    if (position_ >= bytes_.size()) {
      check(false, ErrorCode::kTruncated, "header", static_cast<std::int64_t>(bytes_.size()),
            static_cast<std::int64_t>(position_ + 1));
    }
    return failed() ? 0 : static_cast<std::uint8_t>(bytes_[position_++]);
  }

  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
  Status error_;
};

std::uint64_t zigzag64(std::int64_t value) {
  return static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63);
}
std::int64_t unzigzag64(std::uint64_t value) {
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

template <class Io>
void signedVarint(Io& io, std::int64_t& value) {
  std::uint64_t coded = zigzag64(value);
  io.varint(coded);
  value = unzigzag64(coded);
}

template <class Io>
void count(Io& io, std::uint32_t& value, std::uint64_t limit, const char* where) {
  std::uint64_t wide = value;
  io.varint(wide);
  io.check(wide <= limit, ErrorCode::kLimitExceeded, where, static_cast<std::int64_t>(wide),
           static_cast<std::int64_t>(limit));
  value = io.failed() ? 0 : static_cast<std::uint32_t>(wide);
}

/// A field of `width` bits at `shift` of a flag byte.
template <class Io, class T>
void bits(Io&, std::uint8_t& byte, int shift, int width, T& value) {
  const auto mask = static_cast<std::uint8_t>((1 << width) - 1);
  if constexpr (Io::kReads) {
    value = static_cast<T>(byte >> shift & mask);
  } else {
    byte = static_cast<std::uint8_t>(byte | (static_cast<std::uint8_t>(value) & mask) << shift);
  }
}

/// Modes are numbered from 0 in the stream; their enumerators start with kAuto.
template <class Io, class Enum>
void choice(Io& io, std::uint8_t& byte, int shift, int width, Enum& value) {
  auto number = static_cast<std::uint8_t>(static_cast<std::uint8_t>(value) - 1);
  bits(io, byte, shift, width, number);
  value = static_cast<Enum>(number + 1);
}

template <class Io>
void modeFields(Io& io, Header& h, bool& has_dummies) {
  std::uint8_t version = kFormatVersion;
  std::uint8_t first = 0;
  std::uint8_t second = 0;
  const auto layout = [&] {
    choice(io, first, 0, 1, h.positions.mode);
    choice(io, first, 1, 1, h.positions.basis);
    choice(io, first, 2, 3, h.positions.predictor);
    choice(io, first, 5, 1, h.positions.order);
    bits(io, first, 6, 1, h.positions.exact_hits);
    bits(io, first, 7, 1, h.positions.effort);
    bits(io, second, 0, 3, h.position_type);
    bits(io, second, 3, 1, h.anchored);
    bits(io, second, 4, 1, h.has_references);
    bits(io, second, 5, 1, h.counts.one_vertex_per_position);
    bits(io, second, 6, 1, h.positions.candidates);
    bits(io, second, 7, 1, has_dummies);
  };
  if constexpr (!Io::kReads) layout();
  io.byte(version);
  io.check(version == kFormatVersion, ErrorCode::kUnsupportedVersion, "header version", version, kFormatVersion);
  io.byte(first);
  io.byte(second);
  if constexpr (Io::kReads) layout();
  io.check(!h.positions.candidates || h.positions.effort == Effort::kDefault, ErrorCode::kReservedBits,
           "header candidates", 1, 0);
  io.check(!h.positions.exact_hits || h.positions.candidates, ErrorCode::kReservedBits, "header exact hits", 1, 0);
  const auto predictor = static_cast<int>(h.positions.predictor);
  io.check(predictor <= static_cast<int>(Predictor::kAdaptive), ErrorCode::kReservedBits, "header predictor",
           predictor - 1, static_cast<int>(Predictor::kAdaptive) - 1);
  const bool integer = h.position_type < ComponentType::kUint32;
  io.check(integer || h.position_type == ComponentType::kFloat32, ErrorCode::kReservedBits, "header position type",
           static_cast<int>(h.position_type), static_cast<int>(ComponentType::kFloat32));
  io.check(!integer || (h.anchored && h.positions.mode == Mode::kLattice), ErrorCode::kReservedBits,
           "header mode of integer positions", 0, 1);
  if (h.positions.mode == Mode::kTangent) {
    auto scale = static_cast<std::uint8_t>(h.positions.normal_scale - 1);
    io.byte(scale);
    io.check(scale < kMaxNormalScale, ErrorCode::kReservedBits, "header normal scale", scale, kMaxNormalScale - 1);
    h.positions.normal_scale = io.failed() ? 1 : scale + 1u;
    h.positions.fine_bits = kFineBits;
  } else {
    io.check(h.positions.basis == Basis::kGate, ErrorCode::kReservedBits, "header basis", 1, 0);
  }
}

template <class Io>
void latticeFields(Io& io, Header& h) {
  if (h.position_type == ComponentType::kFloat32) {
    io.float32(h.step);
    io.check(std::isfinite(h.step) && h.step > 0, ErrorCode::kReservedBits, "header step", 0, 1);
  }
  for (int a = 0; a < 3; ++a) {
    if (h.anchored) {
      signedVarint(io, h.anchor[a]);
      io.check(h.anchor[a] >= -kMaxAnchor && h.anchor[a] <= kMaxAnchor, ErrorCode::kLimitExceeded, "header anchor",
               h.anchor[a], kMaxAnchor);
    } else {
      io.float32(h.origin[a]);
      io.check(std::isfinite(h.origin[a]), ErrorCode::kReservedBits, "header origin", a, 0);
    }
  }
}

template <class Io>
void outputFields(Io& io, Header& h, const DecodeLimits& limits) {
  // No output is allocated here, but these vectors are: each entry costs at least one byte of header.
  auto table_count = static_cast<std::uint32_t>(h.counts.table_vertex_count.size());
  auto primitive_count = static_cast<std::uint32_t>(h.index_types.size());
  count(io, table_count, 1u << 20, "header table count");
  count(io, primitive_count, 1u << 20, "header primitive count");
  io.check(!h.counts.one_vertex_per_position || table_count == 1, ErrorCode::kInvalidCount,
           "header tables with one vertex a position", table_count, 1);
  std::uint64_t output_bytes = 0;
  const auto spend = [&](std::uint64_t elements, std::uint64_t size) {
    output_bytes += elements * size;  // below 2^29 * 2^4, at most 2^21 times: no overflow
    io.check(output_bytes <= limits.max_output_bytes, ErrorCode::kLimitExceeded, "header output bytes",
             static_cast<std::int64_t>(output_bytes), static_cast<std::int64_t>(limits.max_output_bytes));
  };
  for (std::uint32_t t = 0; t < table_count && !io.failed(); ++t) {
    if constexpr (Io::kReads) h.counts.table_vertex_count.push_back(0);
    count(io, h.counts.table_vertex_count[t], kMaxCount, "header vertex count");
    spend(h.counts.table_vertex_count[t], positionStride(h.position_type));
  }
  for (std::uint32_t p = 0; p < primitive_count && !io.failed(); ++p) {
    if constexpr (Io::kReads) {
      h.counts.primitive_table.push_back(0);
      h.counts.primitive_face_count.push_back(0);
      h.index_types.push_back(ComponentType::kUint32);
    }
    // Low two bits: logarithm of the index size; the rest: the table.
    std::uint64_t table = std::uint64_t{h.counts.primitive_table[p]} << 2;
    table |= static_cast<std::uint64_t>(std::countr_zero(componentSize(h.index_types[p])));
    io.varint(table);
    io.check((table & 3) < 3, ErrorCode::kReservedBits, "header index type", static_cast<std::int64_t>(table & 3), 2);
    io.check(table >> 2 < table_count, ErrorCode::kInvalidCount, "header table of primitive",
             static_cast<std::int64_t>(table >> 2), table_count);
    h.counts.primitive_table[p] = io.failed() ? 0 : static_cast<std::uint32_t>(table >> 2);
    constexpr ComponentType kTypes[3] = {ComponentType::kUint8, ComponentType::kUint16, ComponentType::kUint32};
    if (io.failed()) return;
    h.index_types[p] = kTypes[table & 3];
    const std::int64_t addressable = std::int64_t{1} << (8 * componentSize(h.index_types[p]));
    io.check(h.counts.table_vertex_count[table >> 2] <= addressable, ErrorCode::kInvalidCount,
             "header vertex count for the index type", h.counts.table_vertex_count[table >> 2], addressable);
    count(io, h.counts.primitive_face_count[p], kMaxCount, "header face count");
    spend(3 * std::uint64_t{h.counts.primitive_face_count[p]}, componentSize(h.index_types[p]));
  }
}

template <class Io>
void surfaceFields(Io& io, Header& h, bool has_dummies) {
  std::int64_t table_vertices = 0, faces = 0;
  for (const std::uint32_t n : h.counts.table_vertex_count) table_vertices += n;
  for (const std::uint32_t n : h.counts.primitive_face_count) faces += n;
  // The surface has about as many real vertices as the tables, and with the dummies half as many as faces.
  std::int64_t vertex_difference = std::int64_t{h.surface.real_vertices} - table_vertices;
  signedVarint(io, vertex_difference);
  const std::int64_t real_vertices = table_vertices + vertex_difference;
  if (has_dummies) {
    count(io, h.surface.dummies, kMaxCount, "header dummies");
    io.check(h.surface.dummies > 0, ErrorCode::kReservedBits, "header dummies", 0, 1);
  }
  const std::int64_t surface_vertices = real_vertices + h.surface.dummies;
  std::int64_t characteristic = surface_vertices - h.surface.faces / 2;
  signedVarint(io, characteristic);
  const std::int64_t surface_faces = 2 * (surface_vertices - characteristic);
  // A dummy has at least two faces, and every dummy face has a real one at its side: 4 times the real faces is ample.
  const std::int64_t face_limit = std::min<std::int64_t>(4 * faces, kMaxSurfaceFaces);
  io.check(surface_faces >= 0 && surface_faces <= face_limit, ErrorCode::kInvalidCount, "header surface faces",
           surface_faces, face_limit);
  io.check(real_vertices >= 0 && surface_vertices <= surface_faces * 3, ErrorCode::kInvalidCount,
           "header surface vertices", surface_vertices, surface_faces * 3);
  if (io.failed()) return;
  h.surface.faces = static_cast<std::uint32_t>(surface_faces);
  h.surface.real_vertices = static_cast<std::uint32_t>(real_vertices);
}

template <class Io>
void fields(Io& io, Header& header, const DecodeLimits& limits) {
  bool has_dummies = header.surface.dummies > 0;
  modeFields(io, header, has_dummies);
  if (io.failed()) return;
  latticeFields(io, header);
  if (io.failed()) return;
  outputFields(io, header, limits);
  if (io.failed()) return;
  surfaceFields(io, header, has_dummies);
}

}  // namespace

void writeHeader(const Header& header, std::vector<std::byte>& bytes) {
  HeaderWriter writer(bytes);
  Header copy = header;
  fields(writer, copy, {});
}

Status readHeader(std::span<const std::byte> stream, const DecodeLimits& limits, Header& header, std::size_t& size) {
  HeaderReader reader(stream);
  fields(reader, header, limits);
  size = reader.position();
  return reader.error();
}

std::vector<OutputInfo> outputsOf(const Header& header) {
  std::vector<OutputInfo> outputs;
  for (std::uint32_t t = 0; t < header.counts.table_vertex_count.size(); ++t) {
    const std::uint64_t n = header.counts.table_vertex_count[t];
    const auto stride = static_cast<std::uint32_t>(positionStride(header.position_type));
    outputs.push_back({OutputInfo::Kind::kPositions, header.position_type, t, n, stride, n * stride});
  }
  for (std::size_t p = 0; p < header.index_types.size(); ++p) {
    const std::uint64_t n = 3 * std::uint64_t{header.counts.primitive_face_count[p]};
    const auto stride = static_cast<std::uint32_t>(componentSize(header.index_types[p]));
    outputs.push_back(
        {OutputInfo::Kind::kIndices, header.index_types[p], header.counts.primitive_table[p], n, stride, n * stride});
  }
  return outputs;
}

}  // namespace tsc
