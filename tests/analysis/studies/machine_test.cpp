#include "analysis/studies/machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "core/simd/cpu_dispatch.h"

namespace credence::internal {
namespace {

TEST(Machine, IsToldWithAllThatATimeDependsOn) {
  const MachineDescription machine = describe_machine();
  EXPECT_FALSE(machine.processor.empty());
  EXPECT_FALSE(machine.processor.starts_with(' ')) << machine.processor;
  EXPECT_EQ(machine.processor.find('\n'), std::string::npos);
  EXPECT_GE(machine.processors, 1);
  EXPECT_LE(machine.processors, static_cast<int>(std::thread::hardware_concurrency()));
  EXPECT_EQ(machine.instruction_set, instruction_set_name(best_instruction_set()));
  // Its name and its version.
  EXPECT_THAT(machine.compiler,
              ::testing::AnyOf(::testing::HasSubstr("lang"), ::testing::StartsWith("g++ ")));
  EXPECT_NE(machine.compiler.find_first_of("0123456789"), std::string::npos) << machine.compiler;
  EXPECT_TRUE(std::isnan(machine.load) || machine.load >= 0.0) << machine.load;
}

}  // namespace
}  // namespace credence::internal
