// `credence claims` as a user types it.

#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class ClaimsCommand : public CommandTest {};

// From the first claim on: those of the paper's worlds take several seconds of a processor.
TEST_F(ClaimsCommand, ClaimsInterruptedAreNotTold) {
  const pid_t child =
      start_program({"sh", "-c", "ulimit -t 3; exec " + credence_binary().string() + " claims --quiet"});
  wait_until_caught(child);
  kill(child, SIGINT);
  const Finished f = finish(child);
  EXPECT_EQ(f.code, 130);
  EXPECT_EQ(f.out, "");
  EXPECT_NE(f.err.find("claims interrupted"), std::string::npos) << f.err;
}

// All other claims take several seconds of a processor.
TEST_F(ClaimsCommand, DataThatAreNotThereAreSaidBeforeAnythingIsMeasured) {
  const Finished f = finish(start_program(
      {"sh", "-c", "ulimit -t 3; exec " + credence_binary().string() + " claims --data nowhere --out out"}));
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.out, "");
  EXPECT_EQ(f.err, "credence: nowhere/data_set.mat: there is no such file\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

}  // namespace
}  // namespace credence::internal
