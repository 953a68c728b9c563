// The small change of the public header: names and sizes.
#include "tsc/codec.h"

#include <algorithm>

namespace tsc {

std::string describe(const Error& error) {
  static constexpr const char* kNames[] = {
      "invalid argument",    "non-finite position", "lattice too fine",     "error bound not met", "stream truncated",
      "unsupported version", "reserved bits set",   "limit exceeded",       "invalid symbol",      "invalid count",
      "trailing data",       "checksum mismatch",   "output size mismatch",
  };
  std::string text = std::string(kNames[static_cast<std::size_t>(error.code)]) + " in " + error.where;
  if (error.code >= ErrorCode::kTruncated) text += " at byte " + std::to_string(error.byte_offset);
  text += ": found " + std::to_string(error.found) + ", expected " + std::to_string(error.expected);
  return text;
}

std::size_t componentSize(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8:
    case ComponentType::kUint8: return 1;
    case ComponentType::kInt16:
    case ComponentType::kUint16: return 2;
    default: return 4;
  }
}

std::size_t positionStride(ComponentType type) { return (3 * componentSize(type) + 3) / 4 * 4; }

}  // namespace tsc
