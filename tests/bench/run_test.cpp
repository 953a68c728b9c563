// Sets of meshes, and results that survive an interruption.
#include "run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>

namespace tsc::bench {
namespace {

namespace fs = std::filesystem;

class Run : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string storePath() const { return (folder_ / "results.jsonl").string(); }

  /// A glTF file of one triangle, as wide as `width`.
  CorpusFile writeTriangle(const std::string& name, float width) const {
    const float positions[9] = {0, 0, 0, width, 0, 0, 0, 1, 0};
    const fs::path buffer = folder_ / (name + ".bin"), path = folder_ / (name + ".gltf");
    std::ofstream(buffer, std::ios::binary).write(reinterpret_cast<const char*>(positions), sizeof positions);
    const nlohmann::json document = {
        {"asset", {{"version", "2.0"}}},
        {"buffers", {{{"uri", buffer.filename().string()}, {"byteLength", 36}}}},
        {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}}},
        {"accessors", {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}}},
        {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}}},
    };
    std::ofstream(path) << document;
    return {path, fs::file_size(path)};
  }

  const fs::path folder_ = fs::temp_directory_path() / ("tsc_bench_run_test_" + std::to_string(getpid()));
};

TEST_F(Run, storeRemembersResultsOfTheSameKey) {
  ResultStore(storePath(), "key").add("a", {{"x", 1}});
  EXPECT_EQ(ResultStore(storePath(), "key").find("a").at("x"), 1);
  EXPECT_TRUE(ResultStore(storePath(), "key").find("b").is_null());
  EXPECT_TRUE(ResultStore(storePath(), "another build").find("a").is_null());
  EXPECT_TRUE(ResultStore(storePath(), "key").find("a").is_null()) << "the file was started anew";
}

TEST_F(Run, storeSurvivesALineCutAtAnyLength) {
  ResultStore(storePath(), "key").add("a", {{"x", 1}});
  const auto whole = fs::file_size(storePath());
  ResultStore(storePath(), "key").add("b", {{"x", 2}});
  std::ifstream file(storePath());
  const std::string content(std::istreambuf_iterator<char>(file), {});
  for (std::size_t length = whole; length < content.size(); ++length) {
    writeFile(storePath(), content.substr(0, length));
    ResultStore store(storePath(), "key");
    EXPECT_EQ(store.find("a").at("x"), 1) << length;
    store.add("c", {{"x", 3}});
    const ResultStore again(storePath(), "key");
    EXPECT_EQ(again.find("a").at("x"), 1) << length;
    EXPECT_EQ(again.find("c").at("x"), 3) << length;
  }
}

TEST_F(Run, everyMeshIsMeasuredOnceWhateverTheThreads) {
  std::vector<CorpusFile> files;
  for (int i = 0; i < 9; ++i) files.push_back(writeTriangle("triangle" + std::to_string(i), 1.0f + float(i)));
  for (const unsigned threads : {1u, 2u, 5u}) {
    std::mutex mutex;
    std::multiset<std::string> names;
    EXPECT_EQ(forEachMesh({files, {}, threads},
                          [&](const BenchMesh& mesh) {
                            const std::lock_guard lock(mutex);
                            names.insert(mesh.name);
                          }),
              0u);
    EXPECT_EQ(names.size(), 9u);
    EXPECT_EQ(names.count("triangle7"), 1u);
  }
}

TEST_F(Run, failuresAreCountedAndStopNothing) {
  const CorpusFile good = writeTriangle("good", 1), throwing = writeTriangle("throwing", 2);
  std::ofstream(folder_ / "broken.glb") << "no glTF";
  std::atomic<int> measured = 0;
  EXPECT_EQ(forEachMesh({{{folder_ / "broken.glb", 7}, throwing, good}, {}, 2},
                        [&](const BenchMesh& mesh) {
                          if (mesh.name == "throwing") throw std::runtime_error("refused");
                          ++measured;
                        }),
            2u);
  EXPECT_EQ(measured, 1);
}

TEST_F(Run, patchesReplaceTheMesh) {
  std::vector<std::string> classes;
  EXPECT_EQ(forEachMesh({{writeTriangle("small", 1)}, {2, 200}, 1},
                        [&](const BenchMesh& mesh) { classes.push_back(mesh.class_name); }),
            0u);
  EXPECT_EQ(classes, (std::vector<std::string>{"patches", "patches"}));
}

TEST_F(Run, provenanceNamesWhatWasMeasured) {
  for (const char* part : {"commit", "Draco", "meshoptimizer"}) {
    EXPECT_NE(provenance().find(part), std::string::npos) << part;
  }
  EXPECT_EQ(buildKey(), buildKey());
  EXPECT_EQ(buildKey().size(), 16u);
}

TEST_F(Run, writeFileSaysWhenItCannot) {
  EXPECT_THROW(writeFile((folder_ / "missing" / "file").string(), "text"), std::runtime_error);
}

}  // namespace
}  // namespace tsc::bench
