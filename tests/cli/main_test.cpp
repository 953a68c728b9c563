// The program as a whole: help, version, wrong verbs.
#include <gtest/gtest.h>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

TEST(Main, HelpNamesEveryVerbAndGoesToStandardOutput) {
  const Folder folder;
  const ProgramResult result = folder.run("--help");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  for (const char* verb : {"pack", "unpack", "inspect"}) EXPECT_TRUE(contains(result.out, verb)) << result.out;
  for (const char* verb : {"pack", "unpack", "inspect"}) {
    EXPECT_EQ(folder.run(std::string(verb) + " --help").exit_code, 0);
  }
}

TEST(Main, VersionIsOneLine) {
  const ProgramResult result = Folder().run("--version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(result.out.starts_with("gltf-tsc ")) << result.out;
}

TEST(Main, NothingOrAnUnknownVerbIsAUsageFault) {
  const Folder folder;
  for (const char* arguments : {"", "compress x.glb", "--nonsense"}) {
    const ProgramResult result = folder.run(arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_EQ(result.out, "");
    EXPECT_TRUE(result.err.starts_with("gltf-tsc: ")) << result.err;
  }
}

}  // namespace
}  // namespace tsc::cli_test
