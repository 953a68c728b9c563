// A glTF 2.0 asset under construction: arrays go in, accessor numbers come out, the JSON is edited by the caller.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace tsc::samples {

using Json = nlohmann::ordered_json;

/// What a buffer view is for; the values are glTF's `target`, 0 for none.
enum class Target { kNone = 0, kVertices = 34962, kIndices = 34963 };

/// One array of a buffer view that interleaves several: `components` floats a vertex.
struct FloatColumn {
  std::span<const float> values;
  int components;
  bool bounds = false;  ///< write `min` and `max`, which POSITION needs
};

class Asset {
 public:
  explicit Asset(const std::string& title);

  Json json;

  /// Adds an accessor in a buffer view of its own; `type` is "SCALAR", "VEC2", …. Returns the accessor's index.
  int addFloats(std::span<const float> values, const char* type, Target target, bool bounds = false);
  int addBytes4(std::span<const std::uint8_t> values);  ///< VEC4 of unsigned bytes, for JOINTS_0
  int addIndices(std::span<const std::uint32_t> indices, int component_bytes);  ///< 1, 2 or 4 bytes an index
  std::vector<int> addInterleaved(std::span<const FloatColumn> columns);  ///< one buffer view, one accessor a column
  /// A VEC3 accessor of `count` zeros except at `indices` (ascending); 3 floats in `values` for each of them.
  int addSparseVec3(std::size_t count, std::span<const std::uint16_t> indices, std::span<const float> values,
                    bool bounds);
  int addImage(std::span<const std::byte> png);  ///< an image in a buffer view

  /// Writes `path`: a .glb with everything inside, or a .gltf beside a .bin of the same name.
  void write(const std::filesystem::path& path);

 private:
  int addView(std::span<const std::byte> bytes, Target target, std::size_t stride = 0);
  int addAccessor(int view, std::size_t offset, int component_type, std::size_t count, const char* type);
  void setBounds(int accessor, std::span<const float> values, int components);

  std::vector<std::byte> buffer_;
};

}  // namespace tsc::samples
