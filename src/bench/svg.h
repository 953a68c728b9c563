// Plots as SVG text, to stand inside an HTML page.
#pragma once

#include <string>
#include <vector>

#include "curve.h"

namespace tsc::bench {

/// Five-number summaries side by side on a logarithmic axis, with a line at 1: the paper's Figure 3.
struct BoxPlot {
  struct Box {
    std::string label;
    Spread spread;  ///< values above 0; nothing is drawn for a count of 0
  };
  std::string title;
  std::vector<Box> boxes;
};
std::string svg(const BoxPlot& plot);

/// Curves over a linear or logarithmic x axis; the y axis is logarithmic.
struct LinePlot {
  struct Line {
    std::string label;
    std::vector<double> x, y;
  };
  std::string title, x_label, y_label;
  bool log_x = false;
  std::vector<Line> lines;
};
std::string svg(const LinePlot& plot);

/// Text with the characters that HTML gives meaning to replaced.
std::string escapeHtml(const std::string& text);

}  // namespace tsc::bench
