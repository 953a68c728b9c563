// The test vectors of the format: small streams, their inputs and what stands in them.
//
// Inputs are made with integer arithmetic alone, so that they are the same on every machine.
#pragma once

#include <functional>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "checksum.h"
#include "codec_checks.h"

namespace tsc::test {

using Json = nlohmann::ordered_json;
using Bytes = std::vector<std::byte>;

struct Vector {
  std::string name;
  std::string purpose;
  OwnedMesh mesh;
  EncodeOptions options;
};

/// A sheet of columns x rows quads with a bump of eighths.
inline meshes::Triangles bumpySheet(std::uint32_t columns, std::uint32_t rows, std::int32_t x_sign = 1) {
  meshes::Triangles mesh = meshes::grid(columns, rows, [](float, float) { return 0.0f; });
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    const auto x = static_cast<std::int32_t>(mesh.positions[i]), y = static_cast<std::int32_t>(mesh.positions[i + 1]);
    mesh.positions[i] = static_cast<float>(x_sign * (16 * x + (x == 0 ? 0 : (y * 7 + x * 3) % 5))) / 16;
    mesh.positions[i + 1] = static_cast<float>(16 * y + (y * 3 + x * 5) % 7) / 16;
    mesh.positions[i + 2] = static_cast<float>((x * (4 - x) + y * (5 - y)) * 4 + (x * 11 + y * 13) % 3) / 32;
  }
  return mesh;
}

inline std::vector<Vector> allVectors() {
  std::vector<Vector> all;
  const auto add = [&](const char* name, const char* purpose, OwnedMesh mesh, double step) -> Vector& {
    Vector& vector = all.emplace_back();
    vector.name = name;
    vector.purpose = purpose;
    vector.mesh = std::move(mesh);
    vector.options.step = step;
    vector.options.mode = Mode::kLattice;
    vector.options.predictor = Predictor::kAverage;
    return vector;
  };
  add("triangle", "One triangle: a component's start, a hole of three edges, free positions", OwnedMesh(meshes::triangle()),
      0.0625);
  add("tetrahedron", "A closed surface in lattice mode with the parallelogram", OwnedMesh(meshes::tetrahedron()), 0.0625)
      .options.predictor = Predictor::kParallelogram;

  Vector& adaptive = add("sheet-gate-adaptive", "An open sheet in tangent mode: gate-aligned basis, adaptive predictor",
                         OwnedMesh(bumpySheet(4, 5)), 1.0 / 128);
  adaptive.options.mode = Mode::kTangent;
  adaptive.options.basis = Basis::kGate;
  adaptive.options.predictor = Predictor::kAdaptive;

  Vector& paper = add("sheet-paper", "The paper's codec: tangent mode, weighted parallelogram, tip-aligned basis, a finer "
                      "normal step", OwnedMesh(bumpySheet(4, 5)), 1.0 / 64);
  paper.options.mode = Mode::kTangent;
  paper.options.basis = Basis::kTip;
  paper.options.predictor = Predictor::kWeighted;
  paper.options.order = Order::kTraversal;
  paper.options.normal_scale = 2;

  OwnedMesh flat(meshes::grid(6, 5, [](float x, float) { return 4 * x; }));
  add("hits", "A plane whose lattice it meets: residuals signalled as a candidate's", flat, 1.0 / 1024);

  OwnedMesh seam(bumpySheet(3, 3));
  const meshes::Triangles beside = bumpySheet(3, 3, -1);
  seam.primitives[0].index_type = ComponentType::kUint8;
  // The second primitive has corner vertices of its own, in a second table; one row of the first is split in its table.
  seam.tables.push_back(beside.positions);
  seam.primitives.push_back({1, {}, ComponentType::kUint16});
  for (std::size_t i = 0; i < beside.indices.size(); i += 3) {
    seam.primitives[1].indices.insert(seam.primitives[1].indices.end(),
                                      {beside.indices[i], beside.indices[i + 2], beside.indices[i + 1]});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t old = seam.primitives[0].indices[i];
    for (std::uint32_t a = 0; a < 3; ++a) seam.tables[0].push_back(seam.tables[0][3 * old + a]);
    seam.primitives[0].indices[i] = static_cast<std::uint32_t>(seam.tables[0].size() / 3 - 1);
  }
  add("seams", "Two primitives over two tables that share positions, with a seam inside the first", seam, 1.0 / 32);

  meshes::Triangles book;
  for (const int x : {0, 1}) book.addVertex(0, 0, static_cast<float>(x));
  for (const auto& [x, y] : {std::pair{4, 1}, {-3, 2}, {1, -5}}) {
    const std::uint32_t first = book.addVertex(static_cast<float>(x), static_cast<float>(y), 1);
    book.addVertex(static_cast<float>(x), static_cast<float>(y), 0);
    book.addFace(0, 1, first);
    book.addFace(0, first, first + 1);
  }
  add("non-manifold", "Three quads on one edge: a cut, and references to positions already known", OwnedMesh(book), 0.125);

  meshes::Triangles leftover = meshes::tetrahedron();
  leftover.addVertex(3, 3, 3);
  leftover.addVertex(5, 5, 5);
  leftover.addFace(0, 2, 1);  // a duplicate
  leftover.addFace(1, 0, 2);  // the same, turned
  leftover.addFace(3, 3, 1);  // degenerate
  leftover.addFace(4, 4, 4);  // degenerate, at a position of its own
  add("side-faces", "Duplicate and degenerate faces, an unused vertex", OwnedMesh(leftover), 0.25);

  OwnedMesh integers(bumpySheet(3, 4));
  integers.position_type = ComponentType::kInt16;
  for (float& x : integers.tables[0]) x = static_cast<float>(static_cast<std::int32_t>(x * 64) * 100 - 20000);
  integers.primitives[0].index_type = ComponentType::kUint16;
  add("int16", "Positions of 16-bit integers, without loss", integers, 0);

  Vector& anchored = add("anchored-degree", "A lattice at multiples of the step; positions coded in the order of most "
                         "parallelograms", OwnedMesh(bumpySheet(4, 4)), 1.0 / 48);
  anchored.options.anchored = true;
  anchored.options.order = Order::kDegree;
  for (std::size_t i = 0; i < anchored.mesh.tables[0].size(); i += 3) anchored.mesh.tables[0][i] -= 100;

  Vector& least = add("max-lattice", "Effort max in lattice mode, from the average", OwnedMesh(bumpySheet(9, 8)), 1.0 / 64);
  least.options.order = Order::kTraversal;
  least.options.effort = Effort::kMax;
  Vector& most = add("max-tangent", "Effort max in tangent mode; enough vertices that least squares slow down",
                     OwnedMesh(bumpySheet(20, 16)), 1.0 / 64);
  most.options.mode = Mode::kTangent;
  most.options.order = Order::kTraversal;
  most.options.predictor = Predictor::kAdaptive;
  most.options.effort = Effort::kMax;
  const meshes::Triangles uneven = meshes::shuffledDegrees(meshes::torus(12, 9), 200, 3);
  Vector& tips = add("max-tips", "Effort max on a torus of uneven degrees with holes: all kinds of decisions on tips",
                     OwnedMesh(meshes::perforated(uneven, 0.1, 4)), 1.0 / 16);
  tips.options.order = Order::kTraversal;
  tips.options.effort = Effort::kMax;
  return all;
}

