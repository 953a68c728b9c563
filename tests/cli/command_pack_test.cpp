// pack: what it says, what it promises about errors, what it refuses.
#include <gtest/gtest.h>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

TEST(Pack, SaysSizesBitsErrorsAndModes) {
  const Folder folder;
  const ProgramResult result = folder.run("pack " + sample("slug.glb") + " -o packed.glb");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  for (const char* part :
       {"packed.glb", "10242 vertices", "20480 triangles", "bits/vertex", "max ", "RMS ", "predictor"}) {
    EXPECT_TRUE(contains(result.err, part)) << part << "\n" << result.err;
  }
  EXPECT_LT(folder.read("packed.glb").size(), readFile(sample("slug.glb")).size());
}

TEST(Pack, QuietSaysNothing) {
  const ProgramResult result = Folder().run("pack " + sample("soup.gltf") + " -o packed.glb --quiet");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out, "");
}

TEST(Pack, ReportIsJsonAndAgreesWithTheFile) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("flange.gltf") + " -o packed.glb --report report.json").exit_code, 0);
  const auto report = nlohmann::json::parse(folder.read("report.json"));
  const auto& stream = report.at("streams").at(0);
  EXPECT_EQ(stream.at("triangles"), 1740);
  EXPECT_LE(stream.at("maxError"), stream.at("guaranteedError"));
  EXPECT_LE(stream.at("rmsError"), stream.at("maxError"));
  const auto& bits = stream.at("bitsPerVertex");
  double sum = 0;
  for (const auto& [part, value] : bits.items()) sum += part == "total" ? 0 : value.get<double>();
  EXPECT_NEAR(sum, bits.at("total").get<double>(), 0.5);

  const ProgramResult to_output = folder.run("pack " + sample("flange.gltf") + " -o again.glb --quiet --report -");
  EXPECT_EQ(to_output.exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(to_output.out).at("streams"), report.at("streams"));
}

TEST(Pack, KeepsTheBoundThatWasAskedFor) {
  for (const char* bound : {"0.01", "0.0001"}) {
    const Folder folder;
    const ProgramResult result =
        folder.run("pack " + sample("slug.glb") + " -o packed.glb --quiet --report - --max-error " + bound);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto stream = nlohmann::json::parse(result.out).at("streams").at(0);
    EXPECT_LE(stream.at("maxError").get<double>(), std::stod(bound));
    EXPECT_LE(stream.at("guaranteedError").get<double>(), std::stod(bound));
  }
}

TEST(Pack, MeetsTheRateThatWasAskedFor) {
  const Folder folder;
  const ProgramResult result =
      folder.run("pack " + sample("slug.glb") + " -o packed.glb --quiet --report - --target-bpv 16");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto stream = nlohmann::json::parse(result.out).at("streams").at(0);
  EXPECT_NEAR(stream.at("bitsPerVertex").at("total").get<double>(), 16, 0.5);
}

TEST(Pack, SameInputAndOptionsGiveTheSameBytes) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("tentacle.glb") + " -o a.glb").exit_code, 0);
  ASSERT_EQ(folder.run("pack " + sample("tentacle.glb") + " -o b.glb").exit_code, 0);
  EXPECT_EQ(folder.read("a.glb"), folder.read("b.glb"));
}

TEST(Pack, RefusesPackedInputUnlessToldOtherwise) {
  const Folder folder;
  ASSERT_EQ(folder.run("pack " + sample("soup.gltf") + " -o packed.glb").exit_code, 0);
  const ProgramResult refused = folder.run("pack packed.glb -o twice.glb");
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_TRUE(contains(refused.err, "packed.glb")) << refused.err;
  EXPECT_EQ(folder.list(), std::vector<std::string>{"packed.glb"});
  EXPECT_EQ(folder.run("pack packed.glb -o twice.glb --repack").exit_code, 0);
}

TEST(Pack, AStepTooFineIsSaidAndNothingIsWritten) {
  const Folder folder;
  const ProgramResult result = folder.run("pack " + sample("slug.glb") + " -o packed.glb --step 1e-30");
  EXPECT_TRUE(result.exit_code == 1 || result.exit_code == 3 || result.exit_code == 5) << result.exit_code;
  EXPECT_TRUE(contains(result.err, "slug.glb")) << result.err;
  EXPECT_TRUE(folder.list().empty());
}

TEST(Pack, PackedAgainAtTheSameStepLosesNothing) {
  const Folder folder;
  const std::string options = " --mode lattice --step 0.001 --quiet";
  ASSERT_EQ(folder.run("pack " + sample("slug.glb") + " -o a.glb" + options).exit_code, 0);
  ASSERT_EQ(folder.run("unpack a.glb -o b.glb").exit_code, 0);
  const ProgramResult again = folder.run("pack b.glb -o c.glb --report -" + options);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out).at("streams").at(0).at("maxError"), 0.0);
}

TEST(Pack, NeedsAnOutput) {
  const ProgramResult result = Folder().run("pack " + sample("soup.gltf"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(contains(result.err, "-o")) << result.err;
}

TEST(Pack, StandardOutputCannotTakeAssetAndReport) {
  EXPECT_EQ(Folder().run("pack " + sample("soup.gltf") + " -o - --report -").exit_code, 1);
}

}  // namespace
}  // namespace tsc::cli_test
