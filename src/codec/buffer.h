// Arrays that grow without their new elements being written.
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace tsc {

template <class T>
struct Uninitialized : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = Uninitialized<U>;
  };
  Uninitialized() = default;
  template <class U>
  Uninitialized(const Uninitialized<U>&) noexcept {}

  template <class U>
  void construct(U* element) noexcept {
    ::new (static_cast<void*>(element)) U;
  }
  template <class U, class... Arguments>
  void construct(U* element, Arguments&&... arguments) {
    ::new (static_cast<void*>(element)) U(std::forward<Arguments>(arguments)...);
  }
};

/// A vector whose `resize` leaves new elements of trivial types as the memory has them.
template <class T>
using Buffer = std::vector<T, Uninitialized<T>>;

}  // namespace tsc
