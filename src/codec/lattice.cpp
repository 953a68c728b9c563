#include "lattice.h"

#include <cmath>
#include <limits>

#include "format.h"

namespace tsc {

Box boxOf(const Mesh& mesh) {
  Box box;
  bool first = true;
  for (const VertexTable& table : mesh.tables) {
    for (std::size_t i = 0; i + 2 < table.positions.size(); i += 3) {
      const glm::dvec3 p(table.positions[i], table.positions[i + 1], table.positions[i + 2]);
      box.lower = first ? p : glm::min(box.lower, p);
      box.upper = first ? p : glm::max(box.upper, p);
      first = false;
    }
  }
  return box;
}

bool fitsTangentMode(const Box& box, double step) {
  return box.extent() / step < std::ldexp(1.0, kMaxLatticeBits - 1 - kFineBits);
}

Status placeLattice(const Mesh& mesh, const EncodeOptions& options, Header& header) {
  const Box box = boxOf(mesh);
  header.position_type = mesh.position_type;
  const bool integer = mesh.position_type != ComponentType::kFloat32;
  header.step = integer ? 1.0f : static_cast<float>(options.step);
  header.anchored = integer || options.anchored;
  if (!(header.step > 0) || !std::isfinite(header.step)) return Error{ErrorCode::kInvalidArgument, "step", 0, 0, 1};
  const double limit = std::ldexp(1.0, kMaxLatticeBits - 1);
  const double cells = box.extent() / header.step;
  if (cells > limit) {
    return Error{ErrorCode::kLatticeTooFine, "extent in steps", 0, static_cast<std::int64_t>(std::min(cells, 1e18)),
                 static_cast<std::int64_t>(limit)};
  }
  for (int a = 0; a < 3; ++a) {
    header.origin[a] = static_cast<float>(box.lower[a]);
    const double anchor = std::floor(box.lower[a] / header.step);
    if (header.anchored && std::abs(anchor) > std::ldexp(1.0, 47)) {
      return Error{ErrorCode::kLatticeTooFine, "coordinate in steps", 0, std::numeric_limits<std::int64_t>::max(),
                   std::int64_t{1} << 47};
    }
    header.anchor[a] = header.anchored ? static_cast<std::int64_t>(anchor) : 0;
  }
  return {};
}

std::vector<glm::dvec3> targetsOf(std::span<const float> welded_positions, std::span<const std::uint32_t> welded,
                                  const Header& header) {
  std::vector<glm::dvec3> targets(welded.size());
  const double cells = std::ldexp(1.0, header.positions.fine_bits);
  for (std::size_t i = 0; i < welded.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      const double x = welded_positions[3 * std::size_t{welded[i]} + a];
      const double steps = header.anchored ? x / header.step - static_cast<double>(header.anchor[a])
                                           : (x - header.origin[a]) / header.step;
      targets[i][a] = steps * cells;
    }
  }
  return targets;
}

double stepForBits(const Mesh& mesh, int bits) {
  const double extent = boxOf(mesh).extent();
  return extent > 0 ? extent / (std::ldexp(1.0, bits) - 1) : 1;
}

double guaranteedError(const Mesh& mesh, const EncodeOptions& options) {
  if (mesh.position_type != ComponentType::kFloat32) return 0;
  const double step = static_cast<float>(options.step);
  const Box box = boxOf(mesh);
  // Of each component to the nearest float: 2^-24 of it, or half the smallest float.
  const double rounding = std::max(std::ldexp(box.magnitude(), -24), std::ldexp(1.0, -150)) * std::sqrt(3.0);
  const double lattice = step * std::sqrt(0.75);  // half a cell's diagonal
  if (options.mode == Mode::kLattice || !fitsTangentMode(box, step)) return lattice + 2 * rounding;
  // In tangent mode each component is off by half its step and by the rounding to the fine lattice, seen along its
  // axis. The first two axes are of length 1 to 2^-8, so the third, their product, is to 2^-7; with what the three lack
  // in being orthogonal that adds less than 2^-6.
  const double fine = std::ldexp(step, -kFineBits);
  const double normal_step = fine * std::max(std::floor(std::ldexp(1.0, kFineBits) / options.normal_scale), 1.0);
  const double slack = fine * std::sqrt(0.75);
  const double tangential = step / 2 + slack;
  const double normal = normal_step / 2 + slack;
  const double tangent = std::sqrt(2 * tangential * tangential + normal * normal) * (1 + std::ldexp(1.0, -6));
  return (options.mode == Mode::kTangent ? tangent : std::max(tangent, lattice)) + 2 * rounding;
}

}  // namespace tsc
