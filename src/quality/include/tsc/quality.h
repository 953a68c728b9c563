// How far apart two triangle meshes are: vertex errors, Metro, DAME; as numbers, tables and pictures.
//
// The measures take plain arrays. `compareScenes` applies all of them to lists of meshes, matching vertices whatever
// their order. No state between calls; every function may be called from any thread. Nothing here throws except for
// lack of memory. Input may be hostile: indices and coordinates are checked, and what cannot be measured is an error.
//
// Where positions are float they are widened to double once; all distances are computed in double.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tsc {

// ---------------------------------------------------------------------------------------------------------- Errors

enum class QualityErrorCode : std::uint8_t {
  kNoFaces,              ///< a mesh without a triangle of three different vertices, or without area
  kNonFinitePosition,    ///< a NaN or infinite coordinate at a vertex that a triangle uses
  kInvalidIndex,         ///< an index past the last vertex, or indices that are not a multiple of three
  kCountMismatch,        ///< arrays that should correspond and differ in length
  kConnectivityDiffers,  ///< no correspondence of vertices maps the one's triangles to the other's
  kUnreadableFile,       ///< a file that cannot be opened, read or written
  kInvalidFile,          ///< a file that is not what its name or header says
  kUnsupportedFile,      ///< a format or a variant of one that is not read here
};

/// An error as a value; `message` is a full line for a person.
struct QualityError {
  QualityErrorCode code;
  std::string message;
};

/// A value, or the error that prevented it.
template <class T>
class [[nodiscard]] Measured {
 public:
  Measured(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Measured(QualityError error) : state_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return state_.index() == 0; }
  T& operator*() & { return std::get<0>(state_); }
  const T& operator*() const& { return std::get<0>(state_); }
  T&& operator*() && { return std::get<0>(std::move(state_)); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }
  const QualityError& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, QualityError> state_;
};

// ---------------------------------------------------------------------------------------------------------- Arrays

/// Borrowed positions, x y z a vertex, in float or in double. Converts from spans and vectors of either.
class PositionView {
 public:
  PositionView() = default;
  PositionView(std::span<const float> values) : floats_(values.data()), count_(values.size() / 3) {}
  PositionView(std::span<const double> values) : doubles_(values.data()), count_(values.size() / 3) {}
  PositionView(const std::vector<float>& values) : PositionView(std::span<const float>(values)) {}
  PositionView(const std::vector<double>& values) : PositionView(std::span<const double>(values)) {}

  [[nodiscard]] std::size_t size() const { return count_; }  ///< vertices
  [[nodiscard]] std::array<double, 3> operator[](std::size_t vertex) const {
    if (floats_ != nullptr) return {floats_[3 * vertex], floats_[3 * vertex + 1], floats_[3 * vertex + 2]};
    return {doubles_[3 * vertex], doubles_[3 * vertex + 1], doubles_[3 * vertex + 2]};
  }

 private:
  const float* floats_ = nullptr;
  const double* doubles_ = nullptr;
  std::size_t count_ = 0;
};

/// Borrowed triangles, 3 indices each. Vertices that no triangle uses play no part in any measure.
struct SurfaceView {
  PositionView positions;
  std::span<const std::uint32_t> indices;
};

/// Diagonal of the axis-aligned box around the vertices that triangles use; 0 without triangles.
[[nodiscard]] double boundingBoxDiagonal(const SurfaceView& surface);

// ---------------------------------------------------------------------------------------------------- Vertex errors

/// Distances between corresponding vertices, in position units (mse: squared).
struct VertexErrors {
  std::uint64_t count = 0;         ///< pairs measured
  double mse = 0;                  ///< mean of |a - b|^2
  double rms = 0;                  ///< sqrt(mse)
  double max = 0;                  ///< largest |a - b|
  std::uint32_t worst_vertex = 0;  ///< vertex of A where it occurs
};

