// Meshes from OBJ and STL files, and the choice of reader by extension. Only positions and faces are read.
#include <algorithm>
#include <cctype>
#include <cstring>

#include "file_bytes.h"
#include "surface_tools.h"

namespace tsc {
namespace {

QualityError invalid(const std::string& what) { return {QualityErrorCode::kInvalidFile, what}; }

QualityError invalidLine(std::size_t line, const std::string& what) {
  return invalid("line " + std::to_string(line) + ": " + what);
}

/// `corner` is v, v/t, v//n or v/t/n; v counts from 1, or back from the last vertex if negative.
std::optional<std::uint32_t> parseObjCorner(std::string_view corner, std::size_t vertex_count) {
  const auto value = parseNumber<std::int64_t>(corner.substr(0, corner.find('/')));
  if (!value) return std::nullopt;
  const std::int64_t count = static_cast<std::int64_t>(vertex_count);
  const std::int64_t index = *value < 0 ? count + *value : *value - 1;
  if (index < 0 || index >= count) return std::nullopt;
  return static_cast<std::uint32_t>(index);
}

Measured<NamedSurface> parseObj(std::string_view bytes) {
  NamedSurface mesh;
  TextScanner scanner(bytes);
  std::vector<std::uint32_t> polygon;
  std::size_t number = 0;
  while (const auto line = scanner.line()) {
    ++number;
    TextScanner words(*line);
    const std::string_view kind = words.word();
    if (kind == "v") {
      for (int k = 0; k < 3; ++k) {
        const auto value = parseNumber<double>(words.word());
        if (!value) return invalidLine(number, "a vertex needs three numbers");
        mesh.positions.push_back(*value);
      }
    } else if (kind == "f") {
      polygon.clear();
      for (std::string_view corner = words.word(); !corner.empty(); corner = words.word()) {
        const auto index = parseObjCorner(corner, mesh.positions.size() / 3);
        if (!index) return invalidLine(number, std::string(corner) + " names no vertex read so far");
        polygon.push_back(*index);
      }
      if (polygon.size() < 3) return invalidLine(number, "a face needs three corners");
      addFan(polygon, mesh.indices);
    }
  }
  return mesh;
}

/// A vertex a corner, welded by bit-equal position.
NamedSurface weldSoup(const std::vector<double>& corners) {
  const PositionView positions(corners);
  const Welding welding = weldPositions(positions);
  NamedSurface mesh;
  mesh.indices = welding.point_of_vertex;
  for (const std::uint32_t v : welding.vertex_of_point) {
    const auto position = positions[v];
    mesh.positions.insert(mesh.positions.end(), position.begin(), position.end());
  }
  return mesh;
}

constexpr std::size_t kStlHeaderBytes = 84, kStlTriangleBytes = 50;

Measured<NamedSurface> parseStl(std::string_view bytes) {
  std::vector<double> corners;
  std::uint32_t count = 0;
  if (bytes.size() >= kStlHeaderBytes) std::memcpy(&count, bytes.data() + 80, 4);
  // Binary files may begin with "solid" too, but only they have exactly this size.
  if (bytes.size() >= kStlHeaderBytes && bytes.size() == kStlHeaderBytes + kStlTriangleBytes * std::size_t{count}) {
    for (std::size_t t = 0; t < count; ++t) {
      float values[9];
      std::memcpy(values, bytes.data() + kStlHeaderBytes + kStlTriangleBytes * t + 12, sizeof values);
      corners.insert(corners.end(), values, values + 9);
    }
    return weldSoup(corners);
  }
  TextScanner scanner(bytes);
  if (scanner.word() != "solid") return invalid("neither a binary STL file of the size it states nor an ascii one");
  for (std::string_view word = scanner.word(); !word.empty(); word = scanner.word()) {
    if (word != "vertex") continue;
    for (int k = 0; k < 3; ++k) {
      // Through float, as binary files are, so that both kinds weld alike.
      const auto value = parseNumber<double>(scanner.word());
      if (!value) return invalid("byte " + std::to_string(scanner.position()) + ": a vertex needs three numbers");
      corners.push_back(static_cast<float>(*value));
    }
  }
  if (corners.size() % 9 != 0) return invalid("the last triangle is not complete");
  return weldSoup(corners);
}

}  // namespace

Measured<NamedSurface> readSurfaceFile(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto parse = extension == ".ply"   ? parsePly
                     : extension == ".obj" ? parseObj
                     : extension == ".stl" ? parseStl
                                           : nullptr;
  if (parse == nullptr) {
    return QualityError{QualityErrorCode::kUnsupportedFile,
                        path.string() + ": not a format known here (.ply, .obj, .stl)"};
  }
  const Measured<std::string> bytes = readFileBytes(path);
  if (!bytes) return bytes.error();
  Measured<NamedSurface> mesh = parse(*bytes);
  if (!mesh) return QualityError{mesh.error().code, path.string() + ": " + mesh.error().message};
  mesh->name = path.stem().string();
  return mesh;
}

}  // namespace tsc
