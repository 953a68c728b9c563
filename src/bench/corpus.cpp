// Meshes to measure on. Reading glTF is left to tinygltf: what is measured here is not our own loader.
#include "corpus.h"

#include <fmt/format.h>
#include <tiny_gltf.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <map>
#include <random>
#include <stdexcept>
#include <unordered_map>

namespace tsc::bench {

namespace fs = std::filesystem;

namespace {

struct PositionBits {
  std::array<std::uint32_t, 3> words;
  bool operator==(const PositionBits&) const = default;
};
struct PositionBitsHash {
  std::size_t operator()(const PositionBits& bits) const { return XXH64(bits.words.data(), sizeof bits.words, 0); }
};

/// Collects triangles over bit-exactly welded positions.
class Welder {
 public:
  explicit Welder(BenchMesh& mesh) : mesh_(mesh) {}

  std::uint32_t add(const float* position) {
    PositionBits key;
    for (int c = 0; c < 3; ++c) {
      const float value = position[c] + 0.0f;  // -0 becomes +0
      if (!std::isfinite(value)) throw std::runtime_error("a position is not finite");
      std::memcpy(&key.words[c], &value, 4);
    }
    const auto [entry, is_new] = index_.try_emplace(key, static_cast<std::uint32_t>(mesh_.vertexCount()));
    if (is_new) {
      for (int c = 0; c < 3; ++c) mesh_.positions.push_back(position[c] + 0.0f);
    }
    return entry->second;
  }

 private:
  BenchMesh& mesh_;
  std::unordered_map<PositionBits, std::uint32_t, PositionBitsHash> index_;
};

const unsigned char* accessorData(const tinygltf::Model& model, const tinygltf::Accessor& accessor,
                                  std::size_t element_bytes, int& stride) {
  if (accessor.sparse.isSparse) throw std::runtime_error("sparse accessors are not read here");
  const auto& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  const auto& buffer = model.buffers.at(static_cast<std::size_t>(view.buffer));
  stride = accessor.ByteStride(view);
  const std::size_t begin = view.byteOffset + accessor.byteOffset;
  const std::size_t last = accessor.count == 0 ? 0 : (accessor.count - 1) * static_cast<std::size_t>(stride);
  if (stride <= 0 || begin + last + element_bytes > buffer.data.size()) {
    throw std::runtime_error("an accessor reaches past its buffer");
  }
  return buffer.data.data() + begin;
}

std::vector<std::uint32_t> readIndices(const tinygltf::Model& model, int accessor_index, std::size_t vertex_count) {
  std::vector<std::uint32_t> indices;
  if (accessor_index < 0) {
    indices.resize(vertex_count - vertex_count % 3);
    for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint32_t>(i);
    return indices;
  }
  const auto& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
  const auto size = static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(accessor.componentType));
  int stride = 0;
  const unsigned char* data = accessorData(model, accessor, size, stride);
  indices.resize(accessor.count - accessor.count % 3);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::uint32_t value = 0;
    std::memcpy(&value, data + i * static_cast<std::size_t>(stride), size);  // little-endian, as glTF is
    if (value >= vertex_count) throw std::runtime_error("an index is past the vertices");
    indices[i] = value;
  }
  return indices;
}

void addPrimitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive, Welder& welder, BenchMesh& mesh) {
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return;
  if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1) return;
  const auto& accessor = model.accessors.at(static_cast<std::size_t>(position->second));
  if (accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT || accessor.type != TINYGLTF_TYPE_VEC3) return;
  int stride = 0;
  const unsigned char* data = accessorData(model, accessor, 12, stride);
  std::vector<std::uint32_t> welded(accessor.count);
  for (std::size_t v = 0; v < accessor.count; ++v) {
    float values[3];
    std::memcpy(values, data + v * static_cast<std::size_t>(stride), sizeof values);
    welded[v] = welder.add(values);
  }
  for (const std::uint32_t index : readIndices(model, primitive.indices, accessor.count)) {
    mesh.indices.push_back(welded[index]);
  }
}

/// Keeps the given faces and the vertices that they use, in the order of first use.
BenchMesh extractFaces(const BenchMesh& mesh, const std::vector<std::uint32_t>& faces) {
  BenchMesh result{.name = mesh.name, .class_name = mesh.class_name, .positions = {}, .indices = {}};
  std::unordered_map<std::uint32_t, std::uint32_t> new_index;
  for (const std::uint32_t face : faces) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t vertex = mesh.indices[3 * face + c];
      const auto [entry, is_new] = new_index.try_emplace(vertex, static_cast<std::uint32_t>(new_index.size()));
      if (is_new) {
        result.positions.insert(result.positions.end(), &mesh.positions[3 * vertex], &mesh.positions[3 * vertex] + 3);
      }
      result.indices.push_back(entry->second);
    }
  }
  return result;
}

