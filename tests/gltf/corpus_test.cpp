// Real assets made by others: every one that a validator accepts packs and comes back. Skipped where there is no
// corpus.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "assets.h"
#include "compare_assets.h"
#include "fault.h"

namespace tsc::test {
namespace {

namespace fs = std::filesystem;

struct Entry {
  std::string path;
  std::string folder;
  std::string expect;
};

/// Columns of one line; quoted ones may hold commas.
std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> columns(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      columns.emplace_back();
    } else if (c != '\r') {
      columns.back() += c;
    }
  }
  return columns;
}

std::vector<Entry> readManifest() {
  std::ifstream file(fs::path(TSC_CORPUS) / "manifest.csv");
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> header = split(line);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  };
  const std::size_t path = column("path"), folder = column("class"), expect = column("expect");
  std::vector<Entry> entries;
  while (std::getline(file, line)) {
    const std::vector<std::string> columns = split(line);
    if (columns.size() > std::max({path, folder, expect}))
      entries.push_back({columns[path], columns[folder], columns[expect]});
  }
  return entries;
}

bool hasCorpus() { return fs::exists(fs::path(TSC_CORPUS) / "manifest.csv"); }

TEST(Corpus, ValidAssetsComeBack) {
  if (!hasCorpus()) GTEST_SKIP() << "no corpus at " << TSC_CORPUS;
  std::size_t packed = 0;
  for (const Entry& entry : readManifest()) {
    if (entry.folder != "gltf" || (entry.expect != "valid" && entry.expect != "tolerable")) continue;
    SCOPED_TRACE(entry.path);
    Expected<Asset> asset = loadAsset(fs::path(TSC_CORPUS) / entry.path);
    ASSERT_TRUE(asset) << asset.failure().message;
    packed += expectRoundTrip(*std::move(asset)).streams.empty() ? 0 : 1;
  }
  EXPECT_GT(packed, 100U);
}

TEST(Corpus, BrokenAssetsAreNamedOrPacked) {
  if (!hasCorpus()) GTEST_SKIP() << "no corpus at " << TSC_CORPUS;
  for (const Entry& entry : readManifest()) {
    if (entry.folder != "bad" && (entry.folder != "gltf" || entry.expect == "valid")) continue;
    SCOPED_TRACE(entry.path);
    Expected<Asset> asset = loadAsset(fs::path(TSC_CORPUS) / entry.path);
    if (!asset) {
      EXPECT_FALSE(asset.failure().message.empty());
      continue;
    }
    Asset original = *asset;
    const Expected<PackReport> report = packAsset(*asset);
    if (!report) {
      EXPECT_NE(report.failure().message.find(entry.path), std::string::npos) << report.failure().message;
    } else if (report->streams.empty()) {
      EXPECT_EQ(original.document, asset->document);
    } else {
      const Outcome unpacked = unpackAsset(*asset);
      EXPECT_FALSE(unpacked) << unpacked->message;
    }
  }
}

}  // namespace
}  // namespace tsc::test
