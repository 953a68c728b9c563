// The tangent-space mesh codec: bytes <-> triangle meshes.
//
// One stream holds triangles over the positions of one or more vertex tables, split into primitives. Triangles and
// vertices come back complete but in another order; `EncodeResult` says which. Corners with bit-equal positions, in
// whatever table or primitive, decode to bit-equal positions.
//
// Nothing here throws, does I/O, starts a thread or keeps state between calls: every function may be called from any
// thread at the same time. `decode` and `readStreamInfo` may be given hostile bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tsc {

// ---------------------------------------------------------------------------------------------------------- Errors

/// What went wrong. The names printed by `describe` are the enumerators' own.
enum class ErrorCode : std::uint8_t {
  // The caller's input to `encode`.
  kInvalidArgument,    ///< an option or index out of range
  kNonFinitePosition,  ///< a NaN or infinite coordinate
  kLatticeTooFine,     ///< extent / step needs more than kMaxLatticeBits bits
  kBoundNotMet,        ///< a vertex ended farther from its input than the guaranteed bound
  // The bytes given to `decode`.
  kTruncated,           ///< the stream ends before its content does
  kUnsupportedVersion,  ///< a format version this decoder does not know
  kReservedBits,        ///< a bit that must be zero is set, or a field has an undefined value
  kLimitExceeded,       ///< the outputs would be larger than the caller allows
  kInvalidSymbol,       ///< a decoded symbol that the state at that point does not permit
  kInvalidCount,        ///< counts that contradict each other
  kTrailingData,        ///< bytes left over after the last symbol
  kChecksumMismatch,    ///< the decoded output is not what the encoder wrote
  kOutputMismatch,      ///< the caller's output buffers do not have the sizes that `readStreamInfo` gave
};

/// An error as a value. `where` names the stage or argument and lives forever; `found` and `expected` are numbers in
/// the unit that `where` implies; `byte_offset` is where in the stream reading stood (0 on the encoder's side).
struct Error {
  ErrorCode code;
  const char* where = "";
  std::uint64_t byte_offset = 0;
  std::int64_t found = 0;
  std::int64_t expected = 0;
};

/// One line for a person: code, place, found and expected.
[[nodiscard]] std::string describe(const Error& error);

