// Plots hold what they are given.
#include "svg.h"

#include <gtest/gtest.h>

namespace tsc::bench {
namespace {

TEST(Svg, escapesText) { EXPECT_EQ(escapeHtml("<a & 'b'>"), "&lt;a &amp; &#39;b&#39;&gt;"); }

TEST(Svg, drawsABoxForEachCodecThatHasValues) {
  const BoxPlot plot{"t", {{"one", ratioSpreadOf({0.5, 0.7, 0.9})}, {"none", {}}}};
  const std::string text = svg(plot);
  EXPECT_NE(text.find("one"), std::string::npos);
  EXPECT_EQ(text.find("<rect"), text.rfind("<rect"));
  EXPECT_EQ(text.find("nan"), std::string::npos);
}

TEST(Svg, leavesOutPointsThatALogarithmicAxisCannotShow) {
  const LinePlot plot{"t", "x", "y", false, {{"l", {1, 2, 3}, {1, 0, 10}}}};
  const std::string text = svg(plot);
  EXPECT_EQ(text.find("inf"), std::string::npos);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_TRUE(svg(LinePlot{"t", "x", "y", false, {}}).empty());
}

}  // namespace
}  // namespace tsc::bench
