#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace credence::internal {

/// Whether the next of a stream is to be appended to `kept`, so that it holds at most 4096 of any number,
/// evenly spread: when it is full every second one is dropped, and the stride doubles.
template <class T>
bool keep_thinned(std::vector<T>& kept, std::size_t& stride, std::size_t& seen) {
  constexpr std::size_t kMost = 4096;
  if (seen++ % stride != 0) return false;
  if (kept.size() < kMost) return true;
  for (std::size_t i = 0; 2 * i < kept.size(); ++i) kept[i] = std::move(kept[2 * i]);
  kept.resize(kMost / 2);
  stride *= 2;
  return (seen - 1) % stride == 0;
}

}  // namespace credence::internal
