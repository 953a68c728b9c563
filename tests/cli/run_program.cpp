#include "run_program.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace tsc::cli_test {

namespace fs = std::filesystem;

Folder::Folder() {
  std::string pattern = (fs::temp_directory_path() / "gltf-tsc-test-XXXXXX").string();
  folder_ = ::mkdtemp(pattern.data());
  fs::create_directory(folder_.string() + ".streams");
}

Folder::~Folder() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  fs::remove_all(folder_.string() + ".streams", ignored);
}

ProgramResult Folder::shell(const std::string& command) const {
  const std::string streams = folder_.string() + ".streams";  // beside the folder, so that `list` does not see them
  const std::string line = "cd '" + folder_.string() + "' && { " + command + " ; } >'" + streams + "/out' 2>'" +
                           streams + "/err' </dev/null";
  const int status = std::system(line.c_str());
  ProgramResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = readFile(streams + "/out");
  result.err = readFile(streams + "/err");
  EXPECT_EQ(result.err.find("Sanitizer"), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("runtime error"), std::string::npos) << result.err;
  EXPECT_LT(result.exit_code, 128) << command << "\n" << result.err;
  return result;
}

ProgramResult Folder::run(const std::string& arguments, const std::string& before) const {
  return shell(before + " '" GLTF_TSC_PROGRAM "' " + arguments);
}

void Folder::write(const std::string& name, const std::string& content) const {
  fs::create_directories(path(name).parent_path());
  std::ofstream(path(name), std::ios::binary) << content;
}

std::string Folder::read(const std::string& name) const { return readFile(path(name)); }

std::vector<std::string> Folder::list() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
    if (!entry.is_directory()) names.push_back(entry.path().lexically_relative(folder_).string());
  }
  std::ranges::sort(names);
  return names;
}

std::string sample(const std::string& name) { return std::string(GLTF_TSC_SAMPLES) + "/" + name; }

std::vector<std::string> sampleNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(GLTF_TSC_SAMPLES)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".glb" || path.extension() == ".gltf") names.push_back(path.filename().string());
  }
  std::ranges::sort(names);
  return names;
}

std::string readFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

nlohmann::json document(const std::string& content) {
  if (!content.starts_with("glTF")) return nlohmann::json::parse(content);
  std::uint32_t length = 0;
  std::memcpy(&length, content.data() + 12, sizeof length);
  return nlohmann::json::parse(content.substr(20, length));
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace tsc::cli_test
