// Plots as SVG text.
#include "svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tsc::bench {

namespace {

// Distinguishable with colour vision deficiencies (Okabe & Ito).
constexpr std::array kColours = {"#000000", "#888888", "#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                 "#e69f00", "#56b4e9", "#7b4fa3", "#8c564b", "#b0a000", "#ff6f91"};

/// A data axis mapped to pixels.
struct Axis {
  double low, high, begin, end;
  bool logarithmic;
  double operator()(double value) const {
    const auto f = [this](double v) { return logarithmic ? std::log10(v) : v; };
    return begin + (f(value) - f(low)) / (f(high) - f(low)) * (end - begin);
  }
  /// Marked values: 1, 2, 5 times powers of ten within the range; on wide logarithmic ranges the powers alone.
  std::vector<double> ticks() const {
    std::vector<double> marks;
    if (logarithmic) {
      const bool wide = high / low > 300;
      for (int e = static_cast<int>(std::floor(std::log10(low))); e <= std::ceil(std::log10(high)); ++e) {
        for (const double m : {1.0, 2.0, 5.0}) {
          const double mark = m * std::pow(10, e);
          if ((!wide || m == 1.0) && mark >= low * 0.999 && mark <= high * 1.001) marks.push_back(mark);
        }
      }
      return marks;
    }
    const double raw = (high - low) / 6, power = std::pow(10, std::floor(std::log10(raw)));
    const double unit = raw / power < 2 ? 2 * power : raw / power < 5 ? 5 * power : 10 * power;
    for (double mark = std::ceil(low / unit) * unit; mark <= high; mark += unit) marks.push_back(mark);
    return marks;
  }
};

std::string text(double x, double y, const std::string& content, const char* anchor = "middle") {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='{}'>{}</text>", x, y, anchor, escapeHtml(content));
}
std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' style='{}'/>", x1, y1, x2, y2, style);
}
std::string open(double width, double height, const std::string& title) {
  return fmt::format("<svg viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' height='{1:.0f}' font-size='11'>", width,
                     height) +
         text(width / 2, 16, title);
}

/// Grid lines and numbers of a y axis.
std::string yGrid(const Axis& y, double left, double right) {
  std::string out;
  for (const double mark : y.ticks()) {
    out += line(left, y(mark), right, y(mark), "stroke:#ddd") +
           text(left - 5, y(mark) + 4, fmt::format("{:g}", mark), "end");
  }
  return out;
}

}  // namespace

std::string escapeHtml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      case '\'': escaped += "&#39;"; break;
      default: escaped += c;
    }
  }
  return escaped;
}

std::string svg(const BoxPlot& plot) {
  constexpr double kBoxWidth = 62, kLeft = 50, kTop = 26, kHeight = 260, kBottom = 60;
  double low = 0.5, high = 2;
  for (const auto& box : plot.boxes) {
    if (box.spread.count == 0) continue;
    low = std::min(low, std::max(box.spread.best, 1e-4) * 0.9);
    high = std::max(high, box.spread.worst * 1.1);
  }
  const double width = kLeft + kBoxWidth * double(plot.boxes.size()) + 15;
  const Axis y{low, high, kTop + kHeight, kTop, true};
  std::string out = open(width, kTop + kHeight + kBottom, plot.title) + yGrid(y, kLeft, width - 15) +
                    line(kLeft, y(1), width - 15, y(1), "stroke:#d55e00;stroke-dasharray:4 3");
  for (std::size_t i = 0; i < plot.boxes.size(); ++i) {
    const Spread& s = plot.boxes[i].spread;
    const double x = kLeft + kBoxWidth * (double(i) + 0.5);
    out += fmt::format("<text transform='translate({:.1f},{:.1f}) rotate(25)'>{}</text>", x - 18, kTop + kHeight + 14,
                       escapeHtml(plot.boxes[i].label));
    if (s.count == 0) continue;
    const auto at = [&](double value) { return y(std::clamp(value, low, high)); };
    out += line(x, at(s.best), x, at(s.worst), "stroke:#333");
    out += line(x - 8, at(s.best), x + 8, at(s.best), "stroke:#333") +
           line(x - 8, at(s.worst), x + 8, at(s.worst), "stroke:#333");
    out += fmt::format("<rect x='{:.1f}' y='{:.1f}' width='30' height='{:.1f}' fill='#9ecae1' stroke='#333'/>", x - 15,
                       at(s.high_quartile), std::max(0.5, at(s.low_quartile) - at(s.high_quartile)));
    out += line(x - 15, at(s.median), x + 15, at(s.median), "stroke:#000;stroke-width:2");
    out += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='#d55e00'/>", x, at(s.mean));
    out += text(x, at(s.median) - 4, fmt::format("{:.2f}", s.median));
  }
  return out + "</svg>\n";
}

std::string svg(const LinePlot& plot) {
  constexpr double kWidth = 560, kHeight = 300, kLeft = 62, kTop = 44, kRight = 150, kBottom = 44;
  double x_low = 1e300, x_high = -1e300, y_low = 1e300, y_high = -1e300;
  for (const auto& l : plot.lines) {
    for (std::size_t i = 0; i < l.x.size(); ++i) {
      if (!(l.y[i] > 0)) continue;
      x_low = std::min(x_low, l.x[i]);
      x_high = std::max(x_high, l.x[i]);
      y_low = std::min(y_low, l.y[i]);
      y_high = std::max(y_high, l.y[i]);
    }
  }
  if (!(x_high > x_low)) return {};
  if (!(y_high > y_low)) y_high = y_low * 2;
  const Axis x{x_low, x_high, kLeft, kLeft + kWidth, plot.log_x};
  const Axis y{y_low / 1.15, y_high * 1.15, kTop + kHeight, kTop, true};
  std::string out =
      open(kLeft + kWidth + kRight, kTop + kHeight + kBottom, plot.title) + yGrid(y, kLeft, kLeft + kWidth);
  for (const double mark : x.ticks()) {
    out += line(x(mark), kTop, x(mark), kTop + kHeight, "stroke:#eee") +
           text(x(mark), kTop + kHeight + 15, fmt::format("{:g}", mark));
  }
  out += text(kLeft + kWidth / 2, kTop + kHeight + 34, plot.x_label) + text(4, kTop - 8, plot.y_label, "start");
  for (std::size_t k = 0; k < plot.lines.size(); ++k) {
    const auto& l = plot.lines[k];
    const char* colour = kColours[k % kColours.size()];
    const char* dashes = k < kColours.size() ? "none" : "5 3";
    std::string points;
    for (std::size_t i = 0; i < l.x.size(); ++i) {
      if (!(l.y[i] > 0)) continue;
      points += fmt::format("{:.1f},{:.1f} ", x(l.x[i]), y(l.y[i]));
      out += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2' fill='{}'/>", x(l.x[i]), y(l.y[i]), colour);
    }
    out += fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='1.5' stroke-dasharray='{}'/>",
                       points, colour, dashes);
    const double row = kTop + 10 + 15 * double(k), column = kLeft + kWidth + 10;
    out += line(column, row - 4, column + 18, row - 4,
                fmt::format("stroke:{};stroke-width:2;stroke-dasharray:{}", colour, dashes)) +
           text(column + 23, row, l.label, "start");
  }
  return out + "</svg>\n";
}

}  // namespace tsc::bench
