// Distance from points to the closest point of a surface.
//
// Embree's tree works in float; it only proposes triangles, within a radius widened by more than float can err, and
// each distance is taken in double from the original coordinates.
#pragma once

#include <embree3/rtcore.h>

#include <glm/vec3.hpp>
#include <memory>
#include <type_traits>
#include <vector>

#include "surface_tools.h"

namespace tsc {

/// The proper triangles of a surface, moved and scaled so that the box `frame`, which must hold them and all points
/// asked for, has its centre in the origin and diagonal 1. Queries may run on any number of threads at once.
class ClosestPoints {
 public:
  ClosestPoints(const SurfaceView& surface, const Box& frame);

  [[nodiscard]] glm::dvec3 toFrame(const glm::dvec3& point) const { return (point - centre_) * scale_; }
  [[nodiscard]] double fromFrame(double length) const { return length / scale_; }
  [[nodiscard]] const std::vector<glm::dvec3>& positions() const { return positions_; }
  [[nodiscard]] const std::vector<std::uint32_t>& indices() const { return indices_; }

  /// From a point of the frame, in the frame's unit. `hint`: a triangle that may be near, replaced by the closest.
  double squaredDistance(const glm::dvec3& point, std::uint32_t& hint) const;

 private:
  using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)>;
  using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)>;

  struct Search;

  static bool visit(RTCPointQueryFunctionArguments* arguments);
  double squaredDistanceTo(std::uint32_t triangle, const glm::dvec3& point) const;
  void buildTree();

  glm::dvec3 centre_;
  double scale_;
  std::vector<glm::dvec3> positions_;
  std::vector<std::uint32_t> indices_;
  Device device_;
  Scene scene_;
};

}  // namespace tsc
