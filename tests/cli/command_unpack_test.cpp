// unpack: plain glTF out of packed assets, clear refusals of damaged ones.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

constexpr const char* kExtension = "EXT_mesh_tangentspace_compression";

TEST(Unpack, LeavesNoTraceOfTheExtension) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("vase.glb") + " -o packed.glb").exit_code, 0);
  EXPECT_TRUE(contains(document(folder.read("packed.glb")).dump(), kExtension));
  const ProgramResult result = folder.run("unpack packed.glb -o plain.glb");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(contains(document(folder.read("plain.glb")).dump(), kExtension));
}

TEST(Unpack, KeepsWhatPackDoesNotOwn) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("vase.glb") + " -o packed.glb").exit_code, 0);
  ASSERT_EQ(folder.run("unpack packed.glb -o plain.glb").exit_code, 0);
  const auto before = document(readFile(sample("vase.glb"))), after = document(folder.read("plain.glb"));
  for (const char* property : {"asset", "scene", "scenes", "nodes", "materials", "textures", "samplers"}) {
    EXPECT_EQ(before.at(property), after.at(property)) << property;
  }
}

TEST(Unpack, CopiesAnAssetThatIsNotPacked) {
  const Folder folder;
  const ProgramResult result = folder.run("unpack " + sample("plane-17.5.glb") + " -o plain.glb");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "not packed")) << result.err;
  EXPECT_EQ(document(folder.read("plain.glb")), document(readFile(sample("plane-17.5.glb"))));
}

TEST(Unpack, EveryTruncationOfAPackedFileIsInvalid) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("soup.gltf") + " -o packed.glb").exit_code, 0);
  const std::string packed = folder.read("packed.glb");
  for (std::size_t length = 0; length < packed.size(); length += 1 + packed.size() / 40) {
    folder.write("cut.glb", packed.substr(0, length));
    const ProgramResult result = folder.run("unpack cut.glb -o plain.glb");
    EXPECT_EQ(result.exit_code, 2) << length << " bytes: " << result.err;
    EXPECT_TRUE(contains(result.err, "cut.glb")) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path("plain.glb")));
  }
}

TEST(Unpack, DamageInsideTheStreamIsFound) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("plane-17.5.glb") + " -o packed.glb").exit_code, 0);
  const std::string packed = folder.read("packed.glb");
  const auto json = document(packed);
  const auto inspected = nlohmann::json::parse(folder.run("inspect packed.glb --json").out);
  const auto& view = json.at("bufferViews").at(inspected.at("streams").at(0).at("bufferView").get<std::size_t>());
  std::uint32_t json_length = 0;
  std::memcpy(&json_length, packed.data() + 12, sizeof json_length);
  const std::size_t start = 28 + json_length + view.value("byteOffset", std::size_t{0});
  const std::size_t length = view.at("byteLength");
  for (std::size_t i = 0; i < length; i += 1 + length / 30) {
    std::string damaged = packed;
    damaged[start + i] = static_cast<char>(damaged[start + i] ^ 0x10);
    folder.write("damaged.glb", damaged);
    const ProgramResult result = folder.run("unpack damaged.glb -o plain.glb");
    EXPECT_TRUE(result.exit_code == 2 || result.exit_code == 3) << "byte " << i << ": " << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path("plain.glb")));
  }
}

TEST(Unpack, NeedsAnOutput) { EXPECT_EQ(Folder().run("unpack " + sample("soup.gltf")).exit_code, 1); }

TEST(Unpack, KeepsToTheLimitOfOutputBytes) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("slug.glb") + " -o packed.glb").exit_code, 0);
  const ProgramResult result = folder.run("unpack packed.glb -o plain.glb --max-output-bytes 1000");
  EXPECT_TRUE(result.exit_code == 2 || result.exit_code == 3) << result.exit_code << result.err;
  EXPECT_TRUE(contains(result.err, "1000")) << result.err;
}

}  // namespace
}  // namespace tsc::cli_test
