// Meshes from PLY files, ascii and binary of both byte orders. Reads x, y, z of "vertex" and the index list of "face";
// all else is stepped over. Counts in the header are never trusted: memory grows with what is really there.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "file_bytes.h"

namespace tsc {
namespace {

enum class Scalar : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat32;
  std::optional<Scalar> count_type;  ///< of lists
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
  std::size_t byte_length = 0;
};

QualityError invalid(const std::string& what) { return {QualityErrorCode::kInvalidFile, what}; }

std::optional<Scalar> scalarNamed(std::string_view name) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"},
                                                                      {"uchar", "uint8"},
                                                                      {"short", "int16"},
                                                                      {"ushort", "uint16"},
                                                                      {"int", "int32"},
                                                                      {"uint", "uint32"},
                                                                      {"float", "float32"},
                                                                      {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i][0] || name == kNames[i][1]) return static_cast<Scalar>(i);
  }
  return std::nullopt;
}

std::optional<Property> parseProperty(TextScanner& words) {
  Property property;
  std::string_view type = words.word();
  if (type == "list") {
    property.count_type = scalarNamed(words.word());
    if (!property.count_type) return std::nullopt;
    type = words.word();
  }
  const auto scalar = scalarNamed(type);
  if (!scalar) return std::nullopt;
  property.type = *scalar;
  property.name = words.word();
  return property;
}

Measured<Header> parseHeader(std::string_view bytes) {
  Header header;
  TextScanner scanner(bytes);
  if (scanner.line() != std::string_view("ply")) return invalid("not a PLY file: it does not begin with \"ply\"");
  while (const auto line = scanner.line()) {
    TextScanner words(*line);
    const std::string_view keyword = words.word();
    if (keyword == "format") {
      const std::string_view format = words.word();
      if (format == "ascii") header.encoding = Encoding::kAscii;
      else if (format == "binary_little_endian") header.encoding = Encoding::kLittleEndian;
      else if (format == "binary_big_endian") header.encoding = Encoding::kBigEndian;
      else return invalid("unknown PLY format \"" + std::string(format) + "\"");
    } else if (keyword == "element") {
      Element element{std::string(words.word()), 0, {}};
      const auto count = parseNumber<std::uint64_t>(words.word());
      if (!count) return invalid("PLY element \"" + element.name + "\" has no count");
      element.count = *count;
      header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
      auto property = parseProperty(words);
      if (!property || header.elements.empty()) return invalid("bad PLY property \"" + std::string(*line) + "\"");
      header.elements.back().properties.push_back(*std::move(property));
    } else if (keyword == "end_header") {
      header.byte_length = scanner.position();
      return header;
    }
  }
  return invalid("the PLY header has no end");
}

/// Values of the body in either encoding; nothing when the data ends or is no number.
class ValueReader {
 public:
  ValueReader(std::string_view bytes, Encoding encoding) : bytes_(bytes), scanner_(bytes), encoding_(encoding) {}

  std::optional<double> read(Scalar type) {
    if (encoding_ == Encoding::kAscii) return parseNumber<double>(scanner_.word());
    switch (type) {
      case Scalar::kInt8: return binary<std::int8_t>();
      case Scalar::kUint8: return binary<std::uint8_t>();
      case Scalar::kInt16: return binary<std::int16_t>();
      case Scalar::kUint16: return binary<std::uint16_t>();
      case Scalar::kInt32: return binary<std::int32_t>();
      case Scalar::kUint32: return binary<std::uint32_t>();
      case Scalar::kFloat32: return binary<float>();
      case Scalar::kFloat64: return binary<double>();
    }
    return std::nullopt;
  }

 private:
  template <class T>
  std::optional<double> binary() {
    if (bytes_.size() - at_ < sizeof(T)) return std::nullopt;
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    const bool file_is_little = encoding_ == Encoding::kLittleEndian;
    if (file_is_little != (std::endian::native == std::endian::little)) std::reverse(raw.begin(), raw.end());
    return static_cast<double>(std::bit_cast<T>(raw));
  }

  std::string_view bytes_;
  TextScanner scanner_;
  Encoding encoding_;
  std::size_t at_ = 0;
};

/// Reads one property of one row into `values`.
bool readProperty(ValueReader& reader, const Property& property, std::vector<double>& values) {
  values.clear();
  double count = 1;
  if (property.count_type) {
    const auto stated = reader.read(*property.count_type);
    if (!stated || !(*stated >= 0)) return false;
    count = *stated;
  }
  for (double i = 0; i < count; ++i) {
    const auto value = reader.read(property.type);
    if (!value) return false;
    values.push_back(*value);
  }
  return true;
}

bool addFace(const std::vector<double>& corners, NamedSurface& mesh) {
  std::vector<std::uint32_t> polygon;
  for (const double corner : corners) {
    if (!(corner >= 0) || corner > 0xfffffffe || corner != std::floor(corner)) return false;
    polygon.push_back(static_cast<std::uint32_t>(corner));
  }
  addFan(polygon, mesh.indices);
  return true;
}

std::optional<QualityError> readElement(ValueReader& reader, const Element& element, NamedSurface& mesh) {
  if (element.properties.empty()) return std::nullopt;
  const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
  std::vector<double> values;
  for (std::uint64_t row = 0; row < element.count; ++row) {
    std::array<double, 3> position{};
    for (const Property& property : element.properties) {
      const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
      if (!readProperty(reader, property, values)) {
        return invalid("the data ends or is no number in " + element.name + " " + std::to_string(row) + " of " +
                       std::to_string(element.count));
      }
      if (is_vertex && property.name.size() == 1 && !property.count_type) {
        const std::size_t axis = std::string_view("xyz").find(property.name[0]);
        if (axis < 3) position[axis] = values[0];
      } else if (is_face && is_corners && !addFace(values, mesh)) {
        return invalid("face " + std::to_string(row) + " has a corner that is no index");
      }
    }
    if (is_vertex) mesh.positions.insert(mesh.positions.end(), position.begin(), position.end());
  }
  return std::nullopt;
}

bool hasPositions(const Header& header) {
  for (const Element& element : header.elements) {
    if (element.name != "vertex") continue;
    int found = 0;
    for (const Property& property : element.properties) {
      found += !property.count_type && (property.name == "x" || property.name == "y" || property.name == "z");
    }
    return found == 3;
  }
  return false;
}

}  // namespace

Measured<NamedSurface> parsePly(std::string_view bytes) {
  const Measured<Header> header = parseHeader(bytes);
  if (!header) return header.error();
  if (!hasPositions(*header)) return invalid("the PLY file has no vertices with x, y and z");
  NamedSurface mesh;
  ValueReader reader(bytes.substr(header->byte_length), header->encoding);
  for (const Element& element : header->elements) {
    if (auto error = readElement(reader, element, mesh)) return *std::move(error);
  }
  const std::size_t count = mesh.positions.size() / 3;
  for (const std::uint32_t index : mesh.indices) {
    if (index >= count) return invalid("index " + std::to_string(index) + " of " + std::to_string(count) + " vertices");
  }
  return mesh;
}

}  // namespace tsc
