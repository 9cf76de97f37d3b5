// The ranks of MPI, as a module of its own: what the program is linked with does not know MPI, and the
// program loads this only where mpirun or srun started it.

#include <mpi.h>

#include <mutex>
#include <stdexcept>
#include <thread>

#include "montecarlo/engine/growing_pause.h"
#include "montecarlo/engine/ranks.h"

namespace {

constexpr int kTag = 1;

class MpiRanks : public credence::internal::Ranks {
 public:
  MpiRanks() {
    int threads = MPI_THREAD_SINGLE;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &threads);
    if (threads < MPI_THREAD_SERIALIZED) {
      MPI_Finalize();
      throw std::runtime_error("this MPI serves no threads");
    }
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
  }
  ~MpiRanks() override { MPI_Finalize(); }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  int rank() const override { return rank_; }
  int count() const override { return count_; }

  void send(int to, std::span<const std::byte> message) override {
    MPI_Request request = MPI_REQUEST_NULL;
    {
      const std::lock_guard lock(mutex_);
      MPI_Isend(message.data(), static_cast<int>(message.size()), MPI_BYTE, to, kTag, MPI_COMM_WORLD,
                &request);
    }
    // MPI itself would wait by looking all the time.
    credence::internal::GrowingPause pause;
    while (!is_done(request)) std::this_thread::sleep_for(pause.next());
  }

  std::optional<Message> receive() override {
    const std::lock_guard lock(mutex_);
    int there = 0;
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &there, &handle, &status);
    if (there == 0) return std::nullopt;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    Message message{.from = status.MPI_SOURCE,
                    .bytes = std::vector<std::byte>(static_cast<std::size_t>(size))};
    MPI_Mrecv(message.bytes.data(), size, MPI_BYTE, &handle, MPI_STATUS_IGNORE);
    return message;
  }

 private:
  bool is_done(MPI_Request& request) {
    const std::lock_guard lock(mutex_);
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  }

  std::mutex mutex_;  // MPI_THREAD_SERIALIZED: one call at a time
  int rank_ = 0, count_ = 1;
};

}  // namespace

extern "C" credence::internal::Ranks* credence_open_ranks() { return new MpiRanks(); }
