// Files: formats, other folders, refusal to overwrite, confinement.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "assets.h"
#include "compare_assets.h"

namespace tsc::test {
namespace {

namespace fs = std::filesystem;

class Save : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tsc-save-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::size_t fileCount() const {
    return static_cast<std::size_t>(
        std::distance(fs::recursive_directory_iterator(folder_), fs::recursive_directory_iterator()));
  }
  void write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }

  fs::path folder_;
};

TEST_F(Save, EveryFormatLoadsAgain) {
  Asset asset = gridAsset();
  addVertexIds(asset);  // a second buffer
  for (const char* name : {"a.glb", "b.gltf", "with space.gltf"}) {
    const Outcome saved = saveAsset(asset, folder_ / name);
    ASSERT_FALSE(saved) << saved->message;
    const Expected<Asset> loaded = loadAsset(folder_ / name);
    ASSERT_TRUE(loaded) << loaded.failure().message;
    expectSame(asset, *loaded, 0);
  }
  EXPECT_EQ(fileCount(), 7U);
}

TEST_F(Save, ExistingFilesNeedForce) {
  const Asset asset = gridAsset();
  write("a.glb", "old");
  const Outcome refused = saveAsset(asset, folder_ / "a.glb");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->kind, FailureKind::kUsage);
  EXPECT_EQ(fs::file_size(folder_ / "a.glb"), 3U);
  EXPECT_FALSE(saveAsset(asset, folder_ / "a.glb", {true}));
  EXPECT_EQ(fileCount(), 1U);
}

TEST_F(Save, AFailedRunLeavesNothing) {
  write("a.bin", "precious");
  const Outcome refused = saveAsset(gridAsset(), folder_ / "a.gltf");
  ASSERT_TRUE(refused);
  EXPECT_EQ(fileCount(), 1U);
  const Outcome no_folder = saveAsset(gridAsset(), folder_ / "missing" / "a.glb");
  ASSERT_TRUE(no_folder);
  EXPECT_EQ(no_folder->kind, FailureKind::kIo);
  const Outcome full = writeFile("/dev/full", std::vector<std::byte>(10), true);
  ASSERT_TRUE(full);
  EXPECT_EQ(full->kind, FailureKind::kIo);
}

TEST_F(Save, ExternalFilesTravelToAnotherFolder) {
  Asset asset = gridAsset();
  asset.document["images"] = Json::parse(R"([{"uri":"tex/a%20b.png"},{"uri":"missing.png"}])");
  ASSERT_FALSE(saveAsset(asset, folder_ / "in.gltf"));
  write("tex/a b.png", "pixels");
  Expected<Asset> loaded = loadAsset(folder_ / "in.gltf");
  ASSERT_TRUE(loaded) << loaded.failure().message;
  ASSERT_TRUE(packAsset(*loaded));
  fs::create_directory(folder_ / "out");
  ASSERT_FALSE(saveAsset(*loaded, folder_ / "out" / "in.gltf"));
  EXPECT_TRUE(fs::exists(folder_ / "out/tex/a b.png"));
  EXPECT_TRUE(fs::exists(folder_ / "out/in.bin"));
  // The same again is fine; a different file of that name is not replaced.
  ASSERT_FALSE(saveAsset(*loaded, folder_ / "out" / "second.glb"));
  write("out/tex/a b.png", "others");
  EXPECT_TRUE(saveAsset(*loaded, folder_ / "out" / "third.glb"));
  EXPECT_FALSE(fs::exists(folder_ / "out/third.glb"));
}

TEST_F(Save, UrisStayInTheFolder) {
  write("secret.bin", std::string(400, 'x'));
  fs::create_directory(folder_ / "in");
  const auto message = [&](const std::string& uri) {
    Json document = Json::parse(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4}]})");
    document["buffers"][0]["uri"] = uri;
    write("in/a.gltf", writeJson(document));
    const Expected<Asset> asset = loadAsset(folder_ / "in/a.gltf");
    return asset ? std::string() : asset.failure().message;
  };
  EXPECT_NE(message("../secret.bin").find("leads out"), std::string::npos);
  EXPECT_NE(message("%2e%2e/secret.bin").find("leads out"), std::string::npos);
  EXPECT_NE(message((folder_ / "secret.bin").string()).find("leads out"), std::string::npos);
  EXPECT_NE(message("https://example.org/a.bin").find("relative"), std::string::npos);
  fs::create_symlink(folder_ / "secret.bin", folder_ / "in/link.bin");
  EXPECT_NE(message("link.bin").find("leads out"), std::string::npos);
  LoadOptions options;
  options.allow_external = true;
  EXPECT_TRUE(loadAsset(folder_ / "in/a.gltf", options));
}

}  // namespace
}  // namespace tsc::test
