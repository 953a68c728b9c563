// The HTML page of `tsc-bench report`: what was measured, as tables and plots. One file, nothing from the network.
#pragma once

#include <string>
#include <vector>

#include "plane.h"
#include "rate.h"
#include "speed.h"

namespace tsc::bench {

struct ReportData {
  std::string provenance, command;
  std::vector<MeshRate> rates;
  std::vector<MeshRate> patches;              ///< small patches, standing for small meshes
  std::vector<MeshSpeed> speeds, speeds_max;  ///< default effort, and effort max on fewer meshes
  std::vector<MeshSpeed> series;              ///< one mesh at rising sizes
  std::vector<PlaneRow> plane;
};

std::string reportPage(const ReportData& data);

}  // namespace tsc::bench
