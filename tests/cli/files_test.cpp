// Files and streams: existing outputs, the input as output, full disks, rubbish as input.
#include <gtest/gtest.h>

#include <random>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

TEST(Files, AnExistingOutputStaysWithoutForce) {
  const Folder folder;
  folder.write("out.glb", "precious");
  for (const char* verb : {"pack ", "unpack "}) {
    const ProgramResult result = folder.run(verb + sample("soup.gltf") + " -o out.glb");
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(contains(result.err, "out.glb") && contains(result.err, "--force")) << result.err;
    EXPECT_EQ(folder.read("out.glb"), "precious");
  }
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o out.glb --force").exit_code, 0);
  EXPECT_TRUE(folder.read("out.glb").starts_with("glTF"));
}

TEST(Files, AnExistingBufferFileStaysWithoutForce) {
  const Folder folder;
  folder.write("out.bin", "precious");
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o out.gltf").exit_code, 1);
  EXPECT_EQ(folder.list(), std::vector<std::string>{"out.bin"});
  EXPECT_EQ(folder.read("out.bin"), "precious");
}

TEST(Files, AnExistingReportStaysWithoutForce) {
  const Folder folder;
  folder.write("report.json", "precious");
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o out.glb --report report.json").exit_code, 1);
  EXPECT_EQ(folder.list(), std::vector<std::string>{"report.json"});
}

TEST(Files, TheInputMayBeTheOutputWithForce) {
  const Folder folder;
  folder.write("asset.glb", readFile(sample("vase.glb")));
  EXPECT_EQ(folder.run("pack asset.glb -o asset.glb").exit_code, 1);
  EXPECT_EQ(folder.read("asset.glb"), readFile(sample("vase.glb")));
  EXPECT_EQ(folder.run("pack asset.glb -o asset.glb --force").exit_code, 0);
  EXPECT_LT(folder.read("asset.glb").size(), readFile(sample("vase.glb")).size());
  EXPECT_EQ(folder.run("unpack asset.glb -o asset.glb --force").exit_code, 0);
  EXPECT_EQ(folder.list(), std::vector<std::string>{"asset.glb"});
}

TEST(Files, TheInputMayBeTheOutputWithItsBuffers) {
  const Folder folder;
  folder.write("ball.gltf", readFile(sample("ball.gltf")));
  folder.write("ball.bin", readFile(sample("ball.bin")));
  EXPECT_EQ(folder.run("pack ball.gltf -o ball.gltf --force").exit_code, 0);
  EXPECT_LT(folder.read("ball.bin").size(), readFile(sample("ball.bin")).size());
  EXPECT_EQ(folder.run("unpack ball.gltf -o plain.glb").exit_code, 0);
}

TEST(Files, StandardInputAndOutputCarryTheSameBytesAsFiles) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("plane-17.5.glb") + " -o file.glb").exit_code, 0);
  const ProgramResult piped = folder.run("pack - -o -", "cat " + sample("plane-17.5.glb") + " |");
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_EQ(piped.out, folder.read("file.glb"));
  const ProgramResult unpacked = folder.run("unpack - -o - --quiet", "cat file.glb |");
  EXPECT_EQ(unpacked.exit_code, 0) << unpacked.err;
  EXPECT_EQ(unpacked.err, "");
  ASSERT_EQ(folder.run("unpack file.glb -o plain.glb").exit_code, 0);
  EXPECT_EQ(unpacked.out, folder.read("plain.glb"));
  EXPECT_EQ(folder.run("inspect -", "cat file.glb |").exit_code, 0);
}

TEST(Files, FullDisksAreIoFaults) {
  const Folder folder;
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o - >/dev/full").exit_code, 4);
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o /dev/full").exit_code, 4);
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o out.glb --report - >/dev/full").exit_code, 4);
  const ProgramResult limited =
      folder.shell("ulimit -f 1; trap '' XFSZ; '" GLTF_TSC_PROGRAM "' unpack " + sample("slug.glb") + " -o big.glb");
  EXPECT_EQ(limited.exit_code, 4) << limited.err;
  EXPECT_TRUE(contains(limited.err, "big.glb")) << limited.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path("big.glb")));
}

TEST(Files, AReaderThatGoesAwayIsAnIoFault) {
  const Folder folder;
  const ProgramResult result =
      folder.shell("{ '" GLTF_TSC_PROGRAM "' pack " + sample("slug.glb") + " -o - --quiet; echo $? >code; } | true");
  EXPECT_EQ(folder.read("code"), "4\n") << result.err;
}

TEST(Files, MissingInputsAndFoldersAreIoFaults) {
  const Folder folder;
  const ProgramResult missing = folder.run("pack nothing.glb -o out.glb");
  EXPECT_EQ(missing.exit_code, 4);
  EXPECT_TRUE(contains(missing.err, "nothing.glb")) << missing.err;
  EXPECT_EQ(folder.run("pack " + sample("soup.gltf") + " -o nowhere/out.glb").exit_code, 4);
  EXPECT_TRUE(folder.list().empty());
}

