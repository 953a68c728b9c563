// The paper's Figure 2: what quantisation does to a plane that lies askew to the axes.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tsc::bench {

struct PlaneOptions {
  std::size_t side = 100;       ///< vertices along an edge
  double degrees = 17.5;        ///< turn around the x axis
  double bits_per_vertex = 13;  ///< the rate that all codecs are brought to
};

/// One codec on the plane. Lengths are in units of the plane's diagonal.
struct PlaneRow {
  std::string codec;
  std::string error;  ///< why there are no figures; empty if there are
  double bits_per_vertex = 0;
  double rms = 0;         ///< vertex error
  double normal_rms = 0;  ///< its part across the plane
  double dame = 0;
  double max_degrees = 0;                    ///< largest angle between a triangle and the plane
  double bits_per_vertex_at_equal_step = 0;  ///< at the step at which the world-space codec has the wanted rate
};

/// World space: Draco at its nearest setting, our codec in its lattice mode. Tangent space: the paper's codec with
/// normal scale 1 and 2, with the first triangle exact as our codec stores it, and with one that was rounded to the
/// tangential step beforehand, which is what a codec that quantises it would start from. Then the same of a model of
/// the paper's codec (plane_model.h), on lattices of several finenesses.
std::vector<PlaneRow> measurePlane(const PlaneOptions& options);

/// What the columns and rows of the table mean.
const char* planeNote();
std::string planeTable(const std::vector<PlaneRow>& rows);

}  // namespace tsc::bench
