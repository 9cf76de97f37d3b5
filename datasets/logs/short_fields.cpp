#include "datasets/logs/short_fields.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include <array>
#include <bit>
#include <cstdint>

#include "core/simd/cpu_dispatch.h"
#include "datasets/logs/short_number.h"
#endif

namespace credence::internal {

#if defined(__x86_64__)
namespace {

constexpr int kMostCharacters = 15;

constexpr std::size_t place_of(int end, int before) {
  return 16 * static_cast<std::size_t>(end) + static_cast<std::size_t>(before);
}

/// Of text that has `before` digits before its point and ends at `end` (end = before: it has no point), from
/// which places its digits come when they are moved to the right end of sixteen; 0x80: from none.
constexpr auto kPlaces = [] {
  std::array<std::array<std::uint8_t, 16>, 256> all{};
  for (int end = 0; end <= kMostCharacters; ++end) {
    for (int before = 0; before <= end; ++before) {
      auto& places = all[place_of(end, before)];
      places.fill(0x80);
      for (int from = end - 1, to = 15; from >= 0; --from) {
        if (from != before) places[static_cast<std::size_t>(to--)] = static_cast<std::uint8_t>(from);
      }
    }
  }
  return all;
}();

/// Adds the exponent at `at`, behind its letter, to `power`, and moves `at` to its end; false where there is
/// none of at most two digits.
bool add_exponent(const char*& at, int& power) {
  const bool negative = *at == '-';
  const char *const first = at + (negative || *at == '+' ? 1 : 0), *end = first;
  int exponent = 0;
  for (; *end >= '0' && *end <= '9' && end - first < 2; ++end) exponent = 10 * exponent + (*end - '0');
  power += negative ? -exponent : exponent;
  at = end;
  return end > first;
}

[[gnu::target("sse4.1")]] const char* read_by_sixteen(const char* at, const char* line_end,
                                                      std::span<double> fields, std::size_t& count) {
  while (count < fields.size()) {
    const bool negative = *at == '-';
    const char* const begin = at + (negative ? 1 : 0);
    const __m128i text = _mm_loadu_si128(reinterpret_cast<const __m128i*>(begin));
    const __m128i digits = _mm_sub_epi8(text, _mm_set1_epi8('0'));
    const __m128i are_digits = _mm_cmpeq_epi8(_mm_min_epu8(digits, _mm_set1_epi8(9)), digits);
    const std::uint32_t others = static_cast<std::uint32_t>(_mm_movemask_epi8(are_digits)) ^ 0xffffU;
    const int before = std::countr_zero(others | 0x10000U);
    const bool point = begin[before] == '.';
    const int end = point ? std::countr_zero((others & (others - 1)) | 0x10000U) : before;
    const int behind = point ? end - before - 1 : 0;
    if (end > kMostCharacters || before + behind == 0) return at;

    const auto& places = kPlaces[place_of(end, before)];
    const __m128i right =
        _mm_shuffle_epi8(digits, _mm_loadu_si128(reinterpret_cast<const __m128i*>(places.data())));
    const __m128i pairs = _mm_maddubs_epi16(right, _mm_set1_epi16(0x010a));    // ten and one
    const __m128i fours = _mm_madd_epi16(pairs, _mm_set1_epi32(0x0001'0064));  // a hundred and one
    const __m128i eights = _mm_madd_epi16(_mm_packus_epi32(fours, fours), _mm_set1_epi32(0x0001'2710));
    const auto both = static_cast<std::uint64_t>(_mm_cvtsi128_si64(eights));
    const std::uint64_t number = (both & 0xffff'ffffU) * 100'000'000U + (both >> 32);

    const char* next = begin + end;
    int power = -behind;
    if ((*next == 'e' || *next == 'E') && !add_exponent(++next, power)) return at;
    if (*next != ',' && next != line_end) return at;
    if (power < -kMostTens || power > kMostTens) return at;
    fields[count++] = times_tens(number, power, negative);
    at = next + 1;
    if (next == line_end) return at;
  }
  return at;
}

}  // namespace

const char* read_short_fields(const char* at, const char* line_end, std::span<double> fields,
                              std::size_t& count) {
  static const bool can = best_instruction_set() != InstructionSet::scalar;
  return can ? read_by_sixteen(at, line_end, fields, count) : at;
}

#else

const char* read_short_fields(const char* at, const char* /*line_end*/, std::span<double> /*fields*/,
                              std::size_t& /*count*/) {
  return at;
}

#endif

}  // namespace credence::internal
