// The codecs that ours is measured against: Draco 1.5.5 and meshoptimizer, as Debian builds them.
#pragma once

#include <cstdint>
#include <vector>

#include "corpus.h"

namespace draco {
class Mesh;
}

namespace tsc::bench {

/// A mesh in Draco's own form. Positions are welded already, so what draco_encoder does after reading a file (merging
/// equal positions, then equal points) changes nothing and is not run again.
class DracoMesh {
 public:
  explicit DracoMesh(const BenchMesh& mesh);
  ~DracoMesh();
  DracoMesh(const DracoMesh&) = delete;
  DracoMesh& operator=(const DracoMesh&) = delete;
  const draco::Mesh& get() const { return *mesh_; }

 private:
  draco::Mesh* mesh_;
};

struct DracoStream {
  std::vector<char> bytes;
  /// Length of the stream when attribute data starts: header, counts, connectivity. Only from `encodeDracoInParts`.
  std::size_t connectivity_bytes = 0;
};

/// Encodes as `draco_encoder -cl level -qp bits` does: Edgebreaker, speeds 10 - level. Throws on Draco's errors.
DracoStream encodeDraco(const DracoMesh& mesh, int level, int bits);

/// The same bytes by way of Draco's mesh encoder class itself, which lets us see where connectivity ends.
DracoStream encodeDracoInParts(const DracoMesh& mesh, int level, int bits);

struct DecodedDraco {
  std::vector<float> positions;
  std::size_t face_count = 0;
};

/// Decodes with Draco's decoder and copies the positions out. Throws on Draco's errors.
DecodedDraco decodeDraco(const std::vector<char>& bytes);

/// Decodes with Draco's decoder and drops the result: what is timed.
void decodeDracoOnly(const std::vector<char>& bytes);

/// Where Draco's quantisation puts each vertex, in the order of the mesh: its float arithmetic on its grid.
std::vector<float> dracoGridPositions(const BenchMesh& mesh, int bits);

struct DracoDistortion {
  double mse_by_grid = 0;            ///< over all vertices, from `dracoGridPositions`
  double mse_by_decoder = 0;         ///< over the vertices that came back, from the decoded positions
  std::size_t dropped_vertices = 0;  ///< vertices that Draco does not code: only degenerate triangles use them
};

/// Distortion of a decoded Draco stream, computed in both ways. Decoded vertices come in another order, so each is
/// matched to the input vertices of its grid cell. Throws when a decoded vertex lies in a cell that no vertex is in.
DracoDistortion dracoDistortion(const BenchMesh& mesh, const DecodedDraco& decoded, int bits);

/// meshoptimizer's vertex and index codecs, on 16-bit positions and vertex-cache-optimised triangles.
class MeshoptCodec {
 public:
  struct Stream {
    std::vector<unsigned char> vertices, indices;
    std::size_t vertex_count = 0, index_count = 0;
    std::size_t bytes() const { return vertices.size() + indices.size(); }
  };
  /// Quantises to 16 bits, reorders for the vertex cache and vertex fetch (its index codec needs that), encodes.
  static Stream encode(const BenchMesh& mesh);
  /// Decodes into arrays of its own and drops them. Throws when the library refuses the stream.
  static void decode(const Stream& stream);
};

}  // namespace tsc::bench
