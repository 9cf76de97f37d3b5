#include "core/simd/aligned_vector.h"

#include <limits>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace credence::internal {
namespace {

constexpr std::size_t kCacheLine = 64, kLargePage = std::size_t{1} << 21;

std::align_val_t alignment(std::size_t count) {
  return std::align_val_t{count * sizeof(double) >= 2 * kLargePage ? kLargePage : kCacheLine};
}

}  // namespace

double* allocate_doubles(std::size_t count) {
  if (count > std::numeric_limits<std::size_t>::max() / sizeof(double)) throw std::bad_alloc();
  const std::size_t bytes = count * sizeof(double);
  void* p = ::operator new(bytes, alignment(count));
#if defined(__linux__)
  // Advice only: without it a stream waits for the translation of an address every 4 KB.
  if (bytes >= 2 * kLargePage) static_cast<void>(madvise(p, bytes, MADV_HUGEPAGE));
#endif
  return static_cast<double*>(p);
}

void free_doubles(double* p, std::size_t count) noexcept { ::operator delete(p, alignment(count)); }

}  // namespace credence::internal
