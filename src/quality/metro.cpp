// Point-to-surface distances between two surfaces, sampled.
// Source: P. Cignoni, C. Rocchini, R. Scopigno, "Metro: measuring error on simplified surfaces", Computer Graphics
// Forum 17(2), 1998. Samples are spread over the area by a fixed low-discrepancy sequence instead of at random.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "closest_points.h"
#include "surface_tools.h"

namespace tsc {
namespace {

double triangleArea(const ClosestPoints& surface, std::size_t triangle) {
  const std::uint32_t* corner = &surface.indices()[3 * triangle];
  const glm::dvec3& origin = surface.positions()[corner[0]];
  return glm::length(glm::cross(surface.positions()[corner[1]] - origin, surface.positions()[corner[2]] - origin)) / 2;
}

double surfaceArea(const ClosestPoints& surface) {
  double area = 0;
  for (std::size_t t = 0; t < surface.indices().size() / 3; ++t) area += triangleArea(surface, t);
  return area;
}

/// `count` points, evenly by area in the order of the triangles, so that neighbours in the list are near each other.
std::vector<glm::dvec3> samplePoints(const ClosestPoints& surface, double area, std::uint64_t count,
                                     std::uint32_t seed) {
  // The additive recurrence R2 on the plastic number; both shifts come from the seed.
  constexpr double kStepU = 0.7548776662466927, kStepV = 0.5698402909980532, kGolden = 0.6180339887498949;
  const double shift = std::fmod(seed * kGolden, 1.0);
  std::vector<glm::dvec3> points;
  points.reserve(count);
  double covered = 0;
  for (std::size_t t = 0; t < surface.indices().size() / 3; ++t) {
    covered += triangleArea(surface, t);
    const auto due = static_cast<std::uint64_t>(covered / area * static_cast<double>(count) + shift);
    const std::uint32_t* corner = &surface.indices()[3 * t];
    while (points.size() < std::min(due, count)) {
      const double i = static_cast<double>(points.size());
      double u = std::fmod(shift + i * kStepU, 1.0), v = std::fmod(shift + i * kStepV, 1.0);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      points.push_back((1 - u - v) * surface.positions()[corner[0]] + u * surface.positions()[corner[1]] +
                       v * surface.positions()[corner[2]]);
    }
  }
  return points;
}

struct Deviation {
  double sum_of_squares = 0;
  double max_squared = 0;
};

/// In chunks of fixed size, summed in order: the same figures for any number of threads.
Deviation measureDeviation(const std::vector<glm::dvec3>& points, const ClosestPoints& surface) {
  constexpr std::size_t kChunk = 4096;
  std::vector<Deviation> chunks((points.size() + kChunk - 1) / kChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t chunk) {
    std::uint32_t hint = 0;
    for (std::size_t i = chunk * kChunk; i < std::min(points.size(), (chunk + 1) * kChunk); ++i) {
      const double squared = surface.squaredDistance(points[i], hint);
      chunks[chunk].sum_of_squares += squared;
      chunks[chunk].max_squared = std::max(chunks[chunk].max_squared, squared);
    }
  });
  Deviation total;
  for (const Deviation& chunk : chunks) {
    total.sum_of_squares += chunk.sum_of_squares;
    total.max_squared = std::max(total.max_squared, chunk.max_squared);
  }
  return total;
}

std::vector<glm::dvec3> usedPositions(const ClosestPoints& surface) {
  std::vector<bool> seen(surface.positions().size(), false);
  std::vector<glm::dvec3> points;
  for (const std::uint32_t index : surface.indices()) {
    if (!seen[index]) points.push_back(surface.positions()[index]);
    seen[index] = true;
  }
  return points;
}

struct OneSided {
  double rms = 0;
  double max = 0;
};

OneSided measureOneSided(const ClosestPoints& from, double area, const ClosestPoints& to, const MetroOptions& options) {
  const std::vector<glm::dvec3> points = samplePoints(from, area, options.samples, options.seed);
  const Deviation over_area = measureDeviation(points, to);
  const Deviation at_vertices = options.at_vertices ? measureDeviation(usedPositions(from), to) : Deviation();
  const double mean = points.empty() ? 0 : over_area.sum_of_squares / static_cast<double>(points.size());
  return {to.fromFrame(std::sqrt(mean)),
          to.fromFrame(std::sqrt(std::max(over_area.max_squared, at_vertices.max_squared)))};
}

}  // namespace

Measured<MetroErrors> metro(const SurfaceView& a, const SurfaceView& b, const MetroOptions& options) {
  Box frame;
  for (const SurfaceView* surface : {&a, &b}) {
    if (auto error = checkSurface(*surface)) return *std::move(error);
    const Box box = boxOf(*surface);
    frame.add(box.low);
    frame.add(box.high);
  }
  const ClosestPoints surface_a(a, frame), surface_b(b, frame);
  const double area_a = surfaceArea(surface_a), area_b = surfaceArea(surface_b);
  if (!(area_a > 0) || !(area_b > 0)) {
    return QualityError{QualityErrorCode::kNoFaces, "the mesh has no area"};
  }

  MetroOptions chosen = options;
  if (chosen.samples == 0) {
    const std::uint64_t triangles = std::max(a.indices.size(), b.indices.size()) / 3;
    chosen.samples = std::clamp<std::uint64_t>(2 * triangles, 50'000, 1'000'000);
  }
  const OneSided a_to_b = measureOneSided(surface_a, area_a, surface_b, chosen);
  const OneSided b_to_a = measureOneSided(surface_b, area_b, surface_a, chosen);
  MetroErrors errors;
  errors.samples = chosen.samples;
  errors.rms_a_to_b = a_to_b.rms;
  errors.max_a_to_b = a_to_b.max;
  errors.rms_b_to_a = b_to_a.rms;
  errors.max_b_to_a = b_to_a.max;
  errors.area_a = surface_a.fromFrame(surface_a.fromFrame(area_a));
  errors.area_b = surface_b.fromFrame(surface_b.fromFrame(area_b));
  return errors;
}

Measured<std::vector<double>> distancesToSurface(PositionView points, const SurfaceView& surface) {
  if (auto error = checkSurface(surface)) return *std::move(error);
  Box frame = boxOf(surface);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 point = pointAt(points, i);
    if (std::isfinite(point.x + point.y + point.z)) frame.add(point);
  }
  const ClosestPoints closest(surface, frame);
  std::vector<double> distances(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 4096), [&](const auto& range) {
    std::uint32_t hint = 0;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const glm::dvec3 point = closest.toFrame(pointAt(points, i));
      distances[i] = std::isfinite(point.x + point.y + point.z)
                         ? closest.fromFrame(std::sqrt(closest.squaredDistance(point, hint)))
                         : std::numeric_limits<double>::quiet_NaN();
    }
  });
  return distances;
}

}  // namespace tsc
