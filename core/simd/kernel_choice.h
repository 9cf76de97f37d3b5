#pragma once

#include <stdexcept>
#include <string>
#include <type_traits>

#include "core/simd/cpu_dispatch.h"

/// @file
/// Which of the functions x_kernel_scalar, x_kernel_avx2 and x_kernel_avx512 (kernel_set.h) is asked for its
/// kernel; for portable sources alone. CREDENCE_KERNELS names the three, or null for those that processors of
/// another family do not have.

#if defined(__x86_64__)
#define CREDENCE_KERNELS(name) name##_scalar, name##_avx2, name##_avx512
#else
#define CREDENCE_KERNELS(name) name##_scalar, nullptr, nullptr
#endif

namespace credence::internal {

/// The kernel for `set`, null where the machine or the binary does not have it. `arguments` go to the
/// function of the set; no other is called.
template <class Kernel, class... Arguments>
const Kernel* find_kernel(InstructionSet set, const Kernel* (*scalar)(Arguments...),
                          std::type_identity_t<const Kernel* (*)(Arguments...)> avx2,
                          std::type_identity_t<const Kernel* (*)(Arguments...)> avx512,
                          std::type_identity_t<Arguments>... arguments) {
  if (!is_supported(set)) return nullptr;
  switch (set) {
    case InstructionSet::scalar: return scalar(arguments...);
    case InstructionSet::avx2: return avx2(arguments...);
    case InstructionSet::avx512: return avx512(arguments...);
  }
  return nullptr;
}

/// The same; throws std::invalid_argument where there is none.
template <class Kernel>
const Kernel& require_kernel(InstructionSet set, const Kernel* (*scalar)(),
                             std::type_identity_t<const Kernel* (*)()> avx2,
                             std::type_identity_t<const Kernel* (*)()> avx512) {
  if (const Kernel* kernel = find_kernel(set, scalar, avx2, avx512)) return *kernel;
  throw std::invalid_argument(std::string("this machine does not support the instruction set ") +
                              instruction_set_name(set));
}

}  // namespace credence::internal
