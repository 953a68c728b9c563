// glTF assets <-> assets whose meshes are packed under EXT_mesh_tangentspace_compression.
//
// An asset is a JSON document plus the bytes of its buffers. It is patched in place: whatever pack or unpack does not
// own (unknown extensions, extras, explicit defaults, images, GLB chunks, numbers of any size) comes out as it went in.
//
// No exception leaves these functions. A failure is a value with a message for a person: file, JSON pointer or byte
// offset, what was found, what was expected. Input may be hostile. Functions on different assets may run at the same
// time on different threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "tsc/codec.h"

namespace tsc {

/// Name of the glTF extension; a draft, hence in one place.
inline constexpr std::string_view kExtensionName = "EXT_mesh_tangentspace_compression";

// -------------------------------------------------------------------------------------------------------- Failures

/// What kind of failure; the values are the exit codes of the command line.
enum class FailureKind : std::uint8_t {
  kUsage = 1,         ///< options that make no sense, or an output that exists already
  kInvalidInput = 2,  ///< the asset breaks the rules of JSON, GLB, glTF or the stream
  kUnsupported = 3,   ///< correct perhaps, but it needs something this library does not do
  kIo = 4,            ///< reading or writing failed
  kBound = 5,         ///< the error bound could not be met
};

/// A failure as a value. The message is one line: file, place, found, expected.
struct Failure {
  FailureKind kind;
  std::string message;
};

/// A value, or the failure that prevented it.
template <class T>
class [[nodiscard]] Expected {
 public:
  Expected(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Expected(Failure failure) : state_(std::in_place_index<1>, std::move(failure)) {}

  explicit operator bool() const { return state_.index() == 0; }
  T& operator*() & { return std::get<0>(state_); }
  const T& operator*() const& { return std::get<0>(state_); }
  T&& operator*() && { return std::get<0>(std::move(state_)); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }
  const Failure& failure() const { return std::get<1>(state_); }

 private:
  std::variant<T, Failure> state_;
};

/// Success (empty), or a failure.
using Outcome = std::optional<Failure>;

// ---------------------------------------------------------------------------------------------------------- Assets

/// The document. Members keep their order. Integers beyond 64 bits are held as `binary` values with their digits, so
/// that they are written as they were read; use `writeJson` and not `dump` to print a document.
using Json = nlohmann::ordered_json;

/// Bounds on what an input may make us do.
struct Limits {
  std::uint32_t max_json_depth = 512;
  std::uint64_t max_input_bytes = std::uint64_t{1} << 32;   ///< of any one file
  std::uint64_t max_output_bytes = std::uint64_t{1} << 32;  ///< of all decoded and expanded data together
};

/// Gives the bytes behind a relative URI (already percent-decoded), or nothing if there are none.
using UriResolver = std::function<std::optional<std::vector<std::byte>>(std::string_view uri)>;

struct LoadOptions {
  Limits limits;
  /// Follow URIs that leave the asset's folder (by "..", an absolute path or a symbolic link). Never the network.
  bool allow_external = false;
};

/// The bytes of `document.buffers[i]`.
struct Buffer {
  enum class Source : std::uint8_t {
    kGlbChunk,     ///< the BIN chunk of a GLB file
    kDataUri,      ///< embedded in the document
    kFile,         ///< an external file
    kPlaceholder,  ///< no bytes: filled by decoding (ours or meshopt's fallback buffers)
    kMemory,       ///< made by this library; not stored anywhere yet
  };
  Source source = Source::kMemory;
  std::vector<std::byte> bytes;
  bool modified = false;  ///< the bytes are no longer those that the source holds
};

/// A GLB chunk other than JSON and the first BIN; kept as it is.
struct GlbChunk {
  std::uint32_t type = 0;
  std::vector<std::byte> bytes;
};

/// A loaded asset.
struct Asset {
  std::string name;              ///< for messages: the path as given
  std::filesystem::path folder;  ///< where relative URIs are resolved; empty if from memory
  bool is_glb = false;           ///< read from a GLB container
  Json document;
  std::vector<Buffer> buffers;  ///< one per `document.buffers`
  std::vector<GlbChunk> extra_chunks;
  LoadOptions options;
};

/// Loads `.gltf` or `.glb` (told apart by content) with its buffers. Images stay where they are.
Expected<Asset> loadAsset(const std::filesystem::path& path, const LoadOptions& options = {});

/// The same from memory. `name` is used in messages; external buffers come from `resolver` (none: they are an error).
Expected<Asset> loadAsset(std::span<const std::byte> bytes, std::string_view name, const UriResolver& resolver = {},
                          const LoadOptions& options = {});

struct SaveOptions {
  bool force = false;  ///< replace files that exist
};

/// Writes `.gltf` (with `<stem>.bin` beside it for buffers that changed) or `.glb`, by the extension of `path`.
/// External files that the document names (images, unchanged buffers) are copied to the new folder if that is another
/// one; a different file of the same name there is a failure unless `force`. Each file is written beside its target,
/// flushed and renamed, the document last; on failure nothing new is left behind. Overwriting the input is allowed
/// with `force`.
[[nodiscard]] Outcome saveAsset(const Asset& asset, const std::filesystem::path& path, const SaveOptions& options = {});

/// The asset as one GLB, for standard output or a viewer. URIs of external images stay as they are.
Expected<std::vector<std::byte>> writeGlb(const Asset& asset);

/// Prints a document: every number with its value to the last bit. `indent` < 0: on one line.
[[nodiscard]] std::string writeJson(const Json& document, int indent = -1);

/// Writes a file beside its target, flushes it and renames it. Failures: kUsage if it exists and not `force`, kIo.
[[nodiscard]] Outcome writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes, bool force);

/// Reads a whole file. Failure: kIo, or kInvalidInput above `max_bytes`.
Expected<std::vector<std::byte>> readFile(const std::filesystem::path& path, std::uint64_t max_bytes);

// --------------------------------------------------------------------------------------------------------- Packing

/// How precise float positions come back. Per stream; the step follows from it.
struct Precision {
  enum class Kind : std::uint8_t {
    kPositionBits,   ///< step = largest extent / (2^value - 1); 1..24
    kStep,           ///< the step itself, on a lattice shared by all meshes: packing again loses nothing
    kMaxError,       ///< the largest step whose guaranteed error is at most `value` asset units
    kRelativeError,  ///< the same, `value` times the diagonal of the mesh's bounding box
    kTargetBpv,      ///< the step at which the stream takes `value` bits per vertex
  };
  Kind kind = Kind::kPositionBits;
  double value = 14;
};

struct PackOptions {
  Precision precision;
  std::uint32_t normal_scale = 1;
  Mode mode = Mode::kAuto;
  Basis basis = Basis::kAuto;
  Predictor predictor = Predictor::kAuto;
  Order order = Order::kAuto;
  Effort effort = Effort::kDefault;
  /// Also store the decoded data, so that readers without the extension can load the asset.
  bool fallback = false;
  /// Unpack first what is packed already; without it, packed input is a kUsage failure.
  bool repack = false;
  /// Store the original order of vertices and triangles beside each stream: unpacked, they come back in it, each
  /// triangle with its first corner. Attributes and indices that are not packed then stay where they are.
  bool keep_order = false;
  /// Called before each stream with the work done and the whole, in triangles. May be empty.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;
};

/// One stream made by pack: a mesh, or the meshes that share vertex data.
struct StreamReport {
  std::vector<std::size_t> meshes;  ///< indices into `document.meshes`
  std::string label;                ///< their names, or "meshes/3"
  std::uint64_t vertices = 0;       ///< of all vertex tables
  std::uint64_t unique_positions = 0;
  std::uint64_t triangles = 0;
  std::uint64_t input_position_bytes = 0;  ///< plain size of the positions before
  std::uint64_t input_index_bytes = 0;     ///< plain size of the indices before
  std::uint64_t stream_bytes = 0;
  std::uint64_t order_bytes = 0;  ///< of the original order, where it is kept
  StreamBits bits;       ///< of the stream's parts; divide by `vertices` for bits per vertex
  StreamModes modes;     ///< as chosen
  double max_error = 0;  ///< measured, position units
  double rms_error = 0;
  double guaranteed_error = 0;  ///< the bound
  double diagonal = 0;          ///< of the bounding box of all positions
};

/// Triangles that stay as they were, and why.
struct KeptReport {
  std::size_t mesh = 0;
  std::optional<std::size_t> primitive;  ///< none: the whole mesh
  std::string label;
  std::string reason;
};

struct PackReport {
  std::vector<StreamReport> streams;
  std::vector<KeptReport> kept;
  std::vector<std::string> warnings;
  std::uint64_t input_bytes = 0;      ///< JSON and buffers before
  std::uint64_t output_bytes = 0;     ///< and after
  std::uint64_t attribute_bytes = 0;  ///< of attributes carried along uncompressed
};

/// Packs every mesh that can be, in place. Each stream has been decoded and compared (same triangles over the same
/// corners, every position within the bound) when this returns. On failure the asset must not be used.
Expected<PackReport> packAsset(Asset& asset, const PackOptions& options = {});

/// Turns a packed asset into plain glTF, in place. An asset that is not packed stays as it is.
[[nodiscard]] Outcome unpackAsset(Asset& asset);

/// Whether the document uses the extension.
[[nodiscard]] bool isPacked(const Asset& asset);

/// A packed or plain asset (GLB or JSON text) in, plain GLB out; for viewers that load from memory.
Expected<std::vector<std::byte>> expand(std::span<const std::byte> bytes, const UriResolver& resolver = {},
                                        const Limits& limits = {});

// ------------------------------------------------------------------------------------------------------ Inspecting

/// One stream found in a packed asset.
struct StreamSummary {
  std::size_t buffer_view = 0;  ///< that holds it
  std::uint64_t stream_bytes = 0;
  std::uint64_t order_bytes = 0;  ///< of the original order, where it is kept
  std::vector<std::size_t> meshes;
  std::string label;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t decoded_bytes = 0;
  StreamInfo info;  ///< header: version, modes, outputs
};

struct AssetSummary {
  bool packed = false;
  std::uint64_t json_bytes = 0;
  std::uint64_t buffer_bytes = 0;
  std::size_t meshes = 0;
  std::size_t primitives = 0;
  std::uint64_t vertices = 0;   ///< of all distinct POSITION accessors
  std::uint64_t triangles = 0;  ///< of all primitives
  std::vector<std::string> extensions_used;
  std::vector<StreamSummary> streams;
};

/// Counts, sizes and stream headers. Decodes nothing.
Expected<AssetSummary> inspectAsset(const Asset& asset);

}  // namespace tsc
