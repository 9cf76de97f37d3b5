#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace credence {

/// Memory at cache lines, which is what the kernels' packs of eight doubles want.
template <class T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};

  CacheLineAllocator() = default;
  template <class U>
  CacheLineAllocator(const CacheLineAllocator<U>&) {}  // NOLINT: what the allocator requirements ask for

  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kAlignment); }
  template <class U>
  bool operator==(const CacheLineAllocator<U>&) const {
    return true;
  }
};

/// Doubles that begin at a cache line.
using AlignedVector = std::vector<double, CacheLineAllocator<double>>;

}  // namespace credence
