#pragma once

/// @file
/// Which of its instruction sets this portable binary uses on the machine at hand.

namespace credence {

/// Instruction sets that a kernel may be compiled for; all of them give the same bits.
enum class InstructionSet {
  scalar,  ///< any machine; slow where fused multiply-add is done in software
  avx2,    ///< AVX2 and FMA
  avx512,  ///< AVX-512 F, BW, DQ and VL
};

/// True if this binary was built with kernels for `set`, and the machine and its operating system run them.
bool is_supported(InstructionSet set);

/// The widest supported instruction set.
InstructionSet best_instruction_set();

/// "scalar", "avx2" or "avx512".
const char* instruction_set_name(InstructionSet set);

}  // namespace credence
