// The figures that the codec's goals are set in, as one table.
#pragma once

#include <string>
#include <vector>

#include "rate.h"
#include "speed.h"

namespace tsc::bench {

/// What was measured at one effort.
struct EffortResults {
  std::string codec;              ///< variant with normal scale 1
  std::string codec_normal2;      ///< variant with normal scale 2
  std::vector<MeshRate> rates;    ///< both variants, with metrics
  std::vector<MeshRate> patches;  ///< small meshes; `codec` alone
  std::vector<MeshSpeed> speeds;  ///< `codec` alone
};

/// One row a figure, each with its goal: default effort beside effort max. "-" where nothing was measured.
std::string targetsTable(const EffortResults& normal, const EffortResults& max);

}  // namespace tsc::bench
