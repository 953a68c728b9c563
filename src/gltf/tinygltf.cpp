// See tsc/tinygltf.h.
#include "tsc/tinygltf.h"

#include <filesystem>

#include "fault.h"

namespace tsc {
namespace {

/// As tinygltf decodes images, but one in a format that it does not know (KTX2, WebP) keeps its encoded bytes instead
/// of failing the whole model.
bool decodeImage(tinygltf::Image* image, int index, std::string* error, std::string* warning, int width, int height,
                 const unsigned char* bytes, int size, void* user) {
  std::string image_error;
  if (tinygltf::LoadImageData(image, index, &image_error, warning, width, height, bytes, size, user)) return true;
  (void)error;
  if (warning != nullptr) *warning += image_error;
  image->as_is = true;
  image->image.assign(bytes, bytes + size);
  return true;
}

Outcome loadExpanded(tinygltf::TinyGLTF& loader, Asset& asset, const std::filesystem::path& folder,
                     tinygltf::Model& model) {
  if (Outcome failure = unpackAsset(asset)) return failure;
  const Expected<std::vector<std::byte>> glb = writeGlb(asset);
  if (!glb) return glb.failure();
  return guardedOutcome(asset.name, [&] {
    std::string error, warning;
    const auto* bytes = reinterpret_cast<const unsigned char*>(glb->data());
    if (glb->size() > UINT32_MAX) fail(FailureKind::kUnsupported, "", "expanded to more than 4 GiB");
    if (!loader.LoadBinaryFromMemory(&model, &error, &warning, bytes, static_cast<unsigned int>(glb->size()),
                                     folder.string())) {
      while (!error.empty() && error.back() == '\n') error.pop_back();
      failInvalid("tinygltf", error);
    }
  });
}

}  // namespace

Outcome loadModel(tinygltf::TinyGLTF& loader, const std::filesystem::path& path, tinygltf::Model& model,
                  const LoadOptions& options) {
  Expected<Asset> asset = loadAsset(path, options);
  if (!asset) return asset.failure();
  return loadExpanded(loader, *asset, path.parent_path(), model);
}

Outcome loadModel(const std::filesystem::path& path, tinygltf::Model& model, const LoadOptions& options) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(decodeImage, nullptr);
  return loadModel(loader, path, model, options);
}

Outcome loadModel(std::span<const std::byte> bytes, tinygltf::Model& model, const std::filesystem::path& folder,
                  const LoadOptions& options) {
  const UriResolver resolver = [&](std::string_view uri) -> std::optional<std::vector<std::byte>> {
    if (folder.empty()) return std::nullopt;
    Expected<std::vector<std::byte>> content = readFile(folder / std::string(uri), options.limits.max_input_bytes);
    if (!content) return std::nullopt;
    return *std::move(content);
  };
  Expected<Asset> asset = loadAsset(bytes, "", resolver, options);
  if (!asset) return asset.failure();
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(decodeImage, nullptr);
  return loadExpanded(loader, *asset, folder, model);
}

}  // namespace tsc