bool isGltf(const fs::path& path) { return path.extension() == ".glb" || path.extension() == ".gltf"; }

}  // namespace

std::string BenchMesh::contentKey() const {
  const XXH64_hash_t seed = XXH64(positions.data(), positions.size() * sizeof(float), 0);
  return fmt::format("{:016x}", XXH64(indices.data(), indices.size() * sizeof(std::uint32_t), seed));
}

std::vector<CorpusFile> listFiles(const std::vector<std::string>& arguments) {
  std::vector<CorpusFile> files;
  for (const std::string& argument : arguments) {
    if (!fs::exists(argument)) throw std::runtime_error(argument + ": no such file or folder");
    if (!fs::is_directory(argument)) {
      files.push_back({argument, fs::file_size(argument)});
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(argument)) {
      if (entry.is_regular_file() && isGltf(entry.path())) files.push_back({entry.path(), entry.file_size()});
    }
  }
  if (files.empty()) throw std::runtime_error("no .glb or .gltf files found");
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

std::vector<CorpusFile> spreadSelection(const std::vector<CorpusFile>& files, std::size_t count) {
  std::map<fs::path, std::vector<CorpusFile>> folders;
  for (const auto& file : files) folders[file.path.parent_path()].push_back(file);
  std::vector<CorpusFile> selection;
  std::size_t folder_number = 0;
  for (const auto& [folder, members] : folders) {
    const std::size_t share = count * (folder_number + 1) / folders.size() - count * folder_number / folders.size();
    for (std::size_t i = 0; i < share && i < members.size(); ++i) {
      selection.push_back(members[(2 * i + 1) * members.size() / (2 * std::min(share, members.size()))]);
    }
    ++folder_number;
  }
  return selection;
}

std::vector<CorpusFile> everyNth(const std::vector<CorpusFile>& files, std::size_t n) {
  std::map<fs::path, std::vector<CorpusFile>> folders;
  for (const auto& file : files) folders[file.path.parent_path()].push_back(file);
  std::vector<CorpusFile> selection;
  for (const auto& [folder, members] : folders) {
    for (std::size_t i = std::min(n / 2, members.size() - 1); i < members.size(); i += n) {
      selection.push_back(members[i]);
    }
  }
  return selection;
}

void dropUnusedVertices(BenchMesh& mesh) {
  constexpr std::uint32_t kUnused = 0xffffffff;
  std::vector<std::uint32_t> new_index(mesh.vertexCount(), kUnused);
  for (const std::uint32_t index : mesh.indices) new_index[index] = 0;
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] == kUnused) continue;
    std::copy_n(&mesh.positions[3 * v], 3, &mesh.positions[3 * std::size_t{kept}]);
    new_index[v] = kept++;
  }
  mesh.dropped_vertices += new_index.size() - kept;
  mesh.positions.resize(3 * std::size_t{kept});
  for (std::uint32_t& index : mesh.indices) index = new_index[index];
}

std::vector<BenchMesh> loadMeshes(const fs::path& path) try {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const bool is_binary = path.extension() == ".glb";
  const bool loaded = is_binary ? loader.LoadBinaryFromFile(&model, &error, &warning, path.string())
                                : loader.LoadASCIIFromFile(&model, &error, &warning, path.string());
  if (!loaded) throw std::runtime_error(error.empty() ? "cannot be read as glTF" : error);

  std::vector<BenchMesh> meshes;
  for (const auto& source : model.meshes) {
    BenchMesh mesh;
    mesh.name = path.stem().string();
    if (model.meshes.size() > 1) mesh.name += fmt::format("#{}", &source - model.meshes.data());
    mesh.class_name = fs::absolute(path).parent_path().filename().string();
    Welder welder(mesh);
    for (const auto& primitive : source.primitives) addPrimitive(model, primitive, welder, mesh);
    dropUnusedVertices(mesh);
    if (mesh.faceCount() > 0) meshes.push_back(std::move(mesh));
  }
  if (meshes.empty()) throw std::runtime_error("no triangles with float positions");
  return meshes;
} catch (const std::exception& error) {
  throw std::runtime_error(path.string() + ": " + error.what());
}

