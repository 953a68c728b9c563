// A viewer: a packed asset into a tinygltf model, and the same as plain GLB bytes.
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tsc/gltf.h>
#include <tsc/tinygltf.h>

#include <cstdio>
#include <limits>

int main(int argc, char** argv) {
  if (argc != 2) return 1;

  tinygltf::Model model;
  if (const auto failure = tsc::loadModel(argv[1], model)) {
    std::fprintf(stderr, "%s\n", failure->message.c_str());
    return 1;
  }
  std::size_t indices = 0;
  for (const auto& mesh : model.meshes) {
    for (const auto& primitive : mesh.primitives) indices += model.accessors[primitive.indices].count;
  }
  std::printf("%zu meshes, %zu triangles\n", model.meshes.size(), indices / 3);

  const auto packed = tsc::readFile(argv[1], std::numeric_limits<std::uint64_t>::max());
  if (!packed) return 1;
  const auto plain = tsc::expand(*packed);
  if (!plain) {
    std::fprintf(stderr, "%s\n", plain.failure().message.c_str());
    return 1;
  }
  return indices == 3 * 7168 && plain->size() > packed->size() ? 0 : 1;
}
