// Runs gltf-tsc as a person would, in a folder of its own.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tsc::cli_test {

struct ProgramResult {
  int exit_code = -1;  ///< 128 + the signal if one ended it, as shells have it
  std::string out;
  std::string err;
};

/// A temporary folder, the working folder of the programs run in it.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  /// `arguments` is shell text, so it may redirect and quote; `before` goes ahead of the program ("cat x |").
  ProgramResult run(const std::string& arguments, const std::string& before = "") const;
  /// Any other shell command.
  ProgramResult shell(const std::string& command) const;

  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  void write(const std::string& name, const std::string& content) const;
  std::string read(const std::string& name) const;
  std::vector<std::string> list() const;  ///< names of all files in it, at any depth, sorted

 private:
  std::filesystem::path folder_;
};

/// Path of a committed sample.
std::string sample(const std::string& name);

/// All samples, by file name.
std::vector<std::string> sampleNames();

/// The content of a file.
std::string readFile(const std::filesystem::path& path);

/// The document of a .gltf or .glb.
nlohmann::json document(const std::string& content);

/// Whether `text` contains `part`; for EXPECT_TRUE with a message.
bool contains(const std::string& text, const std::string& part);

}  // namespace tsc::cli_test
