// pack --out-dir: folders, patterns, failures, what has not changed, and the same bytes for any number of jobs.
#include <gtest/gtest.h>

#include <sstream>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

std::vector<nlohmann::json> lines(const std::string& text) {
  std::vector<nlohmann::json> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(nlohmann::json::parse(line));
  return result;
}

void fillInputs(const Folder& folder) {
  for (const char* name : {"soup.gltf", "soup.bin", "plane-17.5.glb"})
    folder.write(std::string("in/") + name, readFile(sample(name)));
  folder.write("in/deep/ball.gltf", readFile(sample("ball.gltf")));
  folder.write("in/deep/ball.bin", readFile(sample("ball.bin")));
  folder.write("in/readme.txt", "no asset");
}

TEST(PackMany, KeepsTheStructureOfAFolder) {
  const Folder folder;
  fillInputs(folder);
  const ProgramResult result = folder.run("pack in --out-dir out --report - -j 2");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* name : {"out/soup.gltf", "out/plane-17.5.glb", "out/deep/ball.gltf", "out/deep/ball.bin"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path(name))) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("out/readme.txt")));
  EXPECT_EQ(lines(result.out).size(), 3);
  EXPECT_TRUE(contains(result.err, "3 packed, 0 unchanged, 0 failed")) << result.err;
}

TEST(PackMany, ReportsWhatEachAssetLost) {
  const Folder folder;
  fillInputs(folder);
  ASSERT_EQ(folder.run("pack in --out-dir out --report - --quiet").exit_code, 0);
  const ProgramResult many = folder.run("pack in --out-dir again --report -");
  ASSERT_EQ(many.exit_code, 0) << many.err;
  for (const auto& line : lines(many.out)) {
    const std::string input = line.at("input"), output = "single" + std::filesystem::path(input).extension().string();
    const ProgramResult single = folder.run("pack " + input + " --force --report - -o " + output);
    ASSERT_EQ(single.exit_code, 0) << single.err;
    EXPECT_FALSE(line.at("distortion").is_null()) << input;
    EXPECT_EQ(line.at("distortion"), nlohmann::json::parse(single.out).at("distortion")) << input;
  }
  // What has not changed is not packed, and so not measured.
  for (const auto& line : lines(folder.run("pack in --out-dir out --report -").out)) {
    EXPECT_EQ(line.at("status"), "unchanged");
    EXPECT_FALSE(line.contains("distortion"));
  }
}

TEST(PackMany, TakesPatternsAndFiles) {
  const Folder folder;
  fillInputs(folder);
  EXPECT_EQ(folder.run("pack 'in/*.glb' in/deep/ball.gltf --out-dir out").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder.path("out/plane-17.5.glb")));
  EXPECT_TRUE(std::filesystem::exists(folder.path("out/ball.gltf")));
}

TEST(PackMany, SkipsWhatHasNotChanged) {
  const Folder folder;
  fillInputs(folder);
  ASSERT_EQ(folder.run("pack in --out-dir out").exit_code, 0);
  EXPECT_TRUE(contains(folder.run("pack in --out-dir out").err, "0 packed, 3 unchanged, 0 failed"));
  // Another option: all are packed again, which needs permission to replace.
  EXPECT_EQ(folder.run("pack in --out-dir out --position-bits 10").exit_code, 1);
  EXPECT_TRUE(contains(folder.run("pack in --out-dir out --position-bits 10 --force").err, "3 packed, 0 unchanged"));
  // A changed buffer and a damaged output: both are noticed.
  std::string buffer = readFile(sample("ball.bin"));
  buffer[3] = static_cast<char>(buffer[3] ^ 1);
  folder.write("in/deep/ball.bin", buffer);
  folder.write("out/plane-17.5.glb", "damaged");
  EXPECT_TRUE(contains(folder.run("pack in --out-dir out --position-bits 10 --force").err, "2 packed, 1 unchanged"));
}

TEST(PackMany, AChangedPictureIsAChange) {
  const Folder folder;
  folder.write("in/a.gltf", R"({"asset":{"version":"2.0"},"images":[{"uri":"a%20picture.png"}]})");
  folder.write("in/a picture.png", "before");
  ASSERT_EQ(folder.run("pack in --out-dir out").exit_code, 0);
  EXPECT_TRUE(contains(folder.run("pack in --out-dir out").err, "1 unchanged"));
  folder.write("in/a picture.png", "after");
  EXPECT_TRUE(contains(folder.run("pack in --out-dir out --force").err, "1 packed, 0 unchanged"));
  EXPECT_EQ(folder.read("out/a picture.png"), "after");
}

TEST(PackMany, OneFailureDoesNotStopTheOthers) {
  const Folder folder;
  fillInputs(folder);
  folder.write("in/bad.glb", "glTF but no more");
  const ProgramResult result = folder.run("pack in --out-dir out --report -");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "3 packed, 0 unchanged, 1 failed")) << result.err;
  int failed = 0;
  for (const auto& line : lines(result.out)) {
    if (line.at("status") != "failed") continue;
    ++failed;
    EXPECT_EQ(line.at("exitCode"), 2);
    EXPECT_TRUE(contains(line.at("message"), "bad.glb"));
  }
  EXPECT_EQ(failed, 1);
}

TEST(PackMany, TheNumberOfJobsDoesNotChangeTheBytes) {
  const Folder folder;
  const std::string all = "pack '" GLTF_TSC_SAMPLES "' ";
  ASSERT_EQ(folder.run(all + "--out-dir one -j 1 --report one.ndjson").exit_code, 0);
  ASSERT_EQ(folder.run(all + "--out-dir four -j 4 --report four.ndjson").exit_code, 0);
  const auto one = lines(folder.read("one.ndjson")), four = lines(folder.read("four.ndjson"));
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].at("distortion"), four[i].at("distortion")) << i;
  for (const std::string& name : folder.list()) {
    if (!name.starts_with("one/")) continue;
    EXPECT_EQ(folder.read(name), folder.read("four/" + name.substr(4))) << name;
  }
}

TEST(PackMany, TwoInputsForOneOutputAreRefused) {
  const Folder folder;
  fillInputs(folder);
  folder.write("other/plane-17.5.glb", readFile(sample("plane-17.5.glb")));
  const ProgramResult result = folder.run("pack in/plane-17.5.glb other/plane-17.5.glb --out-dir out");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(contains(result.err, "other/plane-17.5.glb")) << result.err;
}

TEST(PackMany, SeveralInputsNeedAnOutputFolder) {
  const Folder folder;
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " " + sample("ball.gltf") + " -o out.glb").exit_code, 1);
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o out.glb --out-dir out").exit_code, 1);
  folder.write("empty/readme.txt", "no asset");
  EXPECT_EQ(folder.run("pack empty --out-dir out").exit_code, 1);
}

}  // namespace
}  // namespace tsc::cli_test