BenchMesh cutPatch(const BenchMesh& mesh, std::size_t vertex_count) {
  if (mesh.vertexCount() <= vertex_count) return mesh;
  std::vector<std::vector<std::uint32_t>> vertex_faces(mesh.vertexCount());
  for (std::uint32_t i = 0; i < mesh.indices.size(); ++i) vertex_faces[mesh.indices[i]].push_back(i / 3);

  std::vector<bool> face_taken(mesh.faceCount()), vertex_taken(mesh.vertexCount());
  std::vector<std::uint32_t> faces;
  std::size_t vertices = 0;
  // A component may be smaller than the patch: then the next face in order starts another.
  for (std::size_t k = 0; k < mesh.faceCount() && vertices < vertex_count; ++k) {
    std::deque<std::uint32_t> queue{static_cast<std::uint32_t>((mesh.faceCount() / 2 + k) % mesh.faceCount())};
    while (!queue.empty() && vertices < vertex_count) {
      const std::uint32_t face = queue.front();
      queue.pop_front();
      if (face_taken[face]) continue;
      face_taken[face] = true;
      faces.push_back(face);
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t vertex = mesh.indices[3 * face + c];
        if (vertex_taken[vertex]) continue;
        vertex_taken[vertex] = true;
        ++vertices;
        queue.insert(queue.end(), vertex_faces[vertex].begin(), vertex_faces[vertex].end());
      }
    }
  }
  // Faces whose vertices are all in belong to the patch as well: without them its border would be ragged.
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    const std::uint32_t* corner = &mesh.indices[3 * face];
    if (!face_taken[face] && vertex_taken[corner[0]] && vertex_taken[corner[1]] && vertex_taken[corner[2]]) {
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end());
  BenchMesh patch = extractFaces(mesh, faces);
  patch.name += fmt::format("@{}", vertex_count);
  return patch;
}

BenchMesh subdivide(const BenchMesh& mesh) {
  std::vector<double> normals(mesh.positions.size());
  for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
    const std::uint32_t* corner = &mesh.indices[3 * f];
    const float* p[3] = {&mesh.positions[3 * corner[0]], &mesh.positions[3 * corner[1]],
                         &mesh.positions[3 * corner[2]]};
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      const double component = (double(p[1][d]) - p[0][d]) * (double(p[2][e]) - p[0][e]) -
                               (double(p[1][e]) - p[0][e]) * (double(p[2][d]) - p[0][d]);
      for (int k = 0; k < 3; ++k) normals[3 * corner[k] + static_cast<std::uint32_t>(c)] += component;
    }
  }
  BenchMesh result{.name = mesh.name, .class_name = mesh.class_name, .positions = mesh.positions, .indices = {}};
  std::mt19937 random(1);
  std::unordered_map<std::uint64_t, std::uint32_t> midpoints;
  const auto midpoint = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint64_t key = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [entry, is_new] = midpoints.try_emplace(key, static_cast<std::uint32_t>(result.vertexCount()));
    if (!is_new) return entry->second;
    double edge = 0, length = 0, normal[3];
    for (std::uint32_t c = 0; c < 3; ++c) {
      const double difference = double(mesh.positions[3 * a + c]) - mesh.positions[3 * b + c];
      normal[c] = normals[3 * a + c] + normals[3 * b + c];
      edge += difference * difference;
      length += normal[c] * normal[c];
    }
    const double noise = (random() / 4294967296.0 - 0.5) * 0.04;
    const double shift = length > 0 ? noise * std::sqrt(edge / length) : 0;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const double middle = 0.5 * (double(mesh.positions[3 * a + c]) + mesh.positions[3 * b + c]);
      result.positions.push_back(static_cast<float>(middle + shift * normal[c]));
    }
    return entry->second;
  };
  for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
    const std::uint32_t* v = &mesh.indices[3 * f];
    const std::uint32_t m[3] = {midpoint(v[0], v[1]), midpoint(v[1], v[2]), midpoint(v[2], v[0])};
    for (const std::uint32_t index : {v[0], m[0], m[2], m[0], v[1], m[1], m[2], m[1], v[2], m[0], m[1], m[2]}) {
      result.indices.push_back(index);
    }
  }
  return result;
}

BenchMesh makePlane(std::size_t side, double degrees) {
  BenchMesh plane{.name = fmt::format("plane{}", side), .class_name = "made", .positions = {}, .indices = {}};
  std::mt19937 random(1);
  const double angle = degrees * 3.14159265358979323846 / 180;
  const auto jitter = [&] { return (random() / 4294967296.0 - 0.5) * 0.5; };
  for (std::size_t j = 0; j < side; ++j) {
    for (std::size_t i = 0; i < side; ++i) {
      const double x = double(i) + jitter(), y = double(j) + jitter();
      for (const double value : {x, y * std::cos(angle), y * std::sin(angle)}) {
        plane.positions.push_back(static_cast<float>(value / double(side)));
      }
    }
  }
  const auto at = [side](std::size_t i, std::size_t j) { return static_cast<std::uint32_t>(j * side + i); };
  for (std::size_t j = 0; j + 1 < side; ++j) {
    for (std::size_t i = 0; i + 1 < side; ++i) {
      for (const auto v : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)}) {
        plane.indices.push_back(v);
      }
    }
  }
  return plane;
}

}  // namespace tsc::bench
