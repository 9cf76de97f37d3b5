#include "core/simd/cpu_dispatch.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

/// In a process of its own, since the choice is made once: says what is chosen with this value.
[[noreturn]] void say_choice(const char* value) {
  setenv(kInstructionSetVariable, value, 1);
  try {
    const std::string first = instruction_set_name(best_instruction_set());
    setenv(kInstructionSetVariable, "nonsense", 1);
    const std::string second = instruction_set_name(best_instruction_set());
    std::fprintf(stderr, "chosen %s%s.\n", first.c_str(), first == second ? "" : ", then another");
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "refused %s.\n", error.what());
  }
  std::exit(0);
}

void expect_choice(const char* value, const std::string& said) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(say_choice(value), testing::ExitedWithCode(0), said) << value;
}

const char* widest() {
  for (const InstructionSet set : {InstructionSet::avx512, InstructionSet::avx2}) {
    if (is_supported(set)) return instruction_set_name(set);
  }
  return "scalar";
}

TEST(CpuDispatchDeathTest, TakesTheWidestThatTheVariableAllows) {
  expect_choice("", std::string("chosen ") + widest() + "\\.");
  expect_choice("avx512", std::string("chosen ") + widest() + "\\.");
  expect_choice("scalar", "chosen scalar\\.");
  expect_choice("avx2", is_supported(InstructionSet::avx2) ? "chosen avx2\\." : "chosen scalar\\.");
}

TEST(CpuDispatchDeathTest, RefusesWhatNamesNone) {
  for (const char* value : {"AVX2", "sse", " scalar"}) {
    expect_choice(value, std::string("refused CREDENCE_INSTRUCTION_SET=") + value +
                             " is none of avx512, avx2 and scalar");
  }
}

TEST(CpuDispatch, EveryMachineRunsScalarAndTheWideOnesMultiplyAndAdd) {
  EXPECT_TRUE(is_supported(InstructionSet::scalar));
  EXPECT_TRUE(multiplies_and_adds_at_once(InstructionSet::avx2));
  EXPECT_TRUE(multiplies_and_adds_at_once(InstructionSet::avx512));
  EXPECT_TRUE(is_supported(best_instruction_set()));
}

}  // namespace
}  // namespace credence::internal
