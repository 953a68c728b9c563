// Both meshes side by side in a PNG: A shaded, B in error colours, with a scale bar. Seen from an oblique, parallel
// projection fitted to A; drawn at twice the size and reduced, which smooths the edges.
#include <array>
#include <cmath>

// The implementations live here alone, as static functions.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wsign-compare"
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_easy_font.h>
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include <glm/geometric.hpp>

#include "colour_scale.h"
#include "file_bytes.h"
#include "raster.h"
#include "surface_tools.h"

namespace tsc {

void Raster::rectangle(int left, int top, int right, int bottom, const glm::dvec3& colour) {
  for (int y = std::max(0, top); y < std::min(height_, bottom); ++y) {
    for (int x = std::max(0, left); x < std::min(width_, right); ++x) {
      colours_[static_cast<std::size_t>(y) * width_ + x] = colour;
    }
  }
}

void Raster::text(int x, int y, int scale, const std::string& line, const glm::dvec3& colour) {
  struct Corner {
    float x, y, z;
    unsigned char colour[4];
  };
  // 270 bytes a character are said to suffice.
  std::vector<Corner> corners(line.size() * 300 / sizeof(Corner) + 64);
  std::string copy = line;
  const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Corner)));
  for (int q = 0; q < quads; ++q) {
    const Corner &low = corners[4 * q], &high = corners[4 * q + 2];
    rectangle(x + static_cast<int>(low.x * scale), y + static_cast<int>(low.y * scale),
              x + static_cast<int>(high.x * scale), y + static_cast<int>(high.y * scale), colour);
  }
}

int Raster::textWidth(const std::string& line, int scale) {
  std::string copy = line;
  return stb_easy_font_width(copy.data()) * scale;
}

std::vector<std::uint8_t> Raster::pixels(int factor) const {
  std::vector<std::uint8_t> bytes;
  for (int y = 0; y + factor <= height_; y += factor) {
    for (int x = 0; x + factor <= width_; x += factor) {
      glm::dvec3 sum(0);
      for (int k = 0; k < factor * factor; ++k) {
        sum += colours_[static_cast<std::size_t>(y + k / factor) * width_ + x + k % factor];
      }
      sum /= factor * factor;
      for (int k = 0; k < 3; ++k) bytes.push_back(static_cast<std::uint8_t>(std::lround(255 * sum[k])));
    }
  }
  return bytes;
}

namespace {

constexpr int kSmoothing = 2;
constexpr int kWidth = 1600 * kSmoothing, kHeight = 900 * kSmoothing;
constexpr int kMargin = 40 * kSmoothing, kTitleHeight = 70 * kSmoothing, kLegendHeight = 120 * kSmoothing;
constexpr int kTextScale = 2 * kSmoothing;
const glm::dvec3 kBackground(1), kInk(0.13), kNeutral(0.72, 0.74, 0.78);

constexpr std::array<double, 16> kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

glm::dvec3 placed(const std::array<double, 16>& m, const glm::dvec3& p) {
  return {m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
          m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]};
}

/// Calls `visit(mesh, matrix)` for every instance; a mesh that stands nowhere is shown once, as it is.
template <class Visit>
void forEachInstance(std::span<const NamedSurface> meshes, Visit visit) {
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    if (meshes[i].placements.empty()) visit(i, kIdentity);
    for (const auto& matrix : meshes[i].placements) visit(i, matrix);
  }
}

/// Parallel projection along a fixed oblique direction, y up, into a panel of the picture.
class Camera {
 public:
  explicit Camera(std::span<const NamedSurface> meshes) {
    forEachInstance(meshes, [&](std::size_t i, const std::array<double, 16>& matrix) {
      const PositionView positions(meshes[i].positions);
      for (const std::uint32_t index : meshes[i].indices) {
        const glm::dvec3 seen = toView(placed(matrix, pointAt(positions, index)));
        if (std::isfinite(seen.x + seen.y + seen.z)) extent_.add(seen);
      }
    });
  }

  [[nodiscard]] glm::dvec3 toView(const glm::dvec3& p) const {
    return {glm::dot(p, right_), glm::dot(p, up_), glm::dot(p, towards_)};
  }

  /// Pixels of a panel from `left`, `width` wide.
  [[nodiscard]] glm::dvec3 toPixels(const glm::dvec3& seen, int left, int width) const {
    const int height = kHeight - kTitleHeight - kLegendHeight;
    const glm::dvec3 size = extent_.high - extent_.low, centre = (extent_.low + extent_.high) / 2.0;
    const double fit = std::min((width - 2.0 * kMargin) / std::max(size.x, 1e-300),
                                (height - 2.0 * kMargin) / std::max(size.y, 1e-300));
    return {left + width / 2.0 + (seen.x - centre.x) * fit, kTitleHeight + height / 2.0 - (seen.y - centre.y) * fit,
            (seen.z - centre.z) * fit};
  }

 private:
  glm::dvec3 towards_ = glm::normalize(glm::dvec3(0.55, 0.4, 1));
  glm::dvec3 right_ = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), towards_));
  glm::dvec3 up_ = glm::cross(towards_, right_);
  Box extent_;
};

