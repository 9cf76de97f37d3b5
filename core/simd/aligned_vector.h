#pragma once

#include <cstddef>
#include <vector>

namespace credence::internal {

/// Memory for large arrays of doubles: starts on a cache line; from some megabytes on, on large pages where
/// the system has them. Throws std::bad_alloc.
double* allocate_doubles(std::size_t count);
void free_doubles(double* p, std::size_t count) noexcept;

/// Allocator of AlignedVector.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t count) { return allocate_doubles(count); }
  void deallocate(T* p, std::size_t count) noexcept { free_doubles(p, count); }
  friend bool operator==(AlignedAllocator, AlignedAllocator) { return true; }
};

/// Doubles that kernels stream through.
using AlignedVector = std::vector<double, AlignedAllocator<double>>;

}  // namespace credence::internal
