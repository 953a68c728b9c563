// Loads each file named on the command line with tinygltf alone, as an application without this library would. Prints
// those that fail; exits with 1 if any did.
#include <tiny_gltf.h>

#include <cstdio>
#include <string>

int main(int argc, char** argv) {
  int failed = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string path = argv[i];
    tinygltf::TinyGLTF loader;
    // Pictures are not what is tested, and tinygltf fails on formats that it does not know.
    loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*,
                             int, void*) { return true; },
                          nullptr);
    tinygltf::Model model;
    std::string error, warning;
    const bool binary = path.size() > 4 && path.substr(path.size() - 4) == ".glb";
    const bool loaded = binary ? loader.LoadBinaryFromFile(&model, &error, &warning, path)
                               : loader.LoadASCIIFromFile(&model, &error, &warning, path);
    if (loaded) continue;
    failed = 1;
    std::printf("%s: %s\n", path.c_str(), error.c_str());
  }
  return failed;
}
