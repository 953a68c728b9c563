#include "json_document.h"

#include <gtest/gtest.h>

#include "fault.h"

namespace tsc::test {
namespace {

TEST(JsonDocument, NumbersKeepTheirValue) {
  const std::string text =
      R"({"a":18446744073709551615,"b":-9223372036854775808,"c":123456789012345678901234567890,"d":0.1,"e":1e-320,)"
      R"("f":6378137.000123457,"g":-1e+300,"h":1.0,"i":[],"j":{},"k":"\u0000é"})";
  EXPECT_EQ(writeJson(parseJson(text, 512)), text);
}

TEST(JsonDocument, FaultsNameThePlace) {
  const auto message = [](std::string_view text, std::uint32_t depth = 8) -> std::string {
    try {
      parseJson(text, depth);
    } catch (const Fault& fault) {
      return fault.what();
    }
    return "no fault";
  };
  EXPECT_NE(message("{\"a\":}").find("JSON byte 6"), std::string::npos) << message("{\"a\":}");
  EXPECT_NE(message("{\"a\":1,\"a\":2}").find("twice"), std::string::npos);
  EXPECT_NE(message("[1]").find("expected an object"), std::string::npos);
  EXPECT_NE(message("{\"a\":[[[[[[[[[[1]]]]]]]]]]}").find("deeper than 8"), std::string::npos);
  EXPECT_NE(message("{} x").find("JSON byte"), std::string::npos);
  EXPECT_NE(message(std::string(100000, '[')).find("deeper"), std::string::npos);
}

TEST(JsonDocument, ViewsCheckTypes) {
  const Json document = parseJson(R"({"n":3,"f":4.0,"neg":-1,"s":"x","list":[{"b":true}]})", 512);
  const JsonView root(document);
  EXPECT_EQ(root["n"].asUint(), 3U);
  EXPECT_EQ(root["f"].asUint(), 4U);
  EXPECT_THROW(root["neg"].asUint(), Fault);
  EXPECT_THROW(root["n"].asUint(2), Fault);
  EXPECT_THROW(root["s"].asUint(), Fault);
  EXPECT_THROW(root["missing"], Fault);
  EXPECT_TRUE(root["list"].at(0)["b"].asBool());
  EXPECT_EQ(root["list"].at(0)["b"].pointer(), "/list/0/b");
  EXPECT_THROW(root["list"].at(1), Fault);
}

TEST(JsonDocument, ExtensionsAreDeclaredOnce) {
  Json document = Json::object();
  declareExtension(document, "A", true);
  declareExtension(document, "A", true);
  EXPECT_EQ(writeJson(document), R"({"extensionsUsed":["A"],"extensionsRequired":["A"]})");
  undeclareExtension(document, "A");
  EXPECT_EQ(writeJson(document), "{}");
}

}  // namespace
}  // namespace tsc::test
