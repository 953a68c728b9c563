// Error as colour, the same in every picture: which range is shown, which colour a value has, what the legend says.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "tsc/quality.h"

namespace tsc {

/// From 0 to `top`. Where a few outliers would leave the rest in one colour, `top` is the 99.5th percentile.
struct ColourScale {
  double top = 0;
  double largest = 0;

  explicit ColourScale(const std::vector<std::vector<double>>& fields) {
    std::vector<double> values;
    for (const auto& field : fields) {
      std::copy_if(field.begin(), field.end(), std::back_inserter(values), [](double v) { return std::isfinite(v); });
    }
    if (values.empty()) return;
    const auto rank = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * 0.995);
    std::nth_element(values.begin(), rank, values.end());
    largest = *std::max_element(rank, values.end());
    top = largest > 3 * *rank && *rank > 0 ? *rank : largest;
  }

  /// 0..1 along the scale; anything without a value is 0.
  [[nodiscard]] double share(double value) const {
    return top > 0 && std::isfinite(value) ? std::clamp(value / top, 0.0, 1.0) : 0.0;
  }
};

/// sRGB, dark blue over green to dark red: the polynomial fit of "Turbo" (A. Mikhailov, Google, 2019).
inline glm::dvec3 turbo(double t) {
  const double t2 = t * t, t3 = t2 * t, t4 = t3 * t, t5 = t4 * t;
  return glm::clamp(
      glm::dvec3(
          0.13572138 + 4.61539260 * t - 42.66032258 * t2 + 132.13108234 * t3 - 152.94239396 * t4 + 59.28637943 * t5,
          0.09140261 + 2.19418839 * t + 4.84296658 * t2 - 14.18503333 * t3 + 4.27729857 * t4 + 2.82956604 * t5,
          0.10667330 + 12.64194608 * t - 60.58204836 * t2 + 110.36276771 * t3 - 89.90310912 * t4 + 27.34824973 * t5),
      0.0, 1.0);
}

inline std::string shortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// "0.0123 (0.05% of diagonal)"
inline std::string withShare(double value, double diagonal) {
  if (!(diagonal > 0)) return shortNumber(value);
  return shortNumber(value) + " (" + shortNumber(100 * value / diagonal) + "% of diagonal)";
}

/// What the colours stand for; per mesh where only some have matching vertices.
inline std::string measureName(const Comparison& comparison) {
  const auto matched = std::count_if(comparison.meshes.begin(), comparison.meshes.end(),
                                     [](const auto& mesh) { return mesh.correspondence.has_value(); });
  if (matched == 0) return "distance to surface";
  return static_cast<std::size_t>(matched) == comparison.meshes.size() ? "vertex error" : "vertex or surface error";
}

/// The error field of each mesh of B.
inline Measured<std::vector<std::vector<double>>> errorFields(std::span<const NamedSurface> a,
                                                              std::span<const NamedSurface> b,
                                                              const Comparison& comparison) {
  if (a.size() != b.size() || a.size() != comparison.meshes.size()) {
    return QualityError{QualityErrorCode::kCountMismatch, "the comparison is not of these meshes"};
  }
  std::vector<std::vector<double>> fields;
  for (std::size_t i = 0; i < a.size(); ++i) {
    auto field = vertexErrorField(a[i], b[i], comparison.meshes[i]);
    if (!field) return field.error();
    fields.push_back(*std::move(field));
  }
  return fields;
}

}  // namespace tsc
