// The one function through which libdraco is used.
//
// Debian's libdraco contains a copy of tinygltf built with other options than libtinygltf. In one process the two mix
// and crash, so draco_decode.cpp and what it needs of libdraco.a are linked into one object of which only this function
// stays visible (CMakeLists.txt). It therefore shares nothing but plain data with the rest of the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tsc {

/// An attribute wanted, and then its values.
struct DracoAttribute {
  std::uint32_t id = 0;              ///< unique id in the Draco stream
  std::uint32_t component_type = 0;  ///< glTF (GL) number
  std::size_t components = 0;        ///< 1 to 4
  bool found = false;                ///< there is such an attribute, with that many components
  std::vector<std::byte> values;     ///< packed elements
};

struct DracoMesh {
  std::uint32_t vertex_count = 0;
  std::vector<std::uint32_t> indices;  ///< 3 a triangle
};

}  // namespace tsc

/// Decodes a mesh. Gives false and a text in `error` if the data is damaged. Throws nothing but std::bad_alloc.
extern "C" bool tsc_decode_draco(const char* bytes, std::size_t size, tsc::DracoMesh& mesh,
                                 std::vector<tsc::DracoAttribute>& attributes, std::string& error);
