#pragma once

/// @file
/// Which of its instruction sets this portable binary uses on the machine at hand.

namespace credence::internal {

/// Instruction sets that a kernel may be compiled for; all of them give the same bits.
enum class InstructionSet {
  scalar,  ///< any machine; slow where fused multiply-add is done in software
  avx2,    ///< AVX2 and FMA
  avx512,  ///< AVX-512 F, BW, DQ and VL
};

/// True if this binary was built with kernels for `set`, and the machine and its operating system run them.
bool is_supported(InstructionSet set);

/// The environment variable that may name the widest instruction set to be used: to see that bits and
/// verdicts do not depend on it, or what another machine would take.
inline constexpr const char* kInstructionSetVariable = "CREDENCE_INSTRUCTION_SET";

/// The widest supported instruction set that kInstructionSetVariable allows; the same at every call. Throws
/// std::invalid_argument where the variable names none.
InstructionSet best_instruction_set();

/// False where fused multiply-adds are done in software, which is several times slower.
bool multiplies_and_adds_at_once(InstructionSet set);

/// "scalar", "avx2" or "avx512".
const char* instruction_set_name(InstructionSet set);

}  // namespace credence::internal
