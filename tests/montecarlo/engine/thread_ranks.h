#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "montecarlo/engine/ranks.h"

namespace credence::internal {

/// Ranks that are threads of one process.
class ThreadRanks : public Ranks {
 public:
  struct Post {
    explicit Post(int ranks) : boxes(static_cast<std::size_t>(ranks)) {}
    std::mutex mutex;
    std::vector<std::deque<Message>> boxes;
  };

  ThreadRanks(std::shared_ptr<Post> post, int rank) : post_(std::move(post)), rank_(rank) {}

  int rank() const override { return rank_; }
  int count() const override { return static_cast<int>(post_->boxes.size()); }
  void send(int to, std::span<const std::byte> message) override {
    const std::lock_guard lock(post_->mutex);
    post_->boxes[static_cast<std::size_t>(to)].push_back({rank_, {message.begin(), message.end()}});
  }
  std::optional<Message> receive() override {
    const std::lock_guard lock(post_->mutex);
    auto& box = post_->boxes[static_cast<std::size_t>(rank_)];
    if (box.empty()) return std::nullopt;
    Message message = std::move(box.front());
    box.pop_front();
    return message;
  }

 private:
  std::shared_ptr<Post> post_;
  int rank_;
};

/// Calls work(rank) for so many ranks at once, rank 0 on this thread.
inline void on_ranks(int count, const std::function<void(ThreadRanks&)>& work) {
  const auto post = std::make_shared<ThreadRanks::Post>(count);
  std::vector<std::jthread> helpers;
  for (int rank = 1; rank < count; ++rank) {
    helpers.emplace_back([post, rank, &work] {
      ThreadRanks ranks(post, rank);
      work(ranks);
    });
  }
  ThreadRanks ranks(post, 0);
  work(ranks);
}

}  // namespace credence::internal
