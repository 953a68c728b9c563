// Counting the heap.
#include "heap.h"

#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>

namespace tsc::bench {

namespace {

// Counted only in the thread that measures, and only while it does: other times cost a test of one flag.
thread_local bool counting = false;
thread_local std::ptrdiff_t held = 0;
thread_local std::ptrdiff_t peak = 0;

void* take(std::size_t size, std::size_t alignment) {
  void* block = alignment > alignof(std::max_align_t)
                    ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                    : std::malloc(size > 0 ? size : 1);
  if (block == nullptr) throw std::bad_alloc();
  if (counting) {
    held += static_cast<std::ptrdiff_t>(malloc_usable_size(block));
    peak = std::max(peak, held);
  }
  return block;
}

void give(void* block) noexcept {
  if (counting && block != nullptr) held -= static_cast<std::ptrdiff_t>(malloc_usable_size(block));
  std::free(block);
}

}  // namespace

std::size_t peakHeapBytes(const std::function<void()>& work) {
  held = peak = 0;
  counting = true;
  try {
    work();
  } catch (...) {
    counting = false;
    throw;
  }
  counting = false;
  return static_cast<std::size_t>(peak);
}

}  // namespace tsc::bench

void* operator new(std::size_t size) { return tsc::bench::take(size, 0); }
void* operator new[](std::size_t size) { return tsc::bench::take(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return tsc::bench::take(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return tsc::bench::take(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept { tsc::bench::give(block); }
void operator delete[](void* block) noexcept { tsc::bench::give(block); }
void operator delete(void* block, std::size_t) noexcept { tsc::bench::give(block); }
void operator delete[](void* block, std::size_t) noexcept { tsc::bench::give(block); }
void operator delete(void* block, std::align_val_t) noexcept { tsc::bench::give(block); }
void operator delete[](void* block, std::align_val_t) noexcept { tsc::bench::give(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { tsc::bench::give(block); }
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept { tsc::bench::give(block); }