/// Reads a header byte by byte as BITSTREAM.md, section 2, tells it; knows nothing of the codec's own reader.
class HeaderWalk {
 public:
  explicit HeaderWalk(std::span<const std::byte> bytes) : bytes_(bytes) { walk(); }
  const Json& fields() const { return fields_; }
  std::size_t size() const { return position_; }

 private:
  std::uint8_t byte() { return static_cast<std::uint8_t>(bytes_[position_++]); }

  void field(const char* name, std::size_t offset, Json value) {
    fields_.push_back({{"field", name}, {"offset", offset}, {"bytes", position_ - offset}, {"value", std::move(value)}});
  }
  unsigned bits(const char* name, std::size_t offset, unsigned flags, int shift, int width,
                std::initializer_list<const char*> meanings) {
    const unsigned value = flags >> shift & ((1u << width) - 1);
    Json entry = {{"field", name}, {"offset", offset}, {"bit", shift}, {"bits", width}, {"value", value}};
    if (meanings.size() > 0) entry["meaning"] = meanings.begin()[value];
    fields_.push_back(std::move(entry));
    return value;
  }
  std::uint64_t varint(const char* name) {
    const std::size_t offset = position_;
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const std::uint8_t part = byte();
      value |= std::uint64_t{part & 0x7fu} << shift;
      if (part < 0x80) break;
    }
    field(name, offset, value);
    return value;
  }
  std::int64_t signedVarint(const char* name) {
    const std::uint64_t coded = varint(name);
    const std::int64_t value = coded % 2 == 0 ? static_cast<std::int64_t>(coded / 2) : -static_cast<std::int64_t>(coded / 2) - 1;
    fields_.back()["value"] = value;
    return value;
  }
  void float32(const char* name) {
    const std::size_t offset = position_;
    const auto value = loadAt<float>(bytes_, position_);
    position_ += 4;
    field(name, offset, value);
  }

  void walk() {
    byte();
    field("version", 0, static_cast<unsigned>(bytes_[0]));
    const unsigned first = byte();
    const unsigned mode = bits("mode", 1, first, 0, 1, {"lattice", "tangent"});
    bits("basis", 1, first, 1, 1, {"gate", "tip"});
    bits("predictor", 1, first, 2, 3, {"parallelogram", "weighted", "valence", "average", "adaptive", "", "", ""});
    bits("order", 1, first, 5, 1, {"traversal", "degree"});
    bits("exact hits", 1, first, 6, 1, {});
    bits("effort", 1, first, 7, 1, {"default", "max"});
    const unsigned second = byte();
    const unsigned type = bits("position type", 2, second, 0, 3,
                               {"int8", "uint8", "int16", "uint16", "", "float32", "", ""});
    const unsigned anchored = bits("anchored", 2, second, 3, 1, {});
    bits("has references", 2, second, 4, 1, {});
    bits("one vertex per position", 2, second, 5, 1, {});
    bits("candidates", 2, second, 6, 1, {});
    const unsigned has_dummies = bits("has dummies", 2, second, 7, 1, {});
    if (mode == 1) {
      byte();
      field("normal scale - 1", 3, static_cast<unsigned>(bytes_[3]));
    }
    if (type == 5) float32("step");
    for (const char* axis : {"x", "y", "z"}) {
      if (anchored) {
        signedVarint((std::string("anchor ") + axis).c_str());
      } else {
        float32((std::string("origin ") + axis).c_str());
      }
    }
    const std::uint64_t tables = varint("table count");
    const std::uint64_t primitives = varint("primitive count");
    for (std::uint64_t t = 0; t < tables; ++t) varint("vertex count of a table");
    for (std::uint64_t p = 0; p < primitives; ++p) {
      varint("4 * table + log2(index bytes)");
      varint("triangle count of a primitive");
    }
    signedVarint("real surface vertices - table vertices");
    if (has_dummies) varint("dummies");
    signedVarint("surface vertices - surface faces / 2");
  }

  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
  Json fields_ = Json::array();
};

