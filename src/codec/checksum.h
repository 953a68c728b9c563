// XXH64 (Collet, xxHash specification 0.1.1): the checksum of decoded output (BITSTREAM.md, section 8).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tsc {

[[nodiscard]] std::uint64_t xxh64(std::span<const std::byte> bytes, std::uint64_t seed);

}  // namespace tsc
