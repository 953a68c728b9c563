// One text for both directions: a stage written over `Writing` or `Reading` cannot drift apart between them.
//
// Each call takes the value to code, which only `Writing` looks at, and returns the value coded. Stages compute that
// value under `if constexpr (Direction::kWrites)`.
#pragma once

#include <cstddef>
#include <cstdint>

#include "entropy.h"
#include "models.h"

namespace tsc {

struct Writing {
  static constexpr bool kWrites = true;
  EntropyWriter& writer;

  bool bit(BitModel& model, bool value) {
    model.put(writer, value);
    return value;
  }
  std::uint32_t symbol(SymbolModel& model, std::uint32_t value) {
    model.put(writer, value);
    return value;
  }
  std::uint32_t integer(IntegerModel& model, std::uint32_t value) {
    model.put(writer, value);
    return value;
  }
  std::uint32_t raw(std::uint32_t value, int count) {
    writer.putRaw(value, count);
    return value;
  }
  bool overrun() const { return false; }
  std::size_t position() const { return 0; }
  std::size_t remaining() const { return std::size_t{1} << 40; }
};

struct Reading {
  static constexpr bool kWrites = false;
  EntropyReader& reader;

  bool bit(BitModel& model, bool) { return model.get(reader); }
  std::uint32_t symbol(SymbolModel& model, std::uint32_t) { return model.get(reader); }
  std::uint32_t integer(IntegerModel& model, std::uint32_t) { return model.get(reader); }
  std::uint32_t raw(std::uint32_t, int count) { return reader.getRaw(count); }
  bool overrun() const { return reader.overrun(); }
  std::size_t position() const { return reader.position(); }
  /// Bytes that the reader has not read yet.
  std::size_t remaining() const { return reader.remaining(); }
};

}  // namespace tsc
