// Counting the heap: the program's operator new and delete are replaced by ones that keep a tally, so that peaks of all
// codecs, shared libraries included, are measured alike. Memory that C code takes by malloc is not seen; none of the
// codecs here does that.
#pragma once

#include <cstddef>
#include <functional>

namespace tsc::bench {

/// Largest number of bytes that `work` held at a time, beyond what was held before it. One thread at a time.
std::size_t peakHeapBytes(const std::function<void()>& work);

}  // namespace tsc::bench
