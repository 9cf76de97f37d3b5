// How the program sees that it was started together with others, without mpirun (mpi/mpi_ranks_test.cpp).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

class LaunchedRanks : public CommandTest {
 protected:
  /// Its version, in an environment: the shortest of all commands.
  Finished version_of(const fs::path& program, const std::string& environment) const {
    return finish(start_program(
        {"sh", "-c",
         "exec env " + environment + " ASAN_OPTIONS=detect_leaks=0 " + program.string() + " --version"}));
  }
};

TEST_F(LaunchedRanks, OneProcessIsAlone) {
  const std::string alone = version_of(credence_binary(), "").out;
  ASSERT_NE(alone, "");
  for (const char* environment : {"OMPI_COMM_WORLD_SIZE=1", "PMI_SIZE=1", "OMPI_COMM_WORLD_SIZE=none",
                                  // A task of a job that srun did not start by MPI, as in an array of shards.
                                  "SLURM_NTASKS=4", "SLURM_NTASKS=1 PMIX_RANK=0"}) {
    const Finished f = version_of(credence_binary(), environment);
    EXPECT_EQ(f.code, 0) << environment << ": " << f.err;
    EXPECT_EQ(f.out, alone) << environment;
  }
}

// Each would do all of the work by itself, and all write to one store.
TEST_F(LaunchedRanks, SeveralThatCannotBeJoinedAreAnError) {
  fs::create_directories(folder_ / "elsewhere");
  const fs::path copy = folder_ / "elsewhere/credence";
  fs::copy_file(credence_binary(), copy);
  for (const char* environment : {"OMPI_COMM_WORLD_SIZE=3", "PMI_SIZE=3", "SLURM_NTASKS=3 PMIX_RANK=0"}) {
    const Finished f = version_of(copy, environment);
    EXPECT_EQ(f.code, 2) << environment;
    EXPECT_EQ(f.out, "") << environment;
    EXPECT_THAT(f.err, ::testing::StartsWith(
                           "credence: 3 processes were started together, and MPI cannot be used (its part of "
                           "Credence is the Debian "
                           "package credence-mpi; a build has it where libopenmpi-dev is installed): " +
                           (fs::canonical(folder_.path()) / "elsewhere/libcredence_mpi.so").string() + ": "))
        << environment;
  }
  // The module that is there is the one that it tells of.
  write("elsewhere/libcredence_mpi.so", "no library");
  EXPECT_THAT(
      version_of(copy, "PMI_SIZE=2").err,
      ::testing::AllOf(::testing::StartsWith("credence: 2 processes were started together, and MPI cannot"),
                       ::testing::HasSubstr("elsewhere/libcredence_mpi.so: ")));
}

TEST_F(LaunchedRanks, SeveralOfWhichMpiKnowsNothingAreAnError) {
  if (!fs::exists(fs::path(credence_binary()).parent_path() / "libcredence_mpi.so")) {
    GTEST_SKIP() << "built without MPI";
  }
  // A launcher that says so, without one that MPI could ask.
  const Finished f = version_of(credence_binary(), "PMI_SIZE=2");
  EXPECT_EQ(f.code, 2);
  EXPECT_EQ(f.out, "");
  EXPECT_THAT(f.err, ::testing::HasSubstr("2 processes were started together, and MPI "));
}

}  // namespace
}  // namespace credence::internal
