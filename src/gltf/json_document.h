// Reading, writing and typed access of JSON documents.
//
// Traps: an integer beyond 64 bits is held as a `binary` value with its digits (nlohmann would round it to a double).
// Doubles are printed shortest-round-trip, so they keep their value to the last bit. Duplicate keys are refused, for
// one of the two values would be lost.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tsc/gltf.h"

namespace tsc {

/// Members of one object; looking one up takes linear time, so this bounds what a hostile document can cost.
inline constexpr std::size_t kMaxObjectMembers = 8192;

/// Parses a document. Raises kInvalidInput with the byte offset on bad JSON, or where it is nested too deep.
Json parseJson(std::string_view text, std::uint32_t max_depth);

/// A short print of a value for messages.
std::string brief(const Json& value);

/// A number of 0 or more without a fraction, or nothing.
std::optional<std::uint64_t> wholeNumber(const Json& value);

/// A place in a document: a value and the JSON pointer to it. Getters raise kInvalidInput where the type is wrong.
class JsonView {
 public:
  explicit JsonView(const Json& root) : value_(&root) {}
  JsonView(const Json& value, std::string pointer) : value_(&value), pointer_(std::move(pointer)) {}

  const Json& json() const { return *value_; }
  const std::string& pointer() const { return pointer_; }

  /// Member `key` of this object, if there is one.
  std::optional<JsonView> find(std::string_view key) const;
  /// Member `key` of this object, which must be there.
  JsonView operator[](std::string_view key) const;
  /// Number of elements of this array.
  std::size_t size() const;
  /// Element `index` of this array.
  JsonView at(std::size_t index) const;

  /// A whole number between 0 and `max`.
  std::uint64_t asUint(std::uint64_t max = UINT64_MAX) const;
  std::string asString() const;
  bool asBool() const;
  /// Members of the object.
  const Json& asObject() const;

  /// Member `key` as a whole number, or `otherwise`.
  std::uint64_t uintOr(std::string_view key, std::uint64_t otherwise, std::uint64_t max = UINT64_MAX) const;

 private:
  [[noreturn]] void wrongType(std::string_view expected) const;

  const Json* value_;
  std::string pointer_;
};

/// Element `index` of the root's array `key`, as a place.
JsonView elementOf(const Json& document, std::string_view key, std::size_t index);

/// Length of the root's array `key`; 0 if there is none.
std::size_t countOf(const Json& document, std::string_view key);

/// The member object `extensions[name]` of `holder`, or nothing.
const Json* findExtension(const Json& holder, std::string_view name);

/// Removes `extensions[name]`, and `extensions` when it is left empty.
void eraseExtension(Json& holder, std::string_view name);

/// Adds `name` to the document's `extensionsUsed` (and `extensionsRequired`), once.
void declareExtension(Json& document, std::string_view name, bool required);

/// Takes `name` out of both lists, and a list that is left empty out of the document.
void undeclareExtension(Json& document, std::string_view name);

}  // namespace tsc
