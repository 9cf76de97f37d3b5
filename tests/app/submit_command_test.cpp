// An array job of Slurm: its scripts with programs in the place of Slurm's, and with Slurm itself where it is
// installed (slurm-wlm) and the test may start it.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <filesystem>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

const std::string kSubmittedSweep =
    "[world]\nmodel = \"monobot\"\n[study]\nruns = 200\nsteps = 20\n[sweep]\n\"world.landmarks\" = \"1:3\"\n";

class SubmitCommand : public CommandTest {
 protected:
  /// A program in a folder that comes first in PATH.
  void fake(const std::string& name, const std::string& script) const {
    fs::create_directories(folder_ / "bin");
    write(fs::path("bin") / name, "#!/bin/sh\n" + script);
    fs::permissions(folder_ / "bin" / name, fs::perms::owner_all);
  }

  Finished shell(const std::string& command) const {
    return finish(start_program({"sh", "-c", "PATH=" + (folder_ / "bin").string() + ":$PATH; " + command}));
  }

  void expect_same_as_one_process(const std::string& folder, int chunks = 12) const {
    EXPECT_EQ(run({"sweep", "s.toml", "--out", "alone"}).code, 0);
    const Finished f = run({"merge", "alone", folder, "--out", "both"});
    EXPECT_EQ(f.out, fmt::format("alone: {0} chunks added, 0 there already\n"
                                 "{1}: 0 chunks added, {0} there already\n",
                                 chunks, folder));
    EXPECT_TRUE(fs::exists(folder_ / folder / "index.html"));
  }
};

TEST_F(SubmitCommand, AMachineWithoutSlurmIsToldWhereToSendTheScripts) {
  write("s.toml", kSubmittedSweep);
  fake("sh", "exec /bin/sh \"$@\"\n");  // the only program that is found
  const Finished f = finish(
      start_program({"sh", "-c",
                     "PATH=" + (folder_ / "bin").string() + ":/nowhere; " + credence_binary().string() +
                         " submit s.toml --slurm --tasks 3 --submit --out job"}));
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("no sbatch; the scripts are written, to be sent from one that has: sh "),
            std::string::npos)
      << f.err;
  EXPECT_TRUE(fs::exists(folder_ / "job/slurm/submit.sh"));
}

TEST_F(SubmitCommand, TheScriptsDoWhatOneProcessDoes) {
  write("s.toml", kSubmittedSweep);
  // Runs a job at once, as Slurm would: the tasks of an array one after the other.
  fake("sbatch",
       "for script; do :; done\necho \"$@\" >> sent\n"
       "tasks=$(sed -n 's/#SBATCH --array=1-//p' \"$script\")\n"
       "for task in $(seq ${tasks:-1}); do SLURM_ARRAY_TASK_ID=$task sh \"$script\" >&2 || exit; done\n"
       "echo '41;cluster'\n");
  const Finished f =
      shell(credence_binary().string() +
            " submit s.toml --slurm --tasks 3 --submit --out 'my job' --sbatch=--partition=short");
  EXPECT_EQ(f.code, 0) << f.err;
  EXPECT_NE(f.out.find("array job 41 (3 tasks), then job 41, which joins them"), std::string::npos) << f.out;
  EXPECT_NE(f.out.find("credence show 'my job'/shards"), std::string::npos) << f.out;
  EXPECT_NE(read("sent").find("--dependency=afterok:41"), std::string::npos) << read("sent");
  const std::string script = read("my job/slurm/array.sh");
  for (const char* line :
       {"#SBATCH --array=1-3\n", "#SBATCH --time=1:00:00\n", "#SBATCH --signal=B:TERM@30\n",
        "#SBATCH --requeue\n", "#SBATCH --partition=short\n"}) {
    EXPECT_NE(script.find(line), std::string::npos) << line << script;
  }
  expect_same_as_one_process("my job");
}

