#include "asset.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace tsc::samples {
namespace {

constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;

int componentCount(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "MAT4") return 16;
  return type.back() - '0';  // VEC2, VEC3, VEC4
}

void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

void appendUint32(std::vector<std::byte>& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::byte>(value >> shift));
}

void appendChunk(std::vector<std::byte>& file, std::uint32_t type, std::span<const std::byte> content, char padding) {
  const std::size_t padded = (content.size() + 3) / 4 * 4;
  appendUint32(file, static_cast<std::uint32_t>(padded));
  appendUint32(file, type);
  file.insert(file.end(), content.begin(), content.end());
  file.resize(file.size() + padded - content.size(), static_cast<std::byte>(padding));
}

}  // namespace

Asset::Asset(const std::string& title) {
  json["asset"] = {{"version", "2.0"}, {"generator", "gltf-tsc make-samples"}, {"extras", {{"title", title}}}};
  json["scene"] = 0;
}

int Asset::addView(std::span<const std::byte> bytes, Target target, std::size_t stride) {
  buffer_.resize((buffer_.size() + 3) / 4 * 4);
  Json view = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
  if (stride != 0) view["byteStride"] = stride;
  if (target != Target::kNone) view["target"] = static_cast<int>(target);
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  json["bufferViews"].push_back(std::move(view));
  return static_cast<int>(json["bufferViews"].size()) - 1;
}

int Asset::addAccessor(int view, std::size_t offset, int component_type, std::size_t count, const char* type) {
  Json accessor = {{"bufferView", view}};
  if (offset != 0) accessor["byteOffset"] = offset;
  accessor["componentType"] = component_type;
  accessor["count"] = count;
  accessor["type"] = type;
  json["accessors"].push_back(std::move(accessor));
  return static_cast<int>(json["accessors"].size()) - 1;
}

void Asset::setBounds(int accessor, std::span<const float> values, int components) {
  Json low = Json::array(), high = Json::array();
  for (int component = 0; component < components; ++component) {
    float smallest = values[component], largest = values[component];
    for (std::size_t i = component; i < values.size(); i += components) {
      smallest = std::min(smallest, values[i]);
      largest = std::max(largest, values[i]);
    }
    low.push_back(smallest);
    high.push_back(largest);
  }
  json["accessors"][accessor]["min"] = low;
  json["accessors"][accessor]["max"] = high;
}

int Asset::addFloats(std::span<const float> values, const char* type, Target target, bool bounds) {
  const int components = componentCount(type);
  const int accessor = addAccessor(addView(std::as_bytes(values), target), 0, kFloat, values.size() / components, type);
  if (bounds) setBounds(accessor, values, components);
  return accessor;
}

int Asset::addBytes4(std::span<const std::uint8_t> values) {
  return addAccessor(addView(std::as_bytes(values), Target::kVertices), 0, kUnsignedByte, values.size() / 4, "VEC4");
}

int Asset::addIndices(std::span<const std::uint32_t> indices, int component_bytes) {
  std::vector<std::byte> bytes;
  for (const std::uint32_t index : indices) {
    for (int i = 0; i < component_bytes; ++i) bytes.push_back(static_cast<std::byte>(index >> (8 * i)));
  }
  const int type = component_bytes == 1 ? kUnsignedByte : component_bytes == 2 ? kUnsignedShort : kUnsignedInt;
  return addAccessor(addView(bytes, Target::kIndices), 0, type, indices.size(), "SCALAR");
}

std::vector<int> Asset::addInterleaved(std::span<const FloatColumn> columns) {
  std::size_t stride_floats = 0;
  for (const FloatColumn& column : columns) stride_floats += column.components;
  const std::size_t count = columns[0].values.size() / columns[0].components;
  std::vector<float> rows;
  for (std::size_t vertex = 0; vertex < count; ++vertex) {
    for (const FloatColumn& column : columns) {
      const auto first = column.values.begin() + static_cast<std::ptrdiff_t>(vertex * column.components);
      rows.insert(rows.end(), first, first + column.components);
    }
  }
  const int view = addView(std::as_bytes(std::span(rows)), Target::kVertices, stride_floats * sizeof(float));
  std::vector<int> accessors;
  std::size_t offset = 0;
  for (const FloatColumn& column : columns) {
    const std::string type = "VEC" + std::to_string(column.components);
    accessors.push_back(addAccessor(view, offset, kFloat, count, type.c_str()));
    if (column.bounds) setBounds(accessors.back(), column.values, column.components);
    offset += column.components * sizeof(float);
  }
  return accessors;
}

int Asset::addSparseVec3(std::size_t count, std::span<const std::uint16_t> indices, std::span<const float> values,
                         bool bounds) {
  const int index_view = addView(std::as_bytes(indices), Target::kNone);
  const int value_view = addView(std::as_bytes(values), Target::kNone);
  Json accessor = {{"componentType", kFloat}, {"count", count}, {"type", "VEC3"}};
  accessor["sparse"] = {{"count", indices.size()},
                        {"indices", {{"bufferView", index_view}, {"componentType", kUnsignedShort}}},
                        {"values", {{"bufferView", value_view}}}};
  json["accessors"].push_back(std::move(accessor));
  const int result = static_cast<int>(json["accessors"].size()) - 1;
  if (bounds) {
    std::vector<float> with_zero(values.begin(), values.end());
    with_zero.insert(with_zero.end(), 3, 0.0f);
    setBounds(result, with_zero, 3);
  }
  return result;
}

int Asset::addImage(std::span<const std::byte> png) {
  json["images"].push_back({{"bufferView", addView(png, Target::kNone)}, {"mimeType", "image/png"}});
  return static_cast<int>(json["images"].size()) - 1;
}

void Asset::write(const std::filesystem::path& path) {
  buffer_.resize((buffer_.size() + 3) / 4 * 4);
  const bool binary = path.extension() == ".glb";
  Json buffer = Json::object();
  if (!binary) {
    const std::filesystem::path data = std::filesystem::path(path).replace_extension(".bin");
    writeFile(data, buffer_);
    buffer["uri"] = data.filename().string();
  }
  buffer["byteLength"] = buffer_.size();
  json["buffers"] = Json::array({buffer});
  const std::string text = binary ? json.dump() : json.dump(2) + "\n";
  const auto text_bytes = std::as_bytes(std::span(text));
  if (!binary) return writeFile(path, text_bytes);

  std::vector<std::byte> chunks;
  appendChunk(chunks, 0x4E4F534A, text_bytes, ' ');  // "JSON"
  appendChunk(chunks, 0x004E4942, buffer_, '\0');    // "BIN"
  std::vector<std::byte> file;
  appendUint32(file, 0x46546C67);  // "glTF"
  appendUint32(file, 2);
  appendUint32(file, static_cast<std::uint32_t>(12 + chunks.size()));
  file.insert(file.end(), chunks.begin(), chunks.end());
  writeFile(path, file);
}

}  // namespace tsc::samples
