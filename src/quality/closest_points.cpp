// Closest points through Embree's point queries.
#include "closest_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace tsc {
namespace {

double squaredDistanceToSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a, ap = p - a;
  const double length = glm::dot(ab, ab);
  const double t = length > 0 ? std::clamp(glm::dot(ap, ab) / length, 0.0, 1.0) : 0.0;
  const glm::dvec3 offset = ap - t * ab;
  return glm::dot(offset, offset);
}

/// To the plane if `p` lies above the triangle, else to the nearest side; holds for triangles without area too.
double squaredDistanceToTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double area = glm::dot(normal, normal);
  if (area > 0 && glm::dot(glm::cross(b - a, p - a), normal) >= 0 && glm::dot(glm::cross(c - b, p - b), normal) >= 0 &&
      glm::dot(glm::cross(a - c, p - c), normal) >= 0) {
    const double height = glm::dot(p - a, normal);
    return height * height / area;
  }
  return std::min(
      {squaredDistanceToSegment(p, a, b), squaredDistanceToSegment(p, b, c), squaredDistanceToSegment(p, c, a)});
}

/// To the triangle's box: a cheap lower bound, which spares most of the work where slivers crowd.
double squaredDistanceToBox(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
  const glm::dvec3 offset = p - glm::clamp(p, low, high);
  return glm::dot(offset, offset);
}

/// Frame coordinates are at most 1/2, so a vertex and the query point are each rounded by at most 2^-25 an axis.
float widened(double squared_distance) { return static_cast<float>(std::sqrt(squared_distance) * 1.000001 + 4e-7); }

}  // namespace

struct ClosestPoints::Search {
  const ClosestPoints* self;
  glm::dvec3 point;
  std::uint32_t triangle;
  double squared_distance;
};

ClosestPoints::ClosestPoints(const SurfaceView& surface, const Box& frame)
    : centre_((frame.low + frame.high) / 2.0),
      scale_(frame.diagonal() > 0 ? 1 / frame.diagonal() : 1),
      device_(rtcNewDevice(nullptr), rtcReleaseDevice),
      scene_(rtcNewScene(device_.get()), rtcReleaseScene) {
  positions_.reserve(surface.positions.size());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    positions_.push_back(toFrame(pointAt(surface.positions, v)));
  }
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const auto* corner = &surface.indices[i];
    if (isProper(corner[0], corner[1], corner[2])) indices_.insert(indices_.end(), corner, corner + 3);
  }
  buildTree();
}

double ClosestPoints::squaredDistance(const glm::dvec3& point, std::uint32_t& hint) const {
  Search search{this, point, hint, squaredDistanceTo(hint, point)};
  RTCPointQuery query{};
  query.x = static_cast<float>(point.x);
  query.y = static_cast<float>(point.y);
  query.z = static_cast<float>(point.z);
  query.radius = widened(search.squared_distance);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene_.get(), &query, &context, &visit, &search);
  hint = search.triangle;
  return search.squared_distance;
}

bool ClosestPoints::visit(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  const ClosestPoints& self = *search.self;
  const std::uint32_t* corner = &self.indices_[3 * std::size_t{arguments->primID}];
  const glm::dvec3 &a = self.positions_[corner[0]], &b = self.positions_[corner[1]], &c = self.positions_[corner[2]];
  if (squaredDistanceToBox(search.point, a, b, c) >= search.squared_distance) return false;
  const double squared = squaredDistanceToTriangle(search.point, a, b, c);
  if (squared >= search.squared_distance) return false;
  search.squared_distance = squared;
  search.triangle = arguments->primID;
  arguments->query->radius = widened(squared);
  return true;
}

double ClosestPoints::squaredDistanceTo(std::uint32_t triangle, const glm::dvec3& point) const {
  const std::uint32_t* corner = &indices_[3 * std::size_t{triangle}];
  return squaredDistanceToTriangle(point, positions_[corner[0]], positions_[corner[1]], positions_[corner[2]]);
}

void ClosestPoints::buildTree() {
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree asks for 16 readable bytes at the last vertex; its own buffers have them.
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), positions_.size()));
  for (std::size_t v = 0; v < positions_.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) vertices[3 * v + axis] = static_cast<float>(positions_[v][axis]);
  }
  auto* triangles = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), indices_.size() / 3));
  std::copy(indices_.begin(), indices_.end(), triangles);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_.get());
}

}  // namespace tsc
