// The codecs that ours is measured against.
//
// Trap: Draco's position grid is float arithmetic throughout; `dracoGridPositions` repeats it operation for operation
// (AttributeQuantizationTransform and Quantizer of Draco 1.5.5), and `dracoDistortion` checks that against the decoder.
#include "peers.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_encoder.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>
#include <unordered_map>

namespace tsc::bench {

namespace {

void require(const draco::Status& status) {
  if (!status.ok()) throw std::runtime_error("Draco: " + status.error_msg_string());
}

draco::EncoderOptions dracoOptions(int level, int bits) {
  draco::EncoderOptions options = draco::EncoderOptions::CreateDefaultOptions();
  options.SetSpeed(10 - level, 10 - level);
  options.SetAttributeInt(0, "quantization_bits", bits);
  return options;
}

/// Draco's mesh encoder, noting the length of its buffer when attributes begin.
class ObservedEncoder : public draco::MeshEdgebreakerEncoder {
 public:
  std::size_t connectivity_bytes = 0;

 protected:
  bool EncodePointAttributes() override {
    connectivity_bytes = buffer()->size();
    return draco::MeshEdgebreakerEncoder::EncodePointAttributes();
  }
};

/// Draco's grid for a mesh: its origin, and its range in floats.
struct DracoGrid {
  float origin[3];
  float inverse_delta, delta;

  DracoGrid(const BenchMesh& mesh, int bits) {
    float range = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      float low = mesh.positions[c], high = low;
      for (std::size_t i = c; i < mesh.positions.size(); i += 3) {
        low = std::min(low, mesh.positions[i]);
        high = std::max(high, mesh.positions[i]);
      }
      origin[c] = low;
      range = std::max(range, high - low);
    }
    if (range == 0) range = 1;
    const auto largest = static_cast<float>((1 << bits) - 1);
    inverse_delta = largest / range;
    delta = range / largest;
  }
  int cell(float value, std::size_t c) const {
    return static_cast<int>(std::floor((value - origin[c]) * inverse_delta + 0.5f));
  }
  float position(int cell, std::size_t c) const { return static_cast<float>(cell) * delta + origin[c]; }
  std::uint64_t key(const float* p) const {
    std::uint64_t key = 0;
    for (std::size_t c = 0; c < 3; ++c) key = key << 21 | static_cast<std::uint64_t>(cell(p[c], c) & 0x1fffff);
    return key;
  }
};

double squaredDistance(const float* a, const float* b) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += (double(a[c]) - b[c]) * (double(a[c]) - b[c]);
  return sum;
}

}  // namespace

DracoMesh::DracoMesh(const BenchMesh& source) : mesh_(new draco::Mesh) {
  mesh_->set_num_points(static_cast<std::uint32_t>(source.vertexCount()));
  draco::GeometryAttribute description;
  description.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 3 * sizeof(float), 0);
  const int id = mesh_->AddAttribute(description, true, static_cast<std::uint32_t>(source.vertexCount()));
  for (std::uint32_t v = 0; v < source.vertexCount(); ++v) {
    mesh_->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &source.positions[3 * v]);
  }
  mesh_->SetNumFaces(source.faceCount());
  for (std::uint32_t f = 0; f < source.faceCount(); ++f) {
    draco::Mesh::Face face;
    for (std::uint32_t c = 0; c < 3; ++c) face[c] = draco::PointIndex(source.indices[3 * f + c]);
    mesh_->SetFace(draco::FaceIndex(f), face);
  }
}

DracoMesh::~DracoMesh() { delete mesh_; }

DracoStream encodeDraco(const DracoMesh& mesh, int level, int bits) {
  draco::ExpertEncoder encoder(mesh.get());
  encoder.Reset(dracoOptions(level, bits));
  draco::EncoderBuffer buffer;
  require(encoder.EncodeToBuffer(&buffer));
  return {{buffer.data(), buffer.data() + buffer.size()}, 0};
}

DracoStream encodeDracoInParts(const DracoMesh& mesh, int level, int bits) {
  ObservedEncoder encoder;
  encoder.SetMesh(mesh.get());
  draco::EncoderBuffer buffer;
  require(encoder.Encode(dracoOptions(level, bits), &buffer));
  return {{buffer.data(), buffer.data() + buffer.size()}, encoder.connectivity_bytes};
}

DecodedDraco decodeDraco(const std::vector<char>& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  require(result.status());
  const draco::Mesh& mesh = *result.value();
  const draco::PointAttribute* attribute = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  DecodedDraco decoded;
  decoded.face_count = mesh.num_faces();
  decoded.positions.resize(3 * mesh.num_points());
  for (std::uint32_t p = 0; p < mesh.num_points(); ++p) {
    attribute->GetMappedValue(draco::PointIndex(p), &decoded.positions[3 * p]);
  }
  return decoded;
}

