// From assets to the surfaces that the quality library measures, and the distortion that pack caused.
#pragma once

#include <string>
#include <vector>

#include "tsc/gltf.h"
#include "tsc/quality.h"

namespace tsc::cli {

/// One surface a mesh of the document, in its order: all triangle primitives together, positions as their accessors
/// mean them (normalized integers scaled), placed by the nodes that show it. A packed asset is expanded first, on a
/// copy. A mesh without triangles has no indices.
Expected<std::vector<NamedSurface>> surfacesOf(const Asset& asset);

/// Removes meshes that have no faces on either side; where the files have different numbers of meshes, all without.
void dropEmptyMeshes(std::vector<NamedSurface>& a, std::vector<NamedSurface>& b);

/// An error of the quality library with the exit code that it stands for.
Failure toFailure(const QualityError& error);

/// What `compare` would say as JSON of an asset before and after `packAsset`; null if it has no triangles.
Expected<Json> packDistortion(const Asset& original, const Asset& packed, const MetroOptions& options = {});

/// The same for the report about `input`: where it cannot be measured null, and unless `quiet` a warning on standard
/// error.
Json reportDistortion(const Asset& original, const Asset& packed, const std::string& input, bool quiet);

}  // namespace tsc::cli
