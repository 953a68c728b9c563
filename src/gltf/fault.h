// Failures inside the library travel as one exception type; `guarded` turns it, and everything else that could be
// thrown below it, into a value at the public boundary.
#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "tsc/gltf.h"

namespace tsc {

/// The internal carrier of a failure. Never leaves the library.
class Fault : public std::exception {
 public:
  explicit Fault(Failure failure) : failure_(std::move(failure)) {}
  const char* what() const noexcept override { return failure_.message.c_str(); }
  const Failure& failure() const { return failure_; }

 private:
  Failure failure_;
};

/// A number as messages print it.
inline std::string number(std::uint64_t value) { return std::to_string(value); }

/// Raises a failure about `place` (a JSON pointer, a byte offset or empty).
[[noreturn]] inline void fail(FailureKind kind, std::string_view place, std::string_view message) {
  std::string text(place);
  if (!text.empty()) text += ": ";
  text += message;
  throw Fault({kind, std::move(text)});
}

[[noreturn]] inline void failInvalid(std::string_view place, std::string_view message) {
  fail(FailureKind::kInvalidInput, place, message);
}

/// Raises the failure of a stream. One of another version may well be right.
[[noreturn]] inline void failStream(std::string_view place, const Error& error) {
  const bool may_be_right = error.code == ErrorCode::kUnsupportedVersion;
  fail(may_be_right ? FailureKind::kUnsupported : FailureKind::kInvalidInput, place, describe(error));
}

/// The value of an inner call, or its failure raised again.
template <class T>
T valueOrRaise(Expected<T> expected) {
  if (!expected) throw Fault(expected.failure());
  return *std::move(expected);
}

inline void raiseIfFailed(Outcome outcome) {
  if (outcome) throw Fault(*std::move(outcome));
}

/// The failure behind the exception that is being handled, with the file's name in front.
inline Failure currentFailure(std::string_view name) {
  const auto prefixed = [&](std::string_view text) {
    return name.empty() ? std::string(text) : std::string(name) + ": " + std::string(text);
  };
  try {
    throw;
  } catch (const Fault& fault) {
    return {fault.failure().kind, prefixed(fault.failure().message)};
  } catch (const std::bad_alloc&) {
    return {FailureKind::kUnsupported, prefixed("not enough memory")};
  } catch (const std::filesystem::filesystem_error& error) {
    return {FailureKind::kIo, prefixed(error.what())};
  } catch (const nlohmann::json::exception& error) {
    return {FailureKind::kInvalidInput, prefixed(error.what())};
  } catch (const std::exception& error) {
    return {FailureKind::kUnsupported, prefixed(error.what())};
  }
}

/// Runs `body` and gives its value, or the failure it ended with, which then begins with `name`.
template <class Body>
auto guarded(std::string_view name, Body&& body) -> Expected<std::invoke_result_t<Body>> {
  try {
    return std::forward<Body>(body)();
  } catch (...) {
    return currentFailure(name);
  }
}

/// The same for a body without a value.
template <class Body>
Outcome guardedOutcome(std::string_view name, Body&& body) {
  try {
    std::forward<Body>(body)();
    return std::nullopt;
  } catch (...) {
    return currentFailure(name);
  }
}

}  // namespace tsc
