#include "app/slurm_scripts.h"

#include <gmock/gmock.h>

#include <stdexcept>

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

SlurmSweep sweep_of_slurm() {
  return {.name = "credence-s",
          .program = "/opt/credence",
          .work = "/home/a",
          .out = "out",
          .sweep = {"s.toml", "--set", "world.model=\"x\""},
          .options = {"--partition=long"},
          .tasks = 7,
          .threads = 3};
}

TEST(SlurmScripts, EveryTaskHasItsShardItsThreadsAndItsOptions) {
  const SlurmScripts scripts = slurm_scripts(sweep_of_slurm());
  for (const char* line : {"#SBATCH --array=1-7\n", "#SBATCH --cpus-per-task=3\n", "#SBATCH --time=1:00:00\n",
                           "#SBATCH --partition=long\n", "#SBATCH --chdir=\"/home/a\"\n",
                           "--threads 3 --shard \"$SLURM_ARRAY_TASK_ID/7\""}) {
    EXPECT_THAT(scripts.array, HasSubstr(line));
  }
  EXPECT_THAT(scripts.array, HasSubstr("'world.model=\"x\"'"));
  EXPECT_THAT(scripts.merge, HasSubstr("#SBATCH --partition=long\n"));
  EXPECT_THAT(scripts.merge, Not(HasSubstr("--array"))) << "it is one job";
}

TEST(SlurmScripts, NoOptionIsOfSeveralLines) {
  SlurmSweep sweep = sweep_of_slurm();
  sweep.options = {"--partition=a\nrm -r x"};
  EXPECT_THROW(slurm_scripts(sweep), std::invalid_argument);
}

// Between the double quotes of #SBATCH a quote and a backslash stand behind a backslash.
TEST(SlurmScripts, AQuoteInAFoldersNameEndsNoWord) {
  SlurmSweep sweep = sweep_of_slurm();
  sweep.work = "/home/a \"b\" \\c";
  sweep.name = "credence-\"";
  const SlurmScripts scripts = slurm_scripts(sweep);
  for (const std::string& script : {scripts.array, scripts.merge}) {
    EXPECT_THAT(script, HasSubstr(R"(#SBATCH --chdir="/home/a \"b\" \\c")"));
    EXPECT_THAT(script, HasSubstr(R"(#SBATCH --job-name="credence-\")"));
  }
}

}  // namespace
}  // namespace credence::internal