/// Errors between vertex i of `a` and vertex i of `b`, over all vertices.
/// Errors: kCountMismatch, kNonFinitePosition, kNoFaces (no vertices).
Measured<VertexErrors> vertexErrors(PositionView a, PositionView b);

/// In a correspondence: a vertex of A that no triangle with three different vertices uses.
inline constexpr std::uint32_t kUnmatchedVertex = 0xffffffff;

/// As above, between vertex i of `a` and vertex `b_of_a[i]` of `b`; entries of `kUnmatchedVertex` are left out.
Measured<VertexErrors> vertexErrors(PositionView a, PositionView b, std::span<const std::uint32_t> b_of_a);

/// Which vertex of B is vertex i of A.
struct Correspondence {
  /// What was matched: the vertices as they stand, or, where the meshes split vertices differently (seams), the points
  /// left when vertices of bit-equal position are welded.
  enum class Level : std::uint8_t { kVertices, kPoints };
  Level level = Level::kVertices;
  std::vector<std::uint32_t> b_of_a;  ///< one a vertex of A, or kUnmatchedVertex
  /// Vertices of A to average over: at kVertices all matched ones, at kPoints one a point.
  std::vector<std::uint32_t> representatives;
};

/// Finds the correspondence by position and connectivity, whatever the order of vertices and triangles: a seed triangle
/// per edge-connected part is matched by position and the match spread over the corner table; then every triangle is
/// verified (orientation included). Reliable while errors stay below the local edge length; if several correspondences
/// are possible, the one of least error found. Triangles naming a vertex twice are ignored.
/// Errors: kConnectivityDiffers, kNoFaces, kInvalidIndex, kNonFinitePosition.
Measured<Correspondence> matchVertices(const SurfaceView& a, const SurfaceView& b);

// ------------------------------------------------------------------------------------------------------------ Metro

struct MetroOptions {
  /// Samples on each surface, spread evenly by area; 0: twice the triangles, at least 50,000 and at most 1,000,000.
  std::uint64_t samples = 0;
  bool at_vertices = true;  ///< also measure at the vertices, for the maxima; the RMS is over the samples alone
  std::uint32_t seed = 1;   ///< shifts the sampling pattern; the same seed gives the same figures
};

/// Point-to-surface distances in position units, after Cignoni, Rocchini & Scopigno 1998 ("Metro").
struct MetroErrors {
  double rms_a_to_b = 0;  ///< over area samples of A, distance to B's surface
  double rms_b_to_a = 0;
  double max_a_to_b = 0;  ///< over area samples, and vertices, of A: a lower bound of the one-sided Hausdorff distance
  double max_b_to_a = 0;
  double area_a = 0;
  double area_b = 0;
  std::uint64_t samples = 0;  ///< on each surface, vertices not counted

  [[nodiscard]] double rms() const { return rms_a_to_b > rms_b_to_a ? rms_a_to_b : rms_b_to_a; }
  [[nodiscard]] double hausdorff() const { return max_a_to_b > max_b_to_a ? max_a_to_b : max_b_to_a; }
};

/// Metro between any two surfaces. Symmetric: swapping A and B swaps the two directions exactly.
/// Errors: kNoFaces, kInvalidIndex, kNonFinitePosition.
Measured<MetroErrors> metro(const SurfaceView& a, const SurfaceView& b, const MetroOptions& options = {});

/// Distance of each of `points` to the closest point of `surface`. Errors: as `metro`.
Measured<std::vector<double>> distancesToSurface(PositionView points, const SurfaceView& surface);

// ------------------------------------------------------------------------------------------------------------- DAME

/// Dihedral angle mesh error, \cite Vasa & Rus 2012: the mean over interior edges of |D - D'| exp(ln 100 ((pi - |D|) /
/// pi)^2) in radians. D is the oriented angle between the normals of the two triangles at the edge: 0 where flat,
/// positive where convex, up to pi where folded over. The visibility term is left out (1 everywhere). Not symmetric:
/// the mask is taken from A.
struct DameError {
  double value = 0;
  std::uint64_t edges = 0;          ///< interior edges measured: two triangles, consistently oriented
  std::uint64_t skipped_edges = 0;  ///< interior edges where a triangle of A or B has no area, hence no normal
};

