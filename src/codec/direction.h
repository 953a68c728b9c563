// One text for both directions: a stage written over `Writing` or `Reading` cannot drift apart between them.
//
// Each call takes the value to code, which only `Writing` looks at, and returns the value coded. Stages compute that
// value under `if constexpr (Direction::kWrites)`.
#pragma once

#include <cstddef>
#include <cstdint>

#include "entropy.h"
#include "lanes.h"
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
  /// A bit that is 1 with probability `one` / 2^15, 0 < one < 2^15.
  bool chance(std::uint32_t one, bool value) {
    writer.put(value ? 0 : one, value ? one : kProbabilityOne - one);
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
  bool chance(std::uint32_t one, bool) {
    const bool value = reader.peek() < one;
    reader.advance(value ? 0 : one, value ? one : kProbabilityOne - one);
    return value;
  }
  bool overrun() const { return reader.overrun(); }
  std::size_t position() const { return reader.position(); }
  /// Bytes that the reader has not read yet.
  std::size_t remaining() const { return reader.remaining(); }
};

/// So many raw bits fit a group beside three symbols.
inline constexpr int kGroupRawBits = kGroupBits - 3 * kProbabilityBits;

/// A direction whose reader is a copy of its own, for the loop that all depends on: the compiler can keep it in
/// registers, as long as nothing but inlined code sees it. `from` and `to` move it in and out around all other code.
template <class Direction>
struct Hot;

template <>
struct Hot<Writing> {
  static constexpr bool kWrites = true;
  EntropyWriter& writer;
  explicit Hot(Writing& direction) : writer(direction.writer) {}
  void from(const Writing&) {}
  void to(Writing&) const {}

  std::uint32_t peek() const { return 0; }
  /// A symbol by a table, whose group goes on. The table does not learn here.
  template <class Table>
  void symbol(const Table& table, std::uint32_t symbol) {
    writer.putGrouped(table.below(symbol), table.below(symbol + 1) - table.below(symbol));
  }
  template <class Table>
  void innerSymbol(const Table& table, std::uint32_t value) {
    symbol(table, value);
  }
  /// Fewer than 32 bits, whose group goes on.
  std::uint32_t raw(std::uint32_t value, int count) {
    writer.putRawGrouped(value, count);
    return value;
  }
  void endGroup() { writer.endGroup(); }
  /// A bit that is 1 only where that is possible; its group goes on.
  bool hit(HitModel& model, bool possible, bool value) {
    if (!possible) return false;
    const std::uint32_t one = model.one(true);
    writer.putGrouped(value ? 0 : one, value ? one : kProbabilityOne - one);
    model.update(value, true);
    return value;
  }
};

template <>
struct Hot<Reading> {
  static constexpr bool kWrites = false;
  EntropyReader reader;
  explicit Hot(Reading& direction) : reader(direction.reader) {}
  void from(const Reading& direction) { reader = direction.reader; }
  void to(Reading& direction) const { direction.reader = reader; }

  std::uint32_t peek() const { return reader.peek(); }
  template <class Table>
  TSC_ALWAYS_INLINE void symbol(const Table& table, std::uint32_t symbol) {
    reader.advanceGrouped(table.below(symbol), table.below(symbol + 1) - table.below(symbol));
  }
  /// Neither the first nor the last.
  template <class Table>
  TSC_ALWAYS_INLINE void innerSymbol(const Table& table, std::uint32_t symbol) {
    const std::uint32_t start = table.belowInner(symbol);
    reader.advanceGrouped(start, table.belowInner(symbol + 1) - start);
  }
  TSC_ALWAYS_INLINE std::uint32_t raw(std::uint32_t, int count) { return reader.getFewRawGrouped(count); }
  void endGroup() { reader.endGroup(); }
  TSC_ALWAYS_INLINE bool hit(HitModel& model, bool possible, bool) {
    const std::uint32_t one = model.one(possible);
    const bool value = reader.peek() < one;
    reader.advanceGrouped(value ? 0 : one, value ? one : kProbabilityOne - one);
    model.update(value, possible);
    return value;
  }
};

}  // namespace tsc
