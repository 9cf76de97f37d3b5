#include "core/simd/aligned_vector.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <new>
#include <numeric>

namespace credence::internal {
namespace {

std::uintptr_t beyond(const double* p, std::uintptr_t boundary) {
  return reinterpret_cast<std::uintptr_t>(p) % boundary;
}

TEST(AlignedVector, StartsOnACacheLine) {
  for (const std::size_t count : {1U, 3U, 8U, 1000U, 100'000U}) {
    EXPECT_EQ(beyond(AlignedVector(count).data(), 64), 0U) << count;
  }
}

TEST(AlignedVector, OfMegabytesStartsOnALargePage) {
  constexpr std::uintptr_t kLargePage = 2U << 20U;
  constexpr std::size_t kFirst = 2 * kLargePage / sizeof(double);
  for (const std::size_t count : {kFirst, kFirst + 1, 2 * kFirst}) {
    const AlignedVector large(count, 1.5);
    EXPECT_EQ(beyond(large.data(), kLargePage), 0U) << count;
    EXPECT_EQ(large.front() + large.back(), 3.0);
  }
}

TEST(AlignedVector, KeepsItsValuesAsItGrows) {
  AlignedVector values;  // past the size from which memory is aligned in another way
  for (int i = 0; i < 1'100'000; ++i) values.push_back(i);
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0.0), 1'100'000.0 * 1'099'999.0 / 2.0);
  values.resize(3);
  values.shrink_to_fit();
  EXPECT_EQ(values, (AlignedVector{0.0, 1.0, 2.0}));
}

TEST(AlignedVector, OfMoreThanThereCanBeIsNoMemory) {
  // 8 count wraps to 8 bytes where it is not looked at.
  constexpr std::size_t kWraps = std::numeric_limits<std::size_t>::max() / sizeof(double) + 2;
  EXPECT_THROW(free_doubles(allocate_doubles(kWraps), kWraps), std::bad_alloc);
}

}  // namespace
}  // namespace credence::internal