TEST_F(SubmitCommand, ATaskThatIsToldToEndIsQueuedAgain) {
  write("s.toml", kSubmittedSweep);
  fake("scontrol", "echo \"$@\" > requeued\n");
  EXPECT_EQ(run({"submit", "s.toml", "--slurm", "--tasks", "2", "--runs", "1000000000", "--out", "o"}).code,
            0);
  const pid_t task = start_program({"env", "SLURM_ARRAY_TASK_ID=2", "SLURM_JOB_ID=7",
                                    "PATH=" + (folder_ / "bin").string() + ":" + getenv("PATH"), "sh",
                                    (folder_ / "o/slurm/array.sh").string()});
  const fs::path log = folder_ / "o/shards/2/results.sqlite-wal";
  wait_for([&] {
    std::error_code none;
    return fs::file_size(log, none) > 60000 && !none;
  });
  kill(task, SIGTERM);
  EXPECT_EQ(finish(task).code, 130);
  EXPECT_EQ(read("requeued"), "requeue 7\n");
}

TEST_F(SubmitCommand, ATimeThatSbatchDoesNotTakeIsRefused) {
  write("s.toml", kSubmittedSweep);
  for (const char* time : {"abc", "0:0:0", "-1", "1:2:3:4", "10\n#SBATCH --x"}) {
    const Finished f =
        run({"submit", "s.toml", "--slurm", "--tasks", "3", "--out", "job", std::string("--time=") + time});
    EXPECT_EQ(f.code, 2) << time;
    EXPECT_NE(f.err.find("expected a time as sbatch takes it"), std::string::npos) << f.err;
  }
  for (const char* time : {"30", "45:00", "1-12", "1-12:00:00"}) {
    EXPECT_EQ(
        run({"submit", "s.toml", "--slurm", "--tasks", "3", "--out", "job", std::string("--time=") + time})
            .code,
        0)
        << time;
  }
}

TEST_F(SubmitCommand, WhatCannotBeDividedIsRefused) {
  write("s.toml", kSubmittedSweep);
  const auto refused = [&](std::vector<std::string> more) {
    std::vector<std::string> all{"submit", "s.toml", "--out", "o"};
    all.insert(all.end(), more.begin(), more.end());
    const Finished f = run(all);
    EXPECT_EQ(f.code, 2);
    EXPECT_FALSE(fs::exists(folder_ / "o"));
    return f.err;
  };
  EXPECT_NE(refused({"--slurm", "--tasks", "13"}).find("--tasks 13: there is work for at most 12"),
            std::string::npos);
  EXPECT_NE(refused({"--tasks", "2"}).find("--slurm"), std::string::npos);
  EXPECT_NE(refused({"--slurm", "--tasks", "2", "--set", "study.stop.precision=0.1"}).find("study.stop"),
            std::string::npos);
  EXPECT_NE(refused({"--slurm", "--tasks", "2", "--sbatch", "--a\n#SBATCH --b"}).find("--sbatch: one option"),
            std::string::npos);
}

/// A cluster of this machine alone, with a controller and a daemon of its own for as long as it lives.
class LocalSlurm : public SubmitCommand {
 protected:
  void SetUp() override {
    if (std::system("command -v slurmctld slurmd sbatch > /dev/null") != 0)
      GTEST_SKIP() << "slurm-wlm is not installed";
    if (geteuid() != 0) GTEST_SKIP() << "only root may start slurmd";
    fs::create_directories(folder_ / "state");
    fs::create_directories(folder_ / "spool");
    const std::string root = folder_.path().string(),
                      cores = std::to_string(std::thread::hardware_concurrency());
    char host[256] = {};
    gethostname(host, sizeof host - 1);
    write(
        "slurm.conf",
        "ClusterName=test\nSlurmctldHost=" + std::string(host) + "(127.0.0.1)\nSlurmctldPort=" + free_port() +
            "\nSlurmdPort=" + free_port() +
            "\nAuthType=auth/none\nCredType=cred/none\nSlurmUser=root\nSlurmdUser=root\nStateSaveLocation=" +
            root + "/state\nSlurmdSpoolDir=" + root + "/spool\nSlurmctldPidFile=" + root +
            "/controller.pid\nSlurmdPidFile=" + root +
            "/daemon.pid\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nMpiDefault=none\n"
            "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\nSchedulerType=sched/builtin\n"
            "ReturnToService=2\nNodeName=" +
            host + " NodeAddr=127.0.0.1 CPUs=" + cores +
            " State=UNKNOWN\nPartitionName=all Nodes=ALL Default=YES State=UP\n");
    setenv("SLURM_CONF", (folder_ / "slurm.conf").c_str(), 1);
    controller_ = start_quietly({"slurmctld", "-D", "-c"});
    daemon_ = start_quietly({"slurmd", "-D"});
    if (!waited("sinfo -h -o %T | grep -q idle")) GTEST_SKIP() << "Slurm does not start here";
  }

