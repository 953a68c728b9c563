// See packed_views.h.
#include "packed_views.h"

#include "fault.h"
#include "json_document.h"

namespace tsc {

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
    const std::size_t stream = json["bufferView"].asUint();
    packed.output = json["output"].asUint();
    if (stream >= count) {
      failInvalid(packed.place + "/bufferView",
                  "found " + std::to_string(stream) + ", expected one below " + std::to_string(count));
    }
    if (findExtension(elementOf(document, "bufferViews", stream).json(), kExtensionName) != nullptr) {
      failInvalid(packed.place + "/bufferView", "found " + std::to_string(stream) + ", which is packed itself");
    }
    streams[stream].push_back(std::move(packed));
  }
  return streams;
}

}  // namespace tsc