/// A value, or the error that prevented it.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, error) {}

  explicit operator bool() const { return state_.index() == 0; }
  T& operator*() & { return std::get<0>(state_); }
  const T& operator*() const& { return std::get<0>(state_); }
  T&& operator*() && { return std::get<0>(std::move(state_)); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

/// Success, or an error.
using Status = std::optional<Error>;

// ---------------------------------------------------------------------------------------------------------- Meshes

/// Component type of a decoded array. The values are those of the stream (BITSTREAM.md, section 2).
enum class ComponentType : std::uint8_t { kInt8 = 0, kUint8 = 1, kInt16 = 2, kUint16 = 3, kUint32 = 4, kFloat32 = 5 };

/// Bytes of one component: 1, 2 or 4.
[[nodiscard]] std::size_t componentSize(ComponentType type);

/// Bytes from one decoded position to the next: three components, padded to a multiple of four.
[[nodiscard]] std::size_t positionStride(ComponentType type);

/// Positions x y z of the vertices that a set of primitives indexes: 3 floats a vertex, finite. Borrowed.
struct VertexTable {
  std::span<const float> positions;
};

/// Triangles over one table. Borrowed.
struct Primitive {
  std::uint32_t table = 0;                            ///< index into `Mesh::tables`
  std::span<const std::uint32_t> indices;             ///< 3 a triangle, each below the table's vertex count
  ComponentType index_type = ComponentType::kUint32;  ///< kUint8, kUint16 or kUint32: type of the decoded indices
};

/// What one stream codes. All tables share one position type: float32, or an integer type whose values (exact in
/// float) are then coded without loss.
struct Mesh {
  std::vector<VertexTable> tables;
  std::vector<Primitive> primitives;
  ComponentType position_type = ComponentType::kFloat32;
};

// -------------------------------------------------------------------------------------------------------- Encoding

/// Where residuals live. Tangent: in a local orthonormal basis (paper, section 4). Lattice: along the axes.
enum class Mode : std::uint8_t { kAuto, kLattice, kTangent };
/// Orientation of the tangent basis: gate-aligned (paper, eq. 5) or tip-aligned (eq. 7).
enum class Basis : std::uint8_t { kAuto, kGate, kTip };
/// What the residual is measured from. Parallelogram: eq. 1. Weighted: eq. 2-4 with the known inner angles around the
/// gate. Valence: eq. 2-4 with valence-derived angles alone. Average: mean of all complete parallelograms.
/// Adaptive: the average corrected by weights learned on the way.
enum class Predictor : std::uint8_t { kAuto, kParallelogram, kWeighted, kValence, kAverage, kAdaptive };
/// In which order positions are coded: as the connectivity met them, or by most complete parallelograms first.
enum class Order : std::uint8_t { kAuto, kTraversal, kDegree };
/// How many predictors and contexts are mixed: bits against time, on both sides.
enum class Effort : std::uint8_t { kDefault, kMax };

struct EncodeOptions {
  /// Tangential step in position units, > 0; it is used rounded to float32. Ignored for integer positions (step 1).
  double step = 0;
  /// Where the lattice starts. False: at the smallest coordinates of the mesh. True: at a multiple of the step, so that
  /// meshes coded with the same step share one lattice and coding a decoded mesh again changes nothing.
  bool anchored = false;
  /// Normal step = step / normal_scale, 1..16. Applies to tangent mode only.
  std::uint32_t normal_scale = 1;
  Mode mode = Mode::kAuto;
  Basis basis = Basis::kAuto;
  Predictor predictor = Predictor::kAuto;
  Order order = Order::kAuto;
  Effort effort = Effort::kDefault;
};

/// The step at which the mesh's largest extent spans 2^bits - 1 steps, as Draco's -qp; 1 for a mesh without extent.
[[nodiscard]] double stepForBits(const Mesh& mesh, int bits);

/// Largest distance between an input position and its decoded one that these options can lead to, in position units:
/// half the diagonal of a lattice cell, the rotation's rounding and the final rounding to float32 included.
[[nodiscard]] double guaranteedError(const Mesh& mesh, const EncodeOptions& options);

/// How a stream is built; chosen by the encoder, or read from a header.
struct StreamModes {
  Mode mode = Mode::kLattice;
  Basis basis = Basis::kGate;
  Predictor predictor = Predictor::kParallelogram;
  Order order = Order::kTraversal;
  Effort effort = Effort::kDefault;
  std::uint32_t normal_scale = 1;
  double step = 0;  ///< tangential step in position units
};

/// Bits spent on each part; their sum is the stream's length up to the coder's rounding.
struct StreamBits {
  double header = 0;
  double connectivity = 0;  ///< the welded, cut surface
  double positions = 0;
  double references = 0;  ///< vertices met again at cuts
  double corners = 0;     ///< which table vertex each corner uses, which primitive each face belongs to
  double side_faces = 0;  ///< degenerate and duplicate triangles, unused vertices
};

struct EncodeResult {
  std::vector<std::byte> bytes;
  /// Per table: input vertex of each decoded vertex; a permutation.
  std::vector<std::vector<std::uint32_t>> vertex_order;
  /// Per primitive: 3 * input triangle + first corner, for each decoded triangle: decoded corner c of a triangle with
  /// the value 3 t + k is input corner 3 t + (k + c) % 3.
  std::vector<std::vector<std::uint32_t>> triangle_order;
  StreamModes modes;
  StreamBits bits;
  std::uint64_t unique_positions = 0;  ///< after welding
  double max_error = 0;                ///< largest distance between an input vertex and its decoded position, measured
  double rms_error = 0;                ///< over the table vertices
};

/// Codes the mesh. The result has been decoded and compared before it is returned; deterministic on every platform.
/// Errors: kInvalidArgument, kNonFinitePosition, kLatticeTooFine, kBoundNotMet.
Result<EncodeResult> encode(const Mesh& mesh, const EncodeOptions& options);

// -------------------------------------------------------------------------------------------------------- Decoding

/// One decoded array. Outputs are numbered tables first, then primitives.
struct OutputInfo {
  enum class Kind : std::uint8_t { kPositions, kIndices };
  Kind kind;
  ComponentType type;
  std::uint32_t table = 0;        ///< of a primitive: the table that it indexes
  std::uint64_t count = 0;        ///< vertices, or indices (3 a triangle)
  std::uint32_t byte_stride = 0;  ///< between positions, or between indices
  std::uint64_t byte_length = 0;  ///< count * byte_stride
};

struct StreamInfo {
  std::uint32_t version = 0;
  StreamModes modes;
  std::vector<OutputInfo> outputs;
};

struct DecodeLimits {
  std::uint64_t max_output_bytes = std::uint64_t{1} << 32;
};

/// Reads the header alone. The counts it gives are claims that only `decode` can confirm.
Result<StreamInfo> readStreamInfo(std::span<const std::byte> stream, const DecodeLimits& limits = {});

/// Decodes into the caller's arrays, one a output in the order of `StreamInfo::outputs`, each exactly `byte_length`
/// long. On error their content is unspecified and must not be used.
[[nodiscard]] Status decode(std::span<const std::byte> stream, std::span<const std::span<std::byte>> outputs,
                            const DecodeLimits& limits = {});

/// As `decode`, into arrays of its own.
Result<std::vector<std::vector<std::byte>>> decode(std::span<const std::byte> stream, const DecodeLimits& limits = {});

}  // namespace tsc
