// The report's page holds what was measured, in itself.
#include "report_page.h"

#include <gtest/gtest.h>

#include <regex>

namespace tsc::bench {
namespace {

ReportData someData() {
  ReportData data;
  data.provenance = "commit 0123 & flags <O3>";
  data.command = "tsc-bench report folder";
  MeshRate mesh;
  mesh.name = "<mesh>";
  mesh.class_name = "scans";
  mesh.vertices = 100;
  mesh.dropped_vertices = 7;
  mesh.bits = {10, 11};
  mesh.draco7 = mesh.draco10 = {{1000, 100, 1e-4}, {1200, 100, 2.5e-5}};
  VariantRate rate;
  rate.name = "auto";
  rate.curve.resize(2);
  rate.curve[0].bits = 900;
  rate.curve[0].mse = 1e-4;
  rate.curve[1].bits = 1100;
  rate.curve[1].mse = 2.5e-5;
  rate.bd7 = rate.bd10 = -0.1;
  rate.at7 = rate.at10 = {0.5, 0.6, 0.7};
  VariantRate failed;
  failed.name = "max";
  failed.error = "refused <it>";
  mesh.variants = {rate, failed};
  data.rates = data.patches = {mesh};
  MeshSpeed speed{"<mesh>", "scans", 100, 196, {}};
  for (const char* codec : {"draco-cl7", "draco-cl10", "memcpy", "auto"}) {
    speed.codecs.push_back({codec, "", 1000, 2e3, 1e3, 8e3, 4e3});
  }
  data.speeds = {speed};
  data.series = {speed, speed};
  data.series[1].vertices = 1000;
  data.series[1].codecs.pop_back();  // effort max leaves the series early
  data.plane = {{"world space", "", 13, 1e-4, 1e-5, 0.5, 3, 13}, {"tangent", "refused", 0, 0, 0, 0, 0, 0}};
  return data;
}

TEST(ReportPage, isOneFileWithoutTheNetwork) {
  const std::string page = reportPage(someData());
  EXPECT_EQ(page.rfind("<!doctype html>", 0), 0u);
  EXPECT_NE(page.find("</html>"), std::string::npos);
  EXPECT_FALSE(std::regex_search(page, std::regex("(src|href)\\s*=|@import|<script")));
  for (const char* number : {"nan", "inf<", ">inf"}) EXPECT_EQ(page.find(number), std::string::npos) << number;
}

TEST(ReportPage, saysWhatWasMeasuredAndWhatFailed) {
  const std::string page = reportPage(someData());
  for (const char* part :
       {"commit 0123 &amp; flags &lt;O3&gt;", "tsc-bench report folder", "&lt;mesh&gt;", "-10.0%", "0.500",
        "refused &lt;it&gt;", "(1 failed)", "7 of 107", "Small meshes", "memcpy", "Figure 2", "world space"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(page.find("<mesh>"), std::string::npos) << "names are escaped";
}

TEST(ReportPage, closesWhatItOpens) {
  const std::string page = reportPage(someData());
  const auto count = [&page](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1)) ++found;
    return found;
  };
  for (const std::string tag : {"table", "tr", "pre", "details", "svg", "h2", "body"}) {
    EXPECT_EQ(count("<" + tag + ">") + count("<" + tag + " "), count("</" + tag + ">")) << tag;
  }
}

TEST(ReportPage, leavesOutWhatWasNotMeasured) {
  ReportData data = someData();
  data.patches.clear();
  data.speeds.clear();
  data.series.clear();
  data.rates[0].dropped_vertices = 0;
  const std::string page = reportPage(data);
  EXPECT_EQ(page.find("Small meshes"), std::string::npos);
  EXPECT_EQ(page.find("Speed and memory"), std::string::npos);
  EXPECT_NE(page.find("there are none"), std::string::npos);
}

}  // namespace
}  // namespace tsc::bench