/// `colour(mesh, vertex indices, u, v, w)`: the surface's own colour at a pixel, before shading.
template <class Colour>
void drawMeshes(Raster& raster, const Camera& camera, std::span<const NamedSurface> meshes, int left, Colour colour) {
  raster.setColumns(left, left + kWidth / 2);
  forEachInstance(meshes, [&](std::size_t i, const std::array<double, 16>& matrix) {
    const PositionView positions(meshes[i].positions);
    for (std::size_t t = 0; t + 2 < meshes[i].indices.size(); t += 3) {
      const std::uint32_t* corner = &meshes[i].indices[t];
      std::array<glm::dvec3, 3> seen, pixel;
      for (int k = 0; k < 3; ++k) {
        seen[k] = camera.toView(placed(matrix, pointAt(positions, corner[k])));
        pixel[k] = camera.toPixels(seen[k], left, kWidth / 2);
      }
      const glm::dvec3 normal = glm::cross(seen[1] - seen[0], seen[2] - seen[0]);
      const double length = glm::length(normal);
      if (!(length > 0)) continue;
      // Light from the upper left; both sides are lit, since winding is not always right.
      static const glm::dvec3 light = glm::normalize(glm::dvec3(-0.4, 0.5, 1));
      const double facing = (normal.z < 0 ? -1 : 1) * glm::dot(normal, light) / length;
      const double shade = 0.35 + 0.65 * std::max(0.0, facing);
      raster.triangle(pixel[0], pixel[1], pixel[2],
                      [&](double u, double v, double w) { return shade * colour(i, corner, u, v, w); });
    }
  });
}

void centredText(Raster& raster, int centre, int y, const std::string& line) {
  raster.text(centre - Raster::textWidth(line, kTextScale) / 2, y, kTextScale, line, kInk);
}

void drawLegend(Raster& raster, const ColourScale& scale, const Comparison& comparison) {
  const int left = kWidth / 5, right = kWidth - kWidth / 5;
  const int top = kHeight - kLegendHeight + 8 * kSmoothing, bottom = top + 24 * kSmoothing;
  for (int x = left; x < right; ++x) {
    raster.rectangle(x, top, x + 1, bottom, turbo(scale.top > 0 ? (x - left + 0.5) / (right - left) : 0));
  }
  constexpr int kTicks = 4;
  for (int tick = 0; tick <= kTicks; ++tick) {
    const int x = left + (right - left) * tick / kTicks;
    raster.rectangle(x - kSmoothing / 2, bottom, x + kSmoothing, bottom + 6 * kSmoothing, kInk);
    const bool cut = tick == kTicks && scale.top < scale.largest;
    centredText(raster, x, bottom + 10 * kSmoothing, (cut ? ">= " : "") + shortNumber(scale.top * tick / kTicks));
    if (scale.top == 0) break;
  }
  const MeshComparison& total = comparison.total;
  std::string line = measureName(comparison) + ", largest " + withShare(scale.largest, total.diagonal) + "   ";
  if (total.vertices) line += "RMS " + shortNumber(total.vertices->rms) + "   ";
  line += "Metro RMS " + shortNumber(total.metro.rms()) + "   Hausdorff " + shortNumber(total.metro.hausdorff());
  if (total.dame && total.dame->edges > 0) line += "   DAME " + shortNumber(total.dame->value);
  centredText(raster, kWidth / 2, bottom + 42 * kSmoothing, line);
}

std::string countsOf(const char* side, std::uint64_t vertices, std::uint64_t triangles) {
  return std::string(side) + ": " + std::to_string(vertices) + " vertices, " + std::to_string(triangles) + " triangles";
}

}  // namespace

std::optional<QualityError> writeHeatmapPng(const std::filesystem::path& path, std::span<const NamedSurface> a,
                                            std::span<const NamedSurface> b, const Comparison& comparison) {
  const auto fields = errorFields(a, b, comparison);
  if (!fields) return fields.error();
  const ColourScale scale(*fields);
  const Camera camera(a);
  Raster raster(kWidth, kHeight, kBackground);
  drawMeshes(raster, camera, a, 0, [](std::size_t, const std::uint32_t*, double, double, double) { return kNeutral; });
  drawMeshes(raster, camera, b, kWidth / 2,
             [&](std::size_t mesh, const std::uint32_t* corner, double u, double v, double w) {
               const auto& field = (*fields)[mesh];
               return turbo(scale.share(u * field[corner[0]] + v * field[corner[1]] + w * field[corner[2]]));
             });
  const MeshComparison& total = comparison.total;
  raster.rectangle(0, 0, kWidth, kTitleHeight, kBackground);
  raster.rectangle(0, kHeight - kLegendHeight, kWidth, kHeight, kBackground);
  centredText(raster, kWidth / 4, 28 * kSmoothing, countsOf("A", total.vertices_a, total.triangles_a));
  centredText(raster, 3 * kWidth / 4, 28 * kSmoothing, countsOf("B", total.vertices_b, total.triangles_b));
  drawLegend(raster, scale, comparison);

  std::string png;
  const std::vector<std::uint8_t> pixels = raster.pixels(kSmoothing);
  const int done = stbi_write_png_to_func(
      [](void* target, void* data, int size) {
        static_cast<std::string*>(target)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
      },
      &png, kWidth / kSmoothing, kHeight / kSmoothing, 3, pixels.data(), 3 * kWidth / kSmoothing);
  if (done == 0) return QualityError{QualityErrorCode::kUnreadableFile, path.string() + ": the PNG cannot be made"};
  return writeFileBytes(path, png);
}

}  // namespace tsc
