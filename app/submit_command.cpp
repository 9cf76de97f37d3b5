#include <fmt/format.h>
#include <sys/wait.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <regex>
#include <stdexcept>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/scenario_files.h"
#include "app/shell_word.h"
#include "app/slurm_scripts.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario.h"
#include "reports/render/atomic_file.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

struct SubmitCommand : CommonOptions {
  std::string scenario;
  SlurmSweep sweep;
  bool slurm = false, send = false;
};

void require_divisible(const SweepPlan& plan, int tasks) {
  std::int64_t chunks = 0;
  for (const SweepPoint& point : plan.points) {
    if (point.scenario.stop.asked()) {
      throw ScenarioError(
          "study.stop must see the runs in their order, which shards do not have; mpirun does");
    }
    chunks += (point.scenario.study.runs + kChunkRuns - 1) / kChunkRuns;
  }
  if (tasks <= chunks) return;
  throw ScenarioError(fmt::format("--tasks {}: there is work for at most {}, one for each chunk of {} runs",
                                  tasks, chunks, kChunkRuns));
}

/// As sbatch reads it: minutes, M:S, H:M:S, D-H, D-H:M or D-H:M:S, and more than none.
void require_time_limit(const std::string& time) {
  static const std::regex kTime("[0-9]+(:[0-9]{1,2}){0,2}|[0-9]+-[0-9]{1,2}(:[0-9]{1,2}){0,2}");
  const bool none = time.find_first_of("123456789") == std::string::npos;
  if (std::regex_match(time, kTime) && !none) return;
  throw ScenarioError(
      fmt::format("--time {}: expected a time as sbatch takes it, above 0: 30 (minutes), 45:00, 2:00:00, "
                  "1-12 or 1-12:00:00",
                  printable_line(time)));
}

int submit(SubmitCommand& command) {
  if (!command.slurm) throw ScenarioError("say for which system: --slurm");
  require_time_limit(command.sweep.time_limit);
  const SweepPlan plan = open_sweep(command.scenario, command.overrides());
  SlurmSweep& sweep = command.sweep;
  require_divisible(plan, sweep.tasks);
  sweep.name = "credence-" + plan.name;
  sweep.program = fs::read_symlink("/proc/self/exe");
  sweep.work = fs::current_path();
  sweep.out = command.out.empty() ? default_directory(plan) : fs::path(command.out);
  sweep.threads = std::max(1, command.threads);
  sweep.sweep.push_back(command.scenario);
  for (const std::string& setting : command.overrides()) {
    sweep.sweep.emplace_back("--set");
    sweep.sweep.push_back(setting);
  }
  const SlurmScripts scripts = slurm_scripts(sweep);
  const fs::path folder = sweep.out / kScriptFolder;
  make_directories(folder);
  make_directories(sweep.out / kShardFolder);
  write_file(folder / "array.sh", scripts.array);
  write_file(folder / "merge.sh", scripts.merge);
  write_file(folder / "submit.sh", scripts.submit);
  const std::string send = "sh " + shell_word((folder / "submit.sh").string());
  const std::string out = printable_line(shell_word(sweep.out.string()));
  if (command.send) {
    const int status = std::system(send.c_str());
    constexpr int kNoSuchCommand = 127;
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNoSuchCommand) {
      throw std::runtime_error(
          "this machine has no sbatch; the scripts are written, to be sent from one that has: " + send);
    }
    if (status != 0) throw std::runtime_error("sbatch did not take the jobs: " + send);
  } else {
    fmt::print("Written; this sends it:   {}\n", printable_line(send));
  }
  fmt::print("How far it is:            credence show {}/{}\nThe report, when joined:  {}/index.html\n", out,
             kShardFolder, out);
  return kDone;
}

}  // namespace

void add_submit_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("submit", "a sweep as an array job of Slurm, with the job that joins its shards");
  auto options = std::make_shared<SubmitCommand>();
  command->add_option("scenario", options->scenario, "scenario file, with or without a [sweep] table")
      ->required();
  command->add_flag("--slurm", options->slurm, "write the scripts of Slurm");
  command
      ->add_option("--tasks", options->sweep.tasks, "tasks of the array, each with its share of the chunks")
      ->check(CLI::Range(1, 1'000'000))
      ->required();
  command
      ->add_option("--time", options->sweep.time_limit,
                   "time limit of a task; one that needs more goes on in another")
      ->type_name("H:MM:SS")
      ->capture_default_str();
  command
      ->add_option("--sbatch", options->sweep.options,
                   "a further option of sbatch, as in --sbatch=--partition=long (repeatable)")
      ->allow_extra_args(false);
  command->add_flag("--submit", options->send, "send the jobs, too");
  add_setting_option(*command, *options);
  add_study_options(*command, *options);
  command->add_option("--threads", options->threads, "threads of each task")
      ->check(CLI::Range(1, 4096))
      ->default_val(1);
  command
      ->add_option("--out", options->out,
                   "folder for scripts, shards and results, seen by all nodes; without it as of sweep")
      ->type_name("DIR")
      ->check(writable_folder);
  static constexpr const char* kExamples[] = {
      "credence submit mistuned_sweep --slurm --tasks 8 --out out/job",
      "credence submit mistuned_sweep --slurm --tasks 8 --time 0:20:00 --sbatch=--partition=short --submit"};
  command->footer(scenario_examples(kExamples));
  command->callback([options] { throw ExitStatus{submit(*options)}; });
}

}  // namespace credence::internal
