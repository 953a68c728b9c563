// The codec alone: a tetrahedron to bytes and back.
#include <tsc/codec.h>

#include <cstdio>
#include <vector>

int main() {
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  tsc::Mesh mesh;
  mesh.tables.push_back({positions});
  mesh.primitives.push_back({.table = 0, .indices = indices});
  tsc::EncodeOptions options;
  options.step = tsc::stepForBits(mesh, 12);
  const auto encoded = tsc::encode(mesh, options);
  if (!encoded) {
    std::fprintf(stderr, "%s\n", tsc::describe(encoded.error()).c_str());
    return 1;
  }
  const auto decoded = tsc::decode(encoded->bytes);
  if (!decoded) {
    std::fprintf(stderr, "%s\n", tsc::describe(decoded.error()).c_str());
    return 1;
  }
  std::printf("%zu bytes hold %zu arrays\n", encoded->bytes.size(), decoded->size());
  return decoded->size() == 2 && (*decoded)[0].size() == 48 ? 0 : 1;
}