void decodeDracoOnly(const std::vector<char>& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  require(decoder.DecodeMeshFromBuffer(&buffer).status());
}

std::vector<float> dracoGridPositions(const BenchMesh& mesh, int bits) {
  const DracoGrid grid(mesh, bits);
  std::vector<float> positions(mesh.positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = grid.position(grid.cell(mesh.positions[i], i % 3), i % 3);
  }
  return positions;
}

DracoDistortion dracoDistortion(const BenchMesh& mesh, const DecodedDraco& decoded, int bits) {
  const DracoGrid grid(mesh, bits);
  DracoDistortion distortion;
  const std::vector<float> expected = dracoGridPositions(mesh, bits);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    distortion.mse_by_grid += squaredDistance(&mesh.positions[i], &expected[i]);
  }
  distortion.mse_by_grid /= double(mesh.vertexCount());

  std::unordered_map<std::uint64_t, const float*> decoded_cells;
  for (std::size_t i = 0; i < decoded.positions.size(); i += 3) {
    decoded_cells[grid.key(&decoded.positions[i])] = &decoded.positions[i];
  }
  std::size_t matched = 0;
  std::unordered_map<std::uint64_t, bool> used_cells;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    const std::uint64_t key = grid.key(&mesh.positions[i]);
    const auto found = decoded_cells.find(key);
    if (found == decoded_cells.end()) continue;
    used_cells[key] = true;
    distortion.mse_by_decoder += squaredDistance(&mesh.positions[i], found->second);
    ++matched;
  }
  if (used_cells.size() != decoded_cells.size()) {
    throw std::runtime_error(fmt::format("Draco at {} bits decoded {} positions that its grid does not have", bits,
                                         decoded_cells.size() - used_cells.size()));
  }
  distortion.mse_by_decoder /= double(std::max<std::size_t>(matched, 1));
  distortion.dropped_vertices = mesh.vertexCount() - matched;
  return distortion;
}

MeshoptCodec::Stream MeshoptCodec::encode(const BenchMesh& mesh) {
  constexpr std::size_t kVertexBytes = 8;  // three 16-bit coordinates and padding: the codec wants multiples of four
  constexpr int kBits = 16;
  Stream stream;
  stream.vertex_count = mesh.vertexCount();
  stream.index_count = mesh.indices.size();

  const DracoGrid grid(mesh, kBits);
  std::vector<std::uint16_t> vertices(4 * mesh.vertexCount());
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    for (std::size_t c = 0; c < 3; ++c) {
      vertices[4 * v + c] = static_cast<std::uint16_t>(grid.cell(mesh.positions[3 * v + c], c));
    }
  }
  std::vector<std::uint32_t> indices(mesh.indices.size());
  meshopt_optimizeVertexCache(indices.data(), mesh.indices.data(), indices.size(), mesh.vertexCount());
  std::vector<std::uint16_t> ordered(vertices.size());
  const std::size_t used = meshopt_optimizeVertexFetch(ordered.data(), indices.data(), indices.size(), vertices.data(),
                                                       mesh.vertexCount(), kVertexBytes);
  stream.vertex_count = used;

  meshopt_encodeVertexVersion(0);  // the only one that version 0.18 of the library has
  meshopt_encodeIndexVersion(1);
  stream.vertices.resize(meshopt_encodeVertexBufferBound(used, kVertexBytes));
  stream.vertices.resize(
      meshopt_encodeVertexBuffer(stream.vertices.data(), stream.vertices.size(), ordered.data(), used, kVertexBytes));
  stream.indices.resize(meshopt_encodeIndexBufferBound(indices.size(), used));
  stream.indices.resize(
      meshopt_encodeIndexBuffer(stream.indices.data(), stream.indices.size(), indices.data(), indices.size()));
  return stream;
}

void MeshoptCodec::decode(const Stream& stream) {
  std::vector<std::uint16_t> vertices(4 * stream.vertex_count);
  std::vector<std::uint32_t> indices(stream.index_count);
  if (meshopt_decodeVertexBuffer(vertices.data(), stream.vertex_count, 8, stream.vertices.data(),
                                 stream.vertices.size()) != 0 ||
      meshopt_decodeIndexBuffer(indices.data(), stream.index_count, sizeof(std::uint32_t), stream.indices.data(),
                                stream.indices.size()) != 0) {
    throw std::runtime_error("meshoptimizer refused its own stream");
  }
}

}  // namespace tsc::bench
