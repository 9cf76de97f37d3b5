#include "app/slurm_scripts.h"

#include <fmt/format.h>

#include <stdexcept>

#include "app/shell_word.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

/// A word in a line that Slurm reads, which is none of the shell.
std::string slurm_word(const std::string& text) {
  std::string word = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') word += '\\';
    word += c;
  }
  return word + '"';
}

/// Where a job's output goes: into the folder of the scripts, under a name that Slurm makes of `pattern`. In
/// a pattern %% is a percent sign, and Slurm reads a path from the work folder on together with that folder
/// (seen of 22.05). A backslash cannot stand there, as Slurm takes every one away and then reads no symbol;
/// the output of such a folder goes to the file that Slurm has for it, in the work folder.
std::vector<std::string> log_option(const SlurmSweep& sweep, const char* pattern) {
  const bool symbol_before = sweep.work.string().find('%') != std::string::npos;
  const fs::path folder = symbol_before ? sweep.work / sweep.out : sweep.out;
  std::string name;
  for (const char c : (folder / kScriptFolder).string()) {
    if (c == '\\') return {};
    name += c == '%' ? "%%" : std::string(1, c);
  }
  return {"--output=" + slurm_word((fs::path(name) / pattern).string())};
}

/// The lines that Slurm reads.
std::string directives(const SlurmSweep& sweep, const std::vector<std::string>& own,
                       const char* log_pattern) {
  std::string text;
  const auto add = [&](const std::string& option) {
    if (option.find('\n') != std::string::npos) {
      throw std::invalid_argument(fmt::format("--sbatch: one option a time, and one line: {}", option));
    }
    text += fmt::format("#SBATCH {}\n", option);
  };
  add("--chdir=" + slurm_word(sweep.work.string()));
  for (const std::string& option : own) add(option);
  for (const std::string& option : log_option(sweep, log_pattern)) add(option);
  for (const std::string& option : sweep.options) add(option);
  return text;
}

/// A command with its words.
std::string command_line(const SlurmSweep& sweep, const std::vector<std::string>& words) {
  std::string line = shell_word(sweep.program.string());
  for (const std::string& word : words) line += fmt::format(" {}", shell_word(word));
  return line;
}

std::string array_script(const SlurmSweep& sweep) {
  std::vector<std::string> words{"sweep"};
  words.insert(words.end(), sweep.sweep.begin(), sweep.sweep.end());
  for (const char* word : {"--quiet", "--threads"}) words.emplace_back(word);
  words.push_back(std::to_string(sweep.threads));
  const std::string shard = (sweep.out / kShardFolder).string();
  return fmt::format(
      R"(#!/bin/sh
{}
# Slurm tells this shell, and this tells the program, which stores what it has and ends with 130; then the
# task is queued again and goes on.
{} --shard "$SLURM_ARRAY_TASK_ID/{}" --out {}/"$SLURM_ARRAY_TASK_ID" &
program=$!
trap 'kill -TERM "$program" 2>/dev/null' TERM
wait "$program"
code=$?
while kill -0 "$program" 2>/dev/null; do
  wait "$program"
  code=$?
done
if [ "$code" -eq 130 ]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit "$code"
)",
      directives(
          sweep,
          {"--job-name=" + slurm_word(sweep.name), fmt::format("--array=1-{}", sweep.tasks),
           fmt::format("--cpus-per-task={}", sweep.threads), fmt::format("--time={}", sweep.time_limit),
           "--signal=B:TERM@30", "--requeue", "--open-mode=append"},
          "%A_%a.log"),
      command_line(sweep, words), sweep.tasks, shell_word(shard));
}

std::string merge_script(const SlurmSweep& sweep) {
  const std::string out = shell_word(sweep.out.string());
  const std::string program = shell_word(sweep.program.string());
  return fmt::format(
      "#!/bin/sh\n{}\nset -e\n{} merge {}/{}/* --out {}\n{} report {}\n",
      directives(sweep,
                 {"--job-name=" + slurm_word(sweep.name + "-merge"),
                  fmt::format("--time={}", sweep.time_limit), "--requeue", "--open-mode=append"},
                 "%j.log"),
      program, out, kShardFolder, out, program, out);
}

std::string submit_script(const SlurmSweep& sweep) {
  const fs::path scripts = sweep.work / sweep.out / kScriptFolder;
  return fmt::format(
      R"(#!/bin/sh
# Sends the array, and the job that joins its shards when all of them are done.
set -e
array=$(sbatch --parsable {})
array=${{array%%;*}}
merge=$(sbatch --parsable --dependency="afterok:$array" {})
echo "array job $array ({} tasks), then job ${{merge%%;*}}, which joins them"
)",
      shell_word((scripts / "array.sh").string()), shell_word((scripts / "merge.sh").string()), sweep.tasks);
}

}  // namespace

SlurmScripts slurm_scripts(const SlurmSweep& sweep) {
  return {array_script(sweep), merge_script(sweep), submit_script(sweep)};
}

}  // namespace credence::internal
