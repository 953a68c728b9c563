// See draco_decode.h.
#include "draco_decode.h"

#include <draco/compression/decode.h>

#include <cstring>
#include <memory>

namespace tsc {
namespace {

template <class T>
bool convertAttribute(const draco::PointAttribute& source, std::uint32_t points, DracoAttribute& out) {
  T values[4];
  const std::size_t bytes = out.components * sizeof(T);
  out.values.resize(points * bytes);
  for (std::uint32_t i = 0; i < points; ++i) {
    const draco::AttributeValueIndex value = source.mapped_index(draco::PointIndex(i));
    if (!source.ConvertValue<T>(value, static_cast<std::int8_t>(out.components), values)) return false;
    std::memcpy(out.values.data() + i * bytes, values, bytes);
  }
  return true;
}

bool readAttribute(const draco::PointAttribute& source, std::uint32_t points, DracoAttribute& out) {
  if (out.components < 1 || out.components > 4) return false;
  if (static_cast<std::size_t>(source.num_components()) != out.components) return false;
  switch (out.component_type) {
    case 5120:
      return convertAttribute<std::int8_t>(source, points, out);
    case 5121:
      return convertAttribute<std::uint8_t>(source, points, out);
    case 5122:
      return convertAttribute<std::int16_t>(source, points, out);
    case 5123:
      return convertAttribute<std::uint16_t>(source, points, out);
    case 5125:
      return convertAttribute<std::uint32_t>(source, points, out);
    case 5126:
      return convertAttribute<float>(source, points, out);
    default:
      return false;
  }
}

}  // namespace
}  // namespace tsc

extern "C" bool tsc_decode_draco(const char* bytes, std::size_t size, tsc::DracoMesh& mesh,
                                 std::vector<tsc::DracoAttribute>& attributes, std::string& error) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes, size);
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    error = decoded.status().error_msg();
    return false;
  }
  const std::unique_ptr<draco::Mesh> source = std::move(decoded).value();
  mesh.vertex_count = source->num_points();
  mesh.indices.reserve(std::size_t{3} * source->num_faces());
  for (draco::FaceIndex face(0); face < source->num_faces(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = source->face(face)[corner].value();
      if (vertex >= mesh.vertex_count) {
        error = "a triangle names a vertex that is not there";
        return false;
      }
      mesh.indices.push_back(vertex);
    }
  }
  for (tsc::DracoAttribute& attribute : attributes) {
    const draco::PointAttribute* found = source->GetAttributeByUniqueId(attribute.id);
    attribute.found = found != nullptr && tsc::readAttribute(*found, mesh.vertex_count, attribute);
  }
  return true;
}
