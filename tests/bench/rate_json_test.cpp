// What an interrupted report remembers is what it measured.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rate.h"

namespace tsc::bench {
namespace {

MeshRate someRate() {
  MeshRate mesh;
  mesh.name = "a";
  mesh.class_name = "c";
  mesh.vertices = 100;
  mesh.faces = 196;
  mesh.dropped_vertices = 3;
  mesh.bits = {10, 11};
  mesh.draco7 = {{1000, 100, 1e-4}, {1200, 100, 1.0 / 3}};
  mesh.draco10 = {{900, 100, 1e-4}, {1100, 100, 2.5e-5}};
  mesh.reference7 = mesh.draco7[1];
  mesh.reference10 = mesh.draco10[1];
  VariantRate good;
  good.name = "auto";
  CodecPoint point;
  point.step = 0.1;
  point.bits = 800;
  point.mse = 1e-300;
  point.parts = {1, 2, 3, 4, 5, 6};
  point.modes.mode = Mode::kTangent;
  point.modes.basis = Basis::kTip;
  point.modes.predictor = Predictor::kAdaptive;
  point.modes.order = Order::kDegree;
  point.modes.effort = Effort::kMax;
  point.modes.normal_scale = 2;
  point.modes.step = 0.1;
  good.curve = {point, point};
  good.bd10 = -0.125;
  good.at7 = {0.5, std::nullopt, 0.25};
  VariantRate bad;
  bad.name = "max";
  bad.error = "a \"quoted\" reason";
  mesh.variants = {good, bad};
  return mesh;
}

TEST(RateJson, comesBackAsItWas) {
  const MeshRate mesh = someRate();
  const nlohmann::json json = mesh;
  const auto back = nlohmann::json::parse(json.dump()).get<MeshRate>();
  EXPECT_EQ(nlohmann::json(back), json);

  EXPECT_EQ(back.name, "a");
  EXPECT_EQ(back.class_name, "c");
  EXPECT_EQ(back.dropped_vertices, 3u);
  EXPECT_EQ(back.bits, mesh.bits);
  EXPECT_EQ(back.draco7[1].mse, mesh.draco7[1].mse);
  EXPECT_EQ(back.reference10.bits, mesh.reference10.bits);
  ASSERT_EQ(back.variants.size(), 2u);
  const VariantRate& good = back.variants[0];
  EXPECT_EQ(good.curve[1].mse, 1e-300);
  EXPECT_EQ(good.curve[1].parts.side_faces, 6);
  EXPECT_EQ(good.curve[1].modes.basis, Basis::kTip);
  EXPECT_EQ(good.curve[1].modes.order, Order::kDegree);
  EXPECT_EQ(good.curve[1].modes.normal_scale, 2u);
  EXPECT_FALSE(good.bd7);
  EXPECT_EQ(good.bd10, -0.125);
  EXPECT_EQ(good.at7.mse, 0.5);
  EXPECT_FALSE(good.at7.metro);
  EXPECT_EQ(back.variants[1].error, mesh.variants[1].error);
}

TEST(RateJson, tablesAndCsvAreTheSameBeforeAndAfter) {
  const std::vector<MeshRate> before = {someRate()};
  const std::vector<MeshRate> after = {nlohmann::json(before[0]).get<MeshRate>()};
  EXPECT_EQ(rateLines(before[0]), rateLines(after[0]));
  EXPECT_EQ(pointsCsv(before), pointsCsv(after));
  EXPECT_EQ(ratiosCsv(before), ratiosCsv(after));
  EXPECT_EQ(summaryTable(summarize(before)), summaryTable(summarize(after)));
}

TEST(RateJson, refusesWhatLacksAField) {
  nlohmann::json json = someRate();
  json.erase("draco7");
  json.erase("vertices");
  EXPECT_ANY_THROW(json.get<MeshRate>());
}

}  // namespace
}  // namespace tsc::bench
