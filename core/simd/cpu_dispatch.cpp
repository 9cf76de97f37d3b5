#include "core/simd/cpu_dispatch.h"

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

namespace credence::internal {
namespace {

constexpr InstructionSet kFromTheWidest[] = {InstructionSet::avx512, InstructionSet::avx2,
                                             InstructionSet::scalar};

InstructionSet widest_up_to(const char* limit) {
  bool within = limit == nullptr || *limit == '\0';
  for (const InstructionSet set : kFromTheWidest) {
    within = within || std::string_view(limit) == instruction_set_name(set);
    if (within && is_supported(set)) return set;
  }
  throw std::invalid_argument(std::string(kInstructionSetVariable) + "=" + limit +
                              " is none of avx512, avx2 and scalar");
}

}  // namespace

bool is_supported(InstructionSet set) {
#if defined(__x86_64__)
  switch (set) {
    case InstructionSet::scalar: return true;
    case InstructionSet::avx2: return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  }
  return false;
#else
  return set == InstructionSet::scalar;
#endif
}

InstructionSet best_instruction_set() {
  static const InstructionSet best = widest_up_to(std::getenv(kInstructionSetVariable));
  return best;
}

bool multiplies_and_adds_at_once(InstructionSet set) {
#ifdef __FP_FAST_FMA
  return true;
#else
  return set != InstructionSet::scalar;
#endif
}

const char* instruction_set_name(InstructionSet set) {
  switch (set) {
    case InstructionSet::scalar: return "scalar";
    case InstructionSet::avx2: return "avx2";
    case InstructionSet::avx512: return "avx512";
  }
  return "unknown";
}

}  // namespace credence::internal
