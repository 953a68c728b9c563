#include "extra_positions.h"

#include <algorithm>
#include <bit>

#include "direction.h"
#include "format.h"

namespace tsc {
namespace {

/// Positions that the surface does not have: one after another by differences.
template <class Direction>
void codeExtraPositions(Direction direction, int bits, std::span<const glm::dvec3> target, std::span<Vec3> decoded) {
  const std::int64_t limit = kCoordinateLimit >> bits;
  // By component, and by how long the component before was: jumps are jumps in all of them.
  constexpr int kClasses = 4;
  IntegerModel models[3][kClasses];
  int length_class = 0;
  WideVec3 last(0);
  for (std::size_t i = 0; i < decoded.size() && !direction.overrun(); ++i) {
    WideVec3 difference(0);
    if constexpr (Direction::kWrites) {
      difference = WideVec3(glm::floor(target[i] / static_cast<double>(1 << bits) + 0.5)) - last;
    }
    for (int a = 0; a < 3; ++a) {
      const std::uint32_t coded =
          direction.integer(models[a][length_class], zigzag(static_cast<std::int32_t>(difference[a])));
      difference[a] = unzigzag(coded);
      length_class = std::min<int>(static_cast<int>(std::bit_width(coded)) / 2, kClasses - 1);
    }
    last = glm::clamp(last + difference, WideVec3(-limit), WideVec3(limit));
    decoded[i] = Vec3(last * (std::int64_t{1} << bits));
  }
}

}  // namespace

void encodeExtraPositions(std::span<const glm::dvec3> target, int bits, EntropyWriter& writer,
                          std::span<Vec3> decoded) {
  codeExtraPositions(Writing{writer}, bits, target, decoded);
}

Status decodeExtraPositions(EntropyReader& reader, int bits, std::span<Vec3> decoded) {
  codeExtraPositions(Reading{reader}, bits, {}, decoded);
  if (reader.overrun()) return Error{ErrorCode::kTruncated, "extra positions", reader.position()};
  return {};
}

}  // namespace tsc
