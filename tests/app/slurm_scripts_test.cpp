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

// "%%" is a percent sign in the name of a file of output (sbatch, filename pattern). --chdir is no pattern by
// itself, but the path of a file that begins there is one with it: seen with Slurm 22.05, whose logs stand
// where these names say.
TEST(SlurmScripts, APercentSignInAFoldersNameIsNoSymbolOfSlurm) {
  SlurmSweep sweep = sweep_of_slurm();
  sweep.out = "10%j 5%";
  EXPECT_THAT(slurm_scripts(sweep).array, HasSubstr("#SBATCH --output=\"10%%j 5%%/slurm/%A_%a.log\"\n"));
  EXPECT_THAT(slurm_scripts(sweep).merge, HasSubstr("#SBATCH --output=\"10%%j 5%%/slurm/%j.log\"\n"));
  sweep.work = "/home/%u";
  const SlurmScripts scripts = slurm_scripts(sweep);
  EXPECT_THAT(scripts.array, HasSubstr("#SBATCH --output=\"/home/%%u/10%%j 5%%/slurm/%A_%a.log\"\n"));
  for (const std::string& script : {scripts.array, scripts.merge}) {
    EXPECT_THAT(script, HasSubstr("#SBATCH --chdir=\"/home/%u\"\n"));
  }
}

// Slurm takes every backslash out of the name of a file of output, which would be in another folder.
TEST(SlurmScripts, OutputOfAFolderWithABackslashGoesToSlurmsOwnFile) {
  SlurmSweep sweep = sweep_of_slurm();
  EXPECT_THAT(slurm_scripts(sweep).array, HasSubstr("--output=\"out/slurm/%A_%a.log\"\n"));
  sweep.out = "a\\b";
  const SlurmScripts scripts = slurm_scripts(sweep);
  EXPECT_THAT(scripts.array, Not(HasSubstr("--output")));
  EXPECT_THAT(scripts.merge, Not(HasSubstr("--output")));
}

}  // namespace
}  // namespace credence::internal
