#include "core/large_pages.h"

#include <cstdint>
#include <cstdlib>
#include <limits>

#if defined(__linux__)
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace credence::internal {
#if defined(__GLIBC__) && defined(MADV_HUGEPAGE)
void use_large_pages() {
  constexpr int kReserved = 1 << 28, kLargestOfHeap = 1 << 25;  // bytes; the latter the most that glibc takes
  constexpr int kAsBefore = 1 << 17;                            // glibc's own
  constexpr std::uintptr_t kLargePage = std::uintptr_t{1} << 21;
  const auto heap_end = [] { return reinterpret_cast<std::uintptr_t>(sbrk(0)); };
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_MMAP_THRESHOLD, kLargestOfHeap);
  mallopt(M_TOP_PAD, kReserved);
  const std::uintptr_t before = heap_end();
  void* volatile more = std::malloc(2 * kAsBefore);  // than there is, so that the heap grows
  std::free(more);
  mallopt(M_TOP_PAD, kAsBefore);
  const std::uintptr_t first = (before + kLargePage - 1) / kLargePage * kLargePage, end = heap_end();
  // Advice only: where there are no large pages all stays as it is.
  if (first < end) static_cast<void>(madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE));
}

void use_one_heap() { mallopt(M_ARENA_MAX, 1); }

#else

void use_large_pages() {}
void use_one_heap() {}

#endif
}  // namespace credence::internal
