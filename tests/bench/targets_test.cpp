// The table of goals picks the right figures.
#include "targets.h"

#include <gtest/gtest.h>

namespace tsc::bench {
namespace {

MeshRate meshRate(const std::string& class_name, double bd10, double dame_normal2) {
  MeshRate mesh;
  mesh.class_name = class_name;
  mesh.name = class_name;
  mesh.vertices = 10;
  mesh.bits = {kReferenceBits};
  mesh.draco7 = mesh.draco10 = {{200, 20, 1}};
  for (const char* name : {"auto", "auto-n2"}) {
    VariantRate& rate = mesh.variants.emplace_back();
    rate.name = name;
    rate.curve.resize(1);
    rate.curve[0].parts.connectivity = 15;
    rate.bd10 = bd10;
    rate.at7.mse = 0.5;
    rate.at10.dame = rate.name == "auto" ? 9 : dame_normal2;
  }
  return mesh;
}

std::string line(const std::string& table, const std::string& start) {
  const auto at = table.find(start);
  return at == std::string::npos ? "" : table.substr(at, table.find('\n', at) - at);
}

TEST(Targets, showsEachFigureInItsRow) {
  EffortResults normal{"auto", "auto-n2", {meshRate("organic", -0.11, 0.45), meshRate("cad", -0.22, 0.9)}, {}, {}};
  const std::string table = targetsTable(normal, {"max", "max-n2", normal.rates, {}, {}});
  EXPECT_NE(line(table, "BD-rate vs cl10, organic").find("-11.0%"), std::string::npos);
  EXPECT_NE(line(table, "BD-rate vs cl10, cad").find("-22.0%"), std::string::npos);
  EXPECT_NE(line(table, "MSE at cl7's rate").find("0.500 / 0.500 (2)"), std::string::npos);
  EXPECT_NE(line(table, "DAME at cl10's rate").find("0.450"), std::string::npos);
  EXPECT_NE(line(table, "connectivity bits over Draco's, cad").find("0.750"), std::string::npos);
  EXPECT_NE(line(table, "decoding speed").find("| - "), std::string::npos) << "nothing was timed";
}

TEST(Targets, ofNothingAreDashes) {
  const std::string table = targetsTable({"auto", "auto-n2", {}, {}, {}}, {"max", "max-n2", {}, {}, {}});
  EXPECT_NE(line(table, "BD-rate vs cl10, organic").find("| - "), std::string::npos);
}

}  // namespace
}  // namespace tsc::bench
