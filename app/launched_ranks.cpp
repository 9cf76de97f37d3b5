#include "app/launched_ranks.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "montecarlo/engine/shared_tasks.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

/// How many processes a launcher of MPI says that it started: Open MPI's mpirun, one that speaks PMI, or srun
/// with such a plugin.
int launched_count() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    if (const char* count = std::getenv(name)) return std::atoi(count);
  }
  const char* tasks = std::getenv("SLURM_NTASKS");
  return tasks != nullptr && std::getenv("PMIX_RANK") != nullptr ? std::atoi(tasks) : 1;
}

/// While it lives this process ends with the one that started it: ranks that are to find each other wait for
/// a launcher that was killed for ever.
class EndsWithLauncher {
 public:
  EndsWithLauncher() { prctl(PR_SET_PDEATHSIG, SIGKILL); }
  ~EndsWithLauncher() { prctl(PR_SET_PDEATHSIG, 0); }
  EndsWithLauncher(const EndsWithLauncher&) = delete;
  EndsWithLauncher& operator=(const EndsWithLauncher&) = delete;
};

Ranks* open_ranks() {
  const EndsWithLauncher meanwhile;
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
  constexpr const char* kModule = "libcredence_mpi.so";
  std::string why;
  for (const fs::path& file : {here / kModule, here / "../lib/credence" / kModule}) {
    // Open MPI's own plugins look for its symbols among those of the whole process.
    if (void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_GLOBAL)) {
      const auto open = reinterpret_cast<Ranks* (*)()>(dlsym(module, "credence_open_ranks"));
      if (open != nullptr) return open();
    }
    if (const char* error = dlerror(); error != nullptr && (why.empty() || fs::exists(file))) why = error;
  }
  throw std::runtime_error(fmt::format(
      "{} processes were started together, and MPI cannot be used (its part of Credence is the Debian "
      "package credence-mpi; a build has it where libopenmpi-dev is installed): {}",
      launched_count(), why));
}

void silence() {
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  close(nowhere);
}

std::unique_ptr<Ranks>& joined() {
  static std::unique_ptr<Ranks> ranks = [] {
    std::unique_ptr<Ranks> opened(launched_count() > 1 ? open_ranks() : nullptr);
    if (opened != nullptr && opened->count() != launched_count()) {
      throw std::runtime_error(fmt::format("{} processes were started together, and MPI knows of {}",
                                           launched_count(), opened->count()));
    }
    if (is_helper(opened.get())) silence();
    return opened;
  }();
  return ranks;
}

}  // namespace

Ranks* launched_ranks() { return joined().get(); }

void leave_ranks() {
  if (joined() == nullptr) return;
  finish_ranks(*joined());
  joined().reset();
}

}  // namespace credence::internal
