#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace credence::internal {

/// A sweep as jobs of Slurm: an array of which each task runs a shard, and a job that joins them.
struct SlurmSweep {
  std::string name;                  ///< of the jobs
  std::filesystem::path program;     ///< this one, as the nodes find it
  std::filesystem::path work;        ///< the folder in which all commands run
  std::filesystem::path out;         ///< of the joined results, from `work` on
  std::vector<std::string> sweep;    ///< words of the sweep: scenario and settings
  std::vector<std::string> options;  ///< further words of #SBATCH, a line each
  int tasks = 1;
  int threads = 1;                     ///< of each task
  std::string time_limit = "1:00:00";  ///< of each task, as Slurm writes it
};

/// Shell scripts; each is the whole of a file.
struct SlurmScripts {
  std::string array;   ///< sent with sbatch: a shard
  std::string merge;   ///< sent with sbatch when all shards are done: joins them and writes the report
  std::string submit;  ///< run with sh: sends both
};

/// The folder of the scripts, and that of the shards, within that of the results.
inline constexpr const char* kScriptFolder = "slurm";
inline constexpr const char* kShardFolder = "shards";

/// A task that is told to end, since its time is over or the node is wanted, stores what it has and puts
/// itself into the queue again, where it goes on. Throws std::invalid_argument for an option of several
/// lines.
SlurmScripts slurm_scripts(const SlurmSweep& sweep);

}  // namespace credence::internal
