// Writes the format's test vectors: make_vectors FOLDER --write. Without --write it only says what it would change, and
// returns 1 if anything would: vectors change with the format, on purpose, or not at all.
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "vectors.h"

namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns whether the file is, or was, other than `content`.
bool update(const fs::path& path, const std::string& content, bool write) {
  if (fs::exists(path) && contentOf(path) == content) return false;
  std::printf("%s %s\n", write ? "wrote" : "differs:", path.string().c_str());
  if (!write) return true;
  std::ofstream file(path, std::ios::binary);
  file << content;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const bool write = argc == 3 && std::strcmp(argv[2], "--write") == 0;
  if (argc < 2 || (argc > 2 && !write)) {
    std::fprintf(stderr, "usage: %s FOLDER [--write]\n", argv[0]);
    return 2;
  }
  bool changes = false;
  try {
    if (write) fs::create_directories(argv[1]);
    for (const tsc::test::Vector& vector : tsc::test::allVectors()) {
      const tsc::test::RoundTrip trip = tsc::test::roundTrip(vector.mesh, vector.options);
      if (!trip.fault.empty()) throw std::runtime_error(vector.name + ": " + trip.fault);
      const tsc::test::Bytes& stream = trip.encoded.bytes;
      const fs::path path = fs::path(argv[1]) / vector.name;
      changes |= update(path.string() + ".tsc", {reinterpret_cast<const char*>(stream.data()), stream.size()}, write);
      changes |= update(path.string() + ".json", tsc::test::textOf(describeStream(vector, stream)), write);
    }
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "%s\n", fault.what());
    return 1;
  }
  return changes && !write ? 1 : 0;
}
