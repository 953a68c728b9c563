// Packed assets for applications that use tinygltf.
//
//   tinygltf::Model model;
//   if (auto failure = tsc::loadModel("packed.glb", model)) report(failure->message);
//
// tinygltf 2.7 refuses any file with a placeholder buffer before an application could see it, so the asset is expanded
// in memory and handed over as plain glTF. Plain assets load too.
#pragma once

#include <tiny_gltf.h>

#include <filesystem>
#include <span>
#include <string>

#include "tsc/gltf.h"

namespace tsc {

/// Loads a file, packed or plain, `.gltf` or `.glb`, into `model`. Images are decoded by tinygltf as usual; one whose
/// format it does not know keeps its encoded bytes (`Image::as_is`).
[[nodiscard]] Outcome loadModel(const std::filesystem::path& path, tinygltf::Model& model,
                                const LoadOptions& options = {});

/// The same from memory. `folder` is where tinygltf finds external images.
[[nodiscard]] Outcome loadModel(std::span<const std::byte> bytes, tinygltf::Model& model,
                                const std::filesystem::path& folder = {}, const LoadOptions& options = {});

/// The same through the caller's own loader, whose callbacks and settings are kept.
[[nodiscard]] Outcome loadModel(tinygltf::TinyGLTF& loader, const std::filesystem::path& path, tinygltf::Model& model,
                                const LoadOptions& options = {});

}  // namespace tsc
