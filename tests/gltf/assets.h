// Small assets made in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tsc/gltf.h"

namespace tsc::test {

/// Builds an asset with one buffer, accessor by accessor.
class AssetBuilder {
 public:
  AssetBuilder();

  /// Appends bytes to the buffer and gives their view.
  std::size_t addViewBytes(const void* data, std::size_t bytes, const Json& properties = Json::object());
  template <class T>
  std::size_t addView(const std::vector<T>& data, const Json& properties = Json::object()) {
    return addViewBytes(data.data(), data.size() * sizeof(T), properties);
  }

  std::size_t addAccessorOf(std::size_t view, std::uint32_t component_type, const std::string& type, std::size_t count,
                            const Json& more = Json::object());
  /// An accessor over a new view of its own.
  template <class T>
  std::size_t addAccessor(const std::vector<T>& data, std::uint32_t component_type, const std::string& type,
                          std::size_t count) {
    return addAccessorOf(addView(data), component_type, type, count);
  }
  /// POSITION with bounds.
  std::size_t addPositions(const std::vector<float>& xyz);
  std::size_t addIndices16(const std::vector<std::uint32_t>& indices);

  std::size_t addMesh(const Json& primitives);

  Json& document() { return asset_.document; }
  /// The asset as if read from a GLB file.
  Asset build();

 private:
  Asset asset_;
};

/// A bumpy grid of (n + 1)^2 vertices: positions and triangle indices.
std::vector<float> gridPositions(std::size_t n, float offset = 0);
std::vector<std::uint32_t> gridIndices(std::size_t n);

/// A grid with normals and texture coordinates, indexed with 16 bits.
Asset gridAsset(std::size_t n = 8);

/// Packs, unpacks and expects the same to be shown, watertight, within the reported bound. Gives the report.
PackReport expectRoundTrip(Asset asset, const PackOptions& options = {});

}  // namespace tsc::test
