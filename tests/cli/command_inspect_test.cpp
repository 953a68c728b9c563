// inspect: counts and streams, for people and as JSON.
#include <gtest/gtest.h>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

TEST(Inspect, CountsAPlainAsset) {
  const ProgramResult result = Folder().run("inspect " + sample("slug.glb") + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = nlohmann::json::parse(result.out);
  EXPECT_EQ(summary.at("packed"), false);
  EXPECT_EQ(summary.at("vertices"), 10242);
  EXPECT_EQ(summary.at("triangles"), 20480);
  EXPECT_TRUE(summary.at("streams").empty());
}

TEST(Inspect, CountsAreTheSamePackedAndUnpacked) {
  const Folder folder;
  for (const std::string& name : sampleNames()) {
    ASSERT_EQ(folder.run("pack " + sample(name) + " -o packed.glb --force").exit_code, 0) << name;
    const auto plain = nlohmann::json::parse(folder.run("inspect --json " + sample(name)).out);
    const auto packed = nlohmann::json::parse(folder.run("inspect --json packed.glb").out);
    EXPECT_EQ(packed.at("packed"), true) << name;
    EXPECT_EQ(packed.at("streams").size(), 1) << name;
    for (const char* count : {"meshes", "primitives", "vertices", "triangles"}) {
      EXPECT_EQ(plain.at(count), packed.at(count)) << name << " " << count;
    }
  }
}

TEST(Inspect, TextNamesStreamsAndModes) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("tentacle.glb") + " -o packed.glb").exit_code, 0);
  const ProgramResult result = folder.run("inspect packed.glb");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* part : {"tentacle", "bits/vertex", "predictor", "positions of float32", "indices of uint16"}) {
    EXPECT_TRUE(contains(result.out, part)) << part << "\n" << result.out;
  }
}

TEST(Inspect, AFullStandardOutputIsAnIoFault) {
  EXPECT_EQ(Folder().run("inspect " + sample("soup.gltf") + " >/dev/full").exit_code, 4);
}

}  // namespace
}  // namespace tsc::cli_test