TEST(Files, OutputNamesSayTheFormat) {
  const Folder folder;
  for (const char* name : {"out", "out.obj", "out.GLTF2"}) {
    const ProgramResult result = folder.run("pack " + sample("soup.gltf") + " -o " + name);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(contains(result.err, ".glb")) << result.err;
  }
}

TEST(Files, RandomBytesAreInvalidInput) {
  const Folder folder;
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    std::string bytes(1 + random() % 2000, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    if (round % 2 == 0) bytes = std::string("glTF\2\0\0\0", 8) + bytes;
    folder.write("noise.glb", bytes);
    for (const char* verb : {"pack noise.glb -o out.glb", "unpack noise.glb -o out.glb", "inspect noise.glb"}) {
      const ProgramResult result = folder.run(verb);
      EXPECT_EQ(result.exit_code, 2) << verb << ": " << result.err;
      EXPECT_TRUE(contains(result.err, "noise.glb")) << result.err;
      EXPECT_EQ(result.out, "");
    }
  }
  EXPECT_EQ(folder.list(), std::vector<std::string>{"noise.glb"});
}

TEST(Files, EveryTruncationOfAGlbIsInvalidInput) {
  const Folder folder;
  const std::string whole = readFile(sample("plane-17.5.glb"));
  for (const std::size_t length : {std::size_t{0}, std::size_t{3}, std::size_t{11}, std::size_t{12}, std::size_t{19},
                                   std::size_t{20}, std::size_t{500}, whole.size() / 2, whole.size() - 1}) {
    folder.write("cut.glb", whole.substr(0, length));
    const ProgramResult result = folder.run("pack cut.glb -o out.glb");
    EXPECT_EQ(result.exit_code, 2) << length << " bytes: " << result.err;
    EXPECT_TRUE(contains(result.err, "cut.glb")) << result.err;
  }
  EXPECT_EQ(folder.list(), std::vector<std::string>{"cut.glb"});
}

TEST(Files, AMissingBufferIsNamed) {
  const Folder folder;
  folder.write("ball.gltf", readFile(sample("ball.gltf")));
  const ProgramResult result = folder.run("pack ball.gltf -o out.glb");
  EXPECT_TRUE(result.exit_code == 2 || result.exit_code == 4) << result.exit_code;
  EXPECT_TRUE(contains(result.err, "ball.bin")) << result.err;
}

TEST(Files, BuffersOutsideTheFolderNeedPermission) {
  const Folder folder;
  folder.write("ball.bin", readFile(sample("ball.bin")));
  std::string text = readFile(sample("ball.gltf"));
  text.replace(text.find("\"ball.bin\""), 10, "\"../ball.bin\"");
  folder.write("inner/ball.gltf", text);
  const ProgramResult refused = folder.run("pack inner/ball.gltf -o out.glb");
  EXPECT_TRUE(refused.exit_code == 2 || refused.exit_code == 3) << refused.exit_code;
  EXPECT_TRUE(contains(refused.err, "../ball.bin")) << refused.err;
  const ProgramResult allowed = folder.run("pack inner/ball.gltf -o out.glb --allow-external");
  EXPECT_EQ(allowed.exit_code, 0) << allowed.err;
}

TEST(Files, NamesMayBeInCapitals) {
  const Folder folder;
  folder.write("in/A.GLB", readFile(sample("plane-17.5.glb")));
  EXPECT_EQ(folder.run("pack in/A.GLB -o B.GLB").exit_code, 0);
  EXPECT_TRUE(contains(folder.run("inspect B.GLB").out, ": packed,"));
  EXPECT_TRUE(contains(folder.run("pack in --out-dir out").err, "1 asset: 1 packed")) << "found in a folder too";
}

TEST(Files, WhatIsMissingIsNotTakenForSomethingElse) {
  const Folder folder;
  folder.write("lost.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"gone.bin"}]})");
  folder.write("out.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"../../etc/passwd"}]})");
  folder.write("nothing.glb", "");
  const auto expect = [&](const std::string& arguments, int exit_code, const std::string& text) {
    const ProgramResult result = folder.run(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments;
    EXPECT_TRUE(contains(result.err, text)) << arguments << "\n" << result.err;
  };
  expect("pack lost.gltf -o x.glb", 4, "cannot read gone.bin: No such file");
  expect("pack out.gltf -o x.glb", 2, "leads out of the folder");
  expect("pack nothing.glb -o x.glb", 2, "found nothing at all");
  expect("pack '' -o x.glb", 1, "empty name");
  expect("pack . -o x.glb", 1, "--out-dir FOLDER packs all");
  expect("inspect .", 1, "found a folder");
  expect("pack 'no/*.glb' --out-dir out", 1, "fits no file");
  expect("squeeze lost.gltf", 1, "found 'squeeze', expected pack, unpack, inspect or compare");
  expect("pack " + sample("plane-17.5.glb") + " -o x.glb --report ./x.glb --force", 1, "cannot take both");
  EXPECT_FALSE(std::filesystem::exists(folder.path("x.glb")));
}

}  // namespace
}  // namespace tsc::cli_test
