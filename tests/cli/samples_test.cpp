// Every committed sample packs and unpacks, to .glb and to .gltf, and the Khronos validator is content.
#include <gtest/gtest.h>

#include <cctype>

#include "run_program.h"

namespace tsc::cli_test {
namespace {

class Samples : public testing::TestWithParam<std::string> {};

/// Counts of the accessors, component types and primitives: what packing must not change.
std::vector<std::string> accessorShapes(const nlohmann::json& document) {
  std::vector<std::string> shapes;
  for (const auto& mesh : document.at("meshes")) {
    for (const auto& primitive : mesh.at("primitives")) {
      const auto add = [&](const std::string& name, const nlohmann::json& index) {
        const auto& accessor = document.at("accessors").at(index.get<std::size_t>());
        shapes.push_back(name + " " + accessor.at("type").get<std::string>() + " " +
                         accessor.at("componentType").dump() + " " + accessor.at("count").dump());
      };
      for (const auto& [name, index] : primitive.at("attributes").items()) add(name, index);
      if (primitive.contains("indices")) add("indices", primitive["indices"]);
    }
  }
  return shapes;
}

TEST_P(Samples, PackAndUnpack) {
  const Folder folder;
  for (const char* format : {"glb", "gltf"}) {
    const std::string packed = std::string("packed.") + format, plain = std::string("plain.") + format;
    const ProgramResult pack = folder.run("pack " + sample(GetParam()) + " -o " + packed + " --report -");
    ASSERT_EQ(pack.exit_code, 0) << pack.err;
    const auto report = nlohmann::json::parse(pack.out);
    EXPECT_LT(report.at("outputBytes"), report.at("inputBytes"));
    for (const auto& stream : report.at("streams")) {
      EXPECT_LE(stream.at("maxError"), stream.at("guaranteedError"));
      // 14 bits over the largest extent; the diagonal is at least as long.
      EXPECT_LE(stream.at("maxError").get<double>(), stream.at("diagonal").get<double>() / 16383);
    }
    const ProgramResult unpack = folder.run("unpack " + packed + " -o " + plain);
    ASSERT_EQ(unpack.exit_code, 0) << unpack.err;
    EXPECT_EQ(accessorShapes(document(readFile(sample(GetParam())))), accessorShapes(document(folder.read(plain))));
  }
}

INSTANTIATE_TEST_SUITE_P(All, Samples, testing::ValuesIn(sampleNames()), [](const auto& info) {
  std::string name = info.param;
  for (char& letter : name) letter = std::isalnum(static_cast<unsigned char>(letter)) != 0 ? letter : '_';
  return name;
});

TEST(Validator, FindsNoFaultInSamplesPackedOrUnpacked) {
  const std::string validator = GLTF_TSC_VALIDATOR;
  if (!std::filesystem::exists(validator + "/node_modules/gltf-validator")) {
    GTEST_SKIP() << "the validator is not installed: npm install --prefix " << validator;
  }
  const Folder folder;
  for (const std::string& name : sampleNames()) {
    const ProgramResult valid = folder.shell("node '" + validator + "/validate.mjs' " + sample(name));
    EXPECT_EQ(valid.exit_code, 0) << valid.err;
    for (const std::string format : {"glb", "gltf"}) {
      for (const std::string options : {"", "--fallback"}) {
        ASSERT_EQ(folder.run("pack " + sample(name) + " --force -o packed." + format + " " + options).exit_code, 0);
        ASSERT_EQ(folder.run("unpack packed." + format + " --force -o plain." + format).exit_code, 0);
        for (const std::string kind : {"packed.", "plain."}) {
          const ProgramResult result =
              folder.shell("node '" + validator + "/validate.mjs' --no-worse " + sample(name) + " " + kind + format);
          EXPECT_EQ(result.exit_code, 0) << name << " " << options << " " << kind << format << "\n" << result.err;
        }
      }
    }
  }
}

}  // namespace
}  // namespace tsc::cli_test
