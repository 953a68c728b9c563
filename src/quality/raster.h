// A small picture with a depth buffer: flat-shaded triangles seen along an axis, rectangles and text.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <string>
#include <vector>

namespace tsc {

class Raster {
 public:
  Raster(int width, int height, const glm::dvec3& background)
      : width_(width),
        height_(height),
        right_(width),
        colours_(static_cast<std::size_t>(width) * height, background),
        depths_(colours_.size(), -std::numeric_limits<double>::infinity()) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// From now on triangles are drawn in columns `left` to `right` - 1 alone.
  void setColumns(int left, int right) { left_ = left, right_ = right; }

  /// Corners in pixels, z towards the viewer. `colour(u, v, w)` gets barycentric coordinates of each visible pixel.
  template <class Colour>
  void triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, Colour colour);

  void rectangle(int left, int top, int right, int bottom, const glm::dvec3& colour);

  /// ASCII, `scale` pixels a dot of the font; (x, y) is the upper left corner.
  void text(int x, int y, int scale, const std::string& line, const glm::dvec3& colour);
  [[nodiscard]] static int textWidth(const std::string& line, int scale);

  /// RGB bytes of the picture reduced by whole `factor`.
  [[nodiscard]] std::vector<std::uint8_t> pixels(int factor) const;

 private:
  int width_, height_;
  int left_ = 0, right_;
  std::vector<glm::dvec3> colours_;
  std::vector<double> depths_;
};

template <class Colour>
void Raster::triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, Colour colour) {
  const auto cross = [](const glm::dvec3& o, const glm::dvec3& p, double x, double y) {
    return (p.x - o.x) * (y - o.y) - (p.y - o.y) * (x - o.x);
  };
  const double area = cross(a, b, c.x, c.y);
  if (area == 0 || !std::isfinite(area)) return;
  const auto [x_low, x_high] = std::minmax({a.x, b.x, c.x});
  const auto [y_low, y_high] = std::minmax({a.y, b.y, c.y});
  const auto within = [](double value, int low, int high) {
    return static_cast<int>(std::clamp<double>(value, low, high));
  };
  const int x_begin = within(std::floor(x_low), left_, right_), x_end = within(std::ceil(x_high), left_, right_);
  const int y_begin = within(std::floor(y_low), 0, height_), y_end = within(std::ceil(y_high), 0, height_);
  for (int y = y_begin; y < y_end; ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double u = cross(b, c, px, py) / area, v = cross(c, a, px, py) / area, w = 1 - u - v;
      if (u < 0 || v < 0 || w < 0) continue;
      const std::size_t pixel = static_cast<std::size_t>(y) * width_ + x;
      const double depth = u * a.z + v * b.z + w * c.z;
      if (depth <= depths_[pixel]) continue;
      depths_[pixel] = depth;
      colours_[pixel] = colour(u, v, w);
    }
  }
}

}  // namespace tsc
