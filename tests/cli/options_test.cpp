// Options: each is taken, wrong ones are refused with a message that names them, and nothing is written.
#include <gtest/gtest.h>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

struct WrongOption {
  const char* arguments;
  const char* named;  ///< must stand in the message
};

class WrongOptions : public testing::TestWithParam<WrongOption> {};

TEST_P(WrongOptions, EndWithUsageAndAMessage) {
  const Folder folder;
  const ProgramResult result = folder.run("pack " + sample("soup.gltf") + " -o out.glb " + GetParam().arguments);
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_TRUE(contains(result.err, GetParam().named)) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(folder.list().empty());
}

INSTANTIATE_TEST_SUITE_P(
    Pack, WrongOptions,
    testing::Values(WrongOption{"--position-bits 0", "position-bits"},
                    WrongOption{"--position-bits 25", "position-bits"}, WrongOption{"--position-bits twelve", "twelve"},
                    WrongOption{"--step 0", "step"}, WrongOption{"--step -1", "-1"}, WrongOption{"--step nan", "nan"},
                    WrongOption{"--step inf", "inf"}, WrongOption{"--max-error -0.5", "max-error"},
                    WrongOption{"--relative-error 0", "relative-error"}, WrongOption{"--target-bpv x", "target-bpv"},
                    WrongOption{"--step 0.1 --position-bits 12", "excludes"},
                    WrongOption{"--max-error 0.1 --relative-error 0.1", "excludes"},
                    WrongOption{"--normal-scale 0", "normal-scale"}, WrongOption{"--normal-scale 17", "normal-scale"},
                    WrongOption{"--mode sideways", "sideways"}, WrongOption{"--basis top", "gate"},
                    WrongOption{"--predictor best", "weighted"}, WrongOption{"--order random", "traversal"},
                    WrongOption{"--effort huge", "huge"}, WrongOption{"--quiet --verbose", "excludes"},
                    WrongOption{"--colour", "--colour"}, WrongOption{"second.glb", "second.glb"}));

TEST(Options, EveryChoiceIsTaken) {
  for (const char* arguments : {"--position-bits 1",
                                "--position-bits 16",
                                "--step 0.01",
                                "--max-error 0.001",
                                "--relative-error 0.0005",
                                "--target-bpv 40",
                                "--mode tangent",
                                "--mode lattice",
                                "--mode auto",
                                "--basis gate --mode tangent",
                                "--basis tip --mode tangent --normal-scale 2",
                                "--predictor parallelogram",
                                "--predictor weighted",
                                "--predictor valence",
                                "--predictor average",
                                "--predictor adaptive",
                                "--order traversal",
                                "--order degree",
                                "--effort max",
                                "--fallback",
                                "--verbose",
                                "--mode tangent --predictor weighted --basis tip --order traversal --normal-scale 2"}) {
    const Folder folder;
    const ProgramResult packed = folder.run("pack " + sample("plane-17.5.glb") + " -o packed.glb " + arguments);
    EXPECT_EQ(packed.exit_code, 0) << arguments << "\n" << packed.err;
    const ProgramResult unpacked = folder.run("unpack packed.glb -o plain.glb");
    EXPECT_EQ(unpacked.exit_code, 0) << arguments << "\n" << unpacked.err;
  }
}

TEST(Options, ForcedModesAreThoseOfTheStream) {
  const Folder folder;
  const ProgramResult packed =
      folder.run("pack " + sample("plane-17.5.glb") +
                 " -o packed.glb --mode tangent --predictor weighted --basis tip --order traversal --normal-scale 2");
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const auto modes = nlohmann::json::parse(folder.run("inspect packed.glb --json").out).at("streams").at(0).at("modes");
  EXPECT_EQ(modes.at("mode"), "tangent");
  EXPECT_EQ(modes.at("predictor"), "weighted");
  EXPECT_EQ(modes.at("basis"), "tip");
  EXPECT_EQ(modes.at("order"), "traversal");
  EXPECT_EQ(modes.at("normalScale"), 2);
}

}  // namespace
}  // namespace tsc::cli_test
