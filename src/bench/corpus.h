// Meshes to measure on: read from glTF files, or made (patches, subdivision, planes).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tsc::bench {

/// One welded triangle mesh. Positions are distinct, bit by bit; -0 has become +0. Every vertex is used by a triangle.
struct BenchMesh {
  std::string name;        ///< file name without extension, with a number where a file has several meshes
  std::string class_name;  ///< folder that the file was in
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  std::size_t dropped_vertices = 0;  ///< vertices of the file that no triangle uses, left out

  std::size_t vertexCount() const { return positions.size() / 3; }
  std::size_t faceCount() const { return indices.size() / 3; }
  /// Hash of the arrays, as 16 hexadecimal digits: the key of cached results.
  std::string contentKey() const;
};

/// A file to read later: meshes are read one at a time, as they are measured.
struct CorpusFile {
  std::filesystem::path path;
  std::uintmax_t bytes = 0;
};

/// Lists the .glb and .gltf files among the arguments and, recursively, in the folders among them; sorted by path.
/// Throws std::runtime_error when an argument does not exist or nothing is found.
std::vector<CorpusFile> listFiles(const std::vector<std::string>& arguments);

/// `count` of the files, spread evenly over the folders they are in: what --quick measures.
std::vector<CorpusFile> spreadSelection(const std::vector<CorpusFile>& files, std::size_t count);

/// Reads all triangle meshes of a glTF file: positions and indices alone, the primitives of a mesh joined and welded.
/// Vertices that no triangle uses are left out: Draco drops them where our codec keeps them, and both are to have the
/// same input. Throws std::runtime_error, naming the file, on a file that cannot be read, without triangles, or with
/// positions that are not finite.
std::vector<BenchMesh> loadMeshes(const std::filesystem::path& path);

/// Every n-th file of each folder, from the middle of the first n on; at least one of each folder.
std::vector<CorpusFile> everyNth(const std::vector<CorpusFile>& files, std::size_t n);

/// Leaves out the vertices that no triangle uses; the others keep their order.
void dropUnusedVertices(BenchMesh& mesh);

/// A connected patch of about `vertex_count` vertices, grown face by face from the middle of the face list. Returns
/// the whole mesh when it has no more vertices than that.
BenchMesh cutPatch(const BenchMesh& mesh, std::size_t vertex_count);

/// Splits each triangle in four at the edges' midpoints, and moves each new vertex along the edge's mean normal by
/// up to 2% of the edge's length (a fixed pseudo-random sequence): without that, midpoints are predicted exactly, and a
/// codec would be timed on data that does not occur.
BenchMesh subdivide(const BenchMesh& mesh);

/// A square plane of `side` x `side` vertices jittered within it, turned by `degrees` around the x axis.
BenchMesh makePlane(std::size_t side, double degrees);

}  // namespace tsc::bench
