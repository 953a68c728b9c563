// The layers of the source: the codec knows no glTF and no JSON, and includes run one way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace tsc {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = TSC_SOURCE_FOLDER;

std::vector<fs::path> sourcesOf(const std::string& part) {
  std::vector<fs::path> files;
  if (!fs::exists(kSource / part)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(kSource / part)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".h" || extension == ".cpp") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> linesOf(const fs::path& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::string lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// What a line includes between `open` and `close`; empty if it includes nothing in that way.
std::string includedBy(const std::string& line, char open, char close) {
  const std::size_t hash = line.find_first_not_of(' ');
  if (hash == std::string::npos || line[hash] != '#') return {};
  const std::size_t first = line.find(open), last = line.find(close, first + 1);
  const bool includes = line.find("include") < first && first != std::string::npos && last != std::string::npos;
  return includes ? line.substr(first + 1, last - first - 1) : std::string();
}

bool hasWord(const std::string& text, const std::string& word) {
  const auto isPart = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !isPart(text[at - 1])) && (end == text.size() || !isPart(text[end]))) return true;
  }
  return false;
}

TEST(Architecture, TheCodecHasNoWordOfItsUsers) {
  const std::vector<fs::path> files = sourcesOf("codec");
  ASSERT_FALSE(files.empty());
  for (const fs::path& path : files) {
    for (const std::string& line : linesOf(path)) {
      for (const char* word : {"gltf", "json"}) {
        EXPECT_EQ(lowered(line).find(word), std::string::npos) << path << ": " << line;
      }
    }
  }
}

TEST(Architecture, TheCodecNeedsTheStandardLibraryAndGlmOnly) {
  const std::set<std::string> intrinsics = {"emmintrin.h", "immintrin.h", "arm_neon.h", "wasm_simd128.h"};
  const std::set<std::string> unwanted = {"fstream", "iostream", "thread", "mutex", "atomic", "filesystem", "future"};
  for (const fs::path& path : sourcesOf("codec")) {
    for (const std::string& line : linesOf(path)) {
      const std::string header = includedBy(line, '<', '>');
      if (header.empty()) continue;
      EXPECT_FALSE(unwanted.contains(header)) << path << ": no files and no threads here: " << line;
      const bool is_standard = header.find('/') == std::string::npos && header.find('.') == std::string::npos;
      EXPECT_TRUE(is_standard || header.starts_with("glm/") || intrinsics.contains(header)) << path << ": " << line;
    }
  }
}

TEST(Architecture, TheCodecThrowsNothing) {
  for (const fs::path& path : sourcesOf("codec")) {
    for (const std::string& line : linesOf(path)) {
      for (const char* keyword : {"throw", "try", "catch"}) {
        EXPECT_FALSE(hasWord(line.substr(0, line.find("//")), keyword)) << path << ": " << line;
      }
    }
  }
}

TEST(Architecture, IncludesRunOneWay) {
  // codec <- gltf <- cli; codec <- quality <- cli; web sees the codec only; the benchmark sees all.
  const std::map<std::string, std::set<std::string>> allowed = {
      {"codec", {}},
      {"gltf", {"codec"}},
      {"quality", {"codec", "gltf"}},
      {"cli", {"codec", "gltf", "quality"}},
      {"web", {"codec"}},
      {"bench", {"codec", "gltf", "quality", "cli"}},
  };
  // Where each header lies, by the last two parts of its path and by its name alone.
  std::map<std::string, std::set<std::string>> parts_of_header;
  for (const auto& [part, seen] : allowed) {
    for (const fs::path& path : sourcesOf(part)) {
      if (path.extension() != ".h") continue;
      parts_of_header[path.filename().string()].insert(part);
      parts_of_header[path.parent_path().filename().string() + "/" + path.filename().string()].insert(part);
    }
  }
  for (const auto& [part, seen] : allowed) {
    for (const fs::path& path : sourcesOf(part)) {
      for (const std::string& line : linesOf(path)) {
        const auto found = parts_of_header.find(includedBy(line, '"', '"'));
        if (found == parts_of_header.end() || found->second.contains(part)) continue;
        const bool is_allowed = std::any_of(found->second.begin(), found->second.end(),
                                            [&](const std::string& other) { return seen.contains(other); });
        EXPECT_TRUE(is_allowed) << path << ": " << line;
      }
    }
  }
}

TEST(Architecture, FilesStayReadable) {
  for (const fs::path& path : sourcesOf("codec")) {
    EXPECT_LE(linesOf(path).size(), 800u) << path;
    EXPECT_TRUE(linesOf(path).at(0).starts_with("//") || path.extension() == ".cpp") << path << " says what it is for";
  }
}

}  // namespace
}  // namespace tsc
