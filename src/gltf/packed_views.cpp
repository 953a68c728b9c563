// See packed_views.h.
#include "packed_views.h"

#include "fault.h"
#include "json_document.h"

namespace tsc {
namespace {

/// The view that `json` names, which must exist and be plain.
std::size_t plainView(const Json& document, const JsonView& json) {
  const std::size_t count = countOf(document, "bufferViews");
  const std::size_t view = json["bufferView"].asUint();
  const std::string place = json.pointer() + "/bufferView";
  if (view >= count)
    failInvalid(place, "found " + std::to_string(view) + ", expected one below " + std::to_string(count));
  if (findExtension(elementOf(document, "bufferViews", view).json(), kExtensionName) != nullptr) {
    failInvalid(place, "found " + std::to_string(view) + ", which is packed itself");
  }
  return view;
}

}  // namespace

std::map<std::size_t, std::vector<PackedView>> findPackedViews(const Json& document) {
  std::map<std::size_t, std::vector<PackedView>> streams;
  const std::size_t count = countOf(document, "bufferViews");
  for (std::size_t i = 0; i < count; ++i) {
    const JsonView view = elementOf(document, "bufferViews", i);
    const Json* extension = findExtension(view.json(), kExtensionName);
    if (extension == nullptr) continue;
    PackedView packed;
    packed.view = i;
    packed.place = view.pointer() + "/extensions/" + std::string(kExtensionName);
    packed.byte_length = view["byteLength"].asUint();
    const JsonView json(*extension, packed.place);
    const std::size_t stream = plainView(document, json);
    packed.output = json["output"].asUint();
    if (const auto order = json.find("order")) packed.order = plainView(document, *order);
    const std::vector<PackedView>& siblings = streams[stream];
    if (!siblings.empty() && siblings.front().order != packed.order) {
      failInvalid(packed.place, "found another order than that of " + siblings.front().place);
    }
    streams[stream].push_back(std::move(packed));
  }
  return streams;
}

}  // namespace tsc