inline std::string hexOf(std::uint64_t value, int digits) {
  std::ostringstream text;
  text << std::hex << std::setfill('0') << std::setw(digits) << value;
  return text.str();
}

/// Everything that stands in the stream, as the vector's JSON file has it. Throws std::runtime_error on a stream that
/// does not decode.
inline Json describeStream(const Vector& vector, const Bytes& stream) {
  const auto info = readStreamInfo(stream);
  const auto outputs = decode(stream);
  if (!info || !outputs) throw std::runtime_error(vector.name + ": " + describe(info ? outputs.error() : info.error()));
  const HeaderWalk header(stream);
  Json json = {{"name", vector.name}, {"purpose", vector.purpose}, {"bytes", stream.size()},
               {"header bytes", header.size()}, {"header", header.fields()}};
  const DecodedMesh decoded = toNumbers(info->outputs, *outputs);
  Json arrays = Json::array();
  std::uint64_t chained = xxh64(std::span(stream).first(header.size()), 0);
  for (std::size_t o = 0; o < outputs->size(); ++o) {
    static constexpr const char* kTypes[] = {"int8", "uint8", "int16", "uint16", "uint32", "float32"};
    const OutputInfo& output = info->outputs[o];
    const bool is_table = output.kind == OutputInfo::Kind::kPositions;
    chained = xxh64((*outputs)[o], chained);
    Json entry = {{"output", o},
                  {"kind", is_table ? "positions" : "indices"},
                  {"type", kTypes[static_cast<int>(output.type)]},
                  {"table", output.table},
                  {"count", output.count},
                  {"byte stride", output.byte_stride},
                  {"byte length", output.byte_length},
                  {"xxh64", hexOf(xxh64((*outputs)[o], 0), 16)}};
    if (is_table) {
      entry["data"] = decoded.tables[output.table];
    } else {
      entry["data"] = decoded.primitives[o - decoded.tables.size()];
    }
    arrays.push_back(std::move(entry));
  }
  json["outputs"] = std::move(arrays);
  json["checksum"] = hexOf(chained & 0xffffffffu, 8);
  return json;
}

/// One line a field and a row of three numbers, so that a person can read it and differences show.
inline std::string textOf(const Json& json) {
  std::string text = "{\n";
  std::size_t left = json.size();
  for (const auto& [key, value] : json.items()) {
    text += "  " + Json(key).dump() + ": ";
    if (key == "header" || key == "outputs") {
      text += "[";
      for (std::size_t i = 0; i < value.size(); ++i) {
        text += i == 0 ? "\n    " : ",\n    ";
        text += value[i].dump();
      }
      text += "\n  ]";
    } else {
      text += value.dump();
    }
    text += --left > 0 ? ",\n" : "\n";
  }
  return text + "}\n";
}

}  // namespace tsc::test