/// `b` holds the new positions of A's vertices, in A's order. Interior edges are those of A with vertices of bit-equal
/// position in A welded, so that seams do not hide edges. A mesh without interior edges has value 0 and edges 0.
/// Errors: kCountMismatch, kNoFaces, kInvalidIndex, kNonFinitePosition.
Measured<DameError> dame(const SurfaceView& a, PositionView b);

/// As above for vertices in another order.
Measured<DameError> dame(const SurfaceView& a, PositionView b, std::span<const std::uint32_t> b_of_a);

// ----------------------------------------------------------------------------------------------------------- Scenes

/// One mesh with a name and its arrays, owned; all primitives of a glTF mesh together.
struct NamedSurface {
  std::string name;
  std::vector<double> positions;
  std::vector<std::uint32_t> indices;
  /// Where it stands in the scene: column-major 4x4 matrices, one an instance; empty: once, as it is. For pictures
  /// alone: all figures are in the mesh's own space.
  std::vector<std::array<double, 16>> placements;

  [[nodiscard]] SurfaceView view() const { return {positions, indices}; }
};

/// Reads a mesh by its extension: .ply (ascii, binary of both byte orders; polygons as fans), .obj (all groups as one
/// mesh), .stl (ascii, binary; welded by bit-equal position). Errors: kUnreadableFile, kInvalidFile, kUnsupportedFile.
Measured<NamedSurface> readSurfaceFile(const std::filesystem::path& path);

struct MeshComparison {
  std::string name;
  std::uint64_t vertices_a = 0, vertices_b = 0;  ///< in the tables
  std::uint64_t triangles_a = 0, triangles_b = 0;
  double diagonal = 0;                           ///< of A's box
  std::optional<Correspondence> correspondence;  ///< absent: connectivity differs, then so are the next two
  std::optional<VertexErrors> vertices;
  std::optional<DameError> dame;
  MetroErrors metro;
};

struct Comparison {
  std::vector<MeshComparison> meshes;
  /// All meshes together: vertex errors over all vertices, DAME over all edges, Metro over all area, maxima of maxima;
  /// diagonal of the box around all meshes in their own spaces. Vertex errors and DAME only if all meshes have them.
  MeshComparison total;
};

/// Compares mesh i of `a` with mesh i of `b`. Errors: kCountMismatch, and those of `metro` with the mesh's name.
Measured<Comparison> compareScenes(std::span<const NamedSurface> a, std::span<const NamedSurface> b,
                                   const MetroOptions& options = {});

/// The comparison as a table for people, one line a mesh and a total.
[[nodiscard]] std::string comparisonTable(const Comparison& comparison);

/// The same as a JSON object `{"meshes": [...], "total": {...}}`; what could not be measured is null.
[[nodiscard]] std::string comparisonJson(const Comparison& comparison, int indent = 2);

// --------------------------------------------------------------------------------------------------------- Pictures

/// Error at each vertex of `b`: to its counterpart where `result` has a correspondence, else to A's surface.
Measured<std::vector<double>> vertexErrorField(const NamedSurface& a, const NamedSurface& b,
                                               const MeshComparison& result);

/// A GLB with the meshes of B, error as vertex colours; the scene's name is the legend. Empty on success.
[[nodiscard]] std::optional<QualityError> writeHeatmapGlb(const std::filesystem::path& path,
                                                          std::span<const NamedSurface> a,
                                                          std::span<const NamedSurface> b,
                                                          const Comparison& comparison);

/// A PNG with A shaded on the left, B in error colours on the right and a scale bar, from a camera fitted to A.
[[nodiscard]] std::optional<QualityError> writeHeatmapPng(const std::filesystem::path& path,
                                                          std::span<const NamedSurface> a,
                                                          std::span<const NamedSurface> b,
                                                          const Comparison& comparison);

}  // namespace tsc