  void TearDown() override {
    for (const pid_t process : {daemon_, controller_}) {
      if (process <= 0) continue;
      kill(process, SIGTERM);
      waitpid(process, nullptr, 0);
    }
    unsetenv("SLURM_CONF");
  }

  /// Whether a command of the shell succeeds within half a minute.
  static bool waited(const std::string& command) {
    for (int i = 0; i < 150; ++i) {
      if (std::system(("{ " + command + "; } > /dev/null 2>&1").c_str()) == 0) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    return false;
  }

 private:
  static std::string free_port() {
    const int descriptor = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    socklen_t size = sizeof address;
    bind(descriptor, reinterpret_cast<sockaddr*>(&address), size);
    getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
    close(descriptor);
    return std::to_string(ntohs(address.sin_port));
  }

  pid_t start_quietly(std::vector<std::string> words) const {
    return start_program({"sh", "-c",
                          "exec " + words[0] + " " + words[1] + (words.size() > 2 ? " " + words[2] : "") +
                              " > " + words[0] + ".log 2>&1"});
  }

  pid_t controller_ = 0, daemon_ = 0;
};

TEST_F(LocalSlurm, AnArrayJobHasTheResultsOfOneProcess) {
  write("s.toml", kSubmittedSweep);
  const Finished f = run({"submit", "s.toml", "--slurm", "--tasks", "3", "--submit", "--out", "job"});
  ASSERT_EQ(f.code, 0) << f.err << read("slurmctld.log");
  EXPECT_TRUE(waited("test -e " + (folder_ / "job/index.html").string())) << f.out << read("slurmd.log");
  EXPECT_TRUE(waited("test -z \"$(squeue -h)\""));
  expect_same_as_one_process("job");
}

TEST_F(LocalSlurm, AKilledTaskSubmittedAgainChangesNoBit) {
  write("s.toml",
        "[world]\nmodel = \"planar\"\nlandmarks = 4\n[study]\nruns = 4096\nsteps = 200\n"
        "[sweep]\n\"filter.process_scale\" = [0.5, 1.0, 2.0]\n");
  ASSERT_EQ(run({"submit", "s.toml", "--slurm", "--tasks", "2", "--submit", "--out", "job"}).code, 0);
  const fs::path stored = folder_ / "job/shards/2/results.sqlite-wal";
  const auto bytes_stored = [&] {
    std::error_code none;
    const auto size = fs::file_size(stored, none);
    return none ? 0 : size;
  };
  wait_for([&] { return bytes_stored() > 100'000; });
  EXPECT_EQ(std::system("scancel --signal=KILL --full $(squeue -h -r -t R -o %i | grep _2)"), 0);
  EXPECT_TRUE(waited("test -z \"$(squeue -h -r -t R)\""));
  EXPECT_FALSE(fs::exists(folder_ / "job/index.html")) << "was killed after its end";
  EXPECT_EQ(std::system("scancel --state=PENDING --user=root"), 0);  // what was to join the shards
  EXPECT_EQ(finish(start_program({"sh", (folder_ / "job/slurm/submit.sh").string()})).code, 0);
  EXPECT_TRUE(waited("test -e " + (folder_ / "job/index.html").string())) << read("slurmd.log");
  EXPECT_TRUE(waited("test -z \"$(squeue -h)\""));
  expect_same_as_one_process("job", 192);
}

}  // namespace
}  // namespace credence::internal
