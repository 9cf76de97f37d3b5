#pragma once

#include <cstdint>
#include <string_view>

namespace credence::internal {

/// FNV-1a, 64 bits (Fowler, Noll, Vo): the same number on every machine and in every version. `state` is
/// the hash of what came before, to hash several pieces as one.
constexpr std::uint64_t stable_hash(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325U) {
  for (const char c : bytes) {
    state ^= static_cast<unsigned char>(c);
    state *= 0x100000001b3U;
  }
  return state;
}

}  // namespace credence::internal
