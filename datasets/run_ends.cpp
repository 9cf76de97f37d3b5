#include "datasets/run_ends.h"

#include <fmt/format.h>

#include <algorithm>

namespace credence::internal {
namespace {

/// So much of a run is missing that it is no matter of its last rows.
bool is_early(std::int64_t end, std::int64_t whole) {
  constexpr std::int64_t kFewest = 10, kShare = 10;
  return whole - end >= std::max(kFewest, (whole + kShare - 1) / kShare);
}

}  // namespace

void RunEnds::Group::add(const Group& later) {
  if (runs == 0)
    *this = later;
  else
    runs += later.runs;
}

void RunEnds::begin_run(const std::string& name, bool can_be_judged) {
  end_run();
  name_ = name;
  open_ = true;
  open_failed_ = false;
  can_be_judged_ = can_be_judged;
  step_ = judged_to_ = longest_gap_ = 0;
}

void RunEnds::add(std::int64_t step, bool judged) {
  step_ = step;
  if (!judged) return;
  longest_gap_ = std::max(longest_gap_, step - judged_to_);
  judged_to_ = step;
}

void RunEnds::end_run() {
  if (!open_) return;
  open_ = false;
  ++runs_;
  failed_ += open_failed_ ? 1 : 0;
  if (open_failed_) return;
  const Group run{.runs = 1, .first = name_, .judged_to = judged_to_, .steps = step_};
  if (can_be_judged_ && judged_to_ > 0 && step_ - judged_to_ > longest_gap_ && is_early(judged_to_, step_))
    silent_.add(run);
  if (ragged_) return;
  by_length_[step_].add(run);
  if (by_length_.size() <= kMostLengths) return;
  by_length_.clear();
  ragged_ = true;
}

void RunEnds::merge(const RunEnds& later) {
  silent_.add(later.silent_);
  runs_ += later.runs_;
  failed_ += later.failed_;
  ragged_ = ragged_ || later.ragged_;
  for (const auto& [steps, group] : later.by_length_) by_length_[steps].add(group);
  ragged_ = ragged_ || by_length_.size() > kMostLengths;
  if (ragged_) by_length_.clear();
}

std::vector<std::string> RunEnds::sentences() const {
  constexpr const char* kFailure =
      "If the filter failed there, that is not counted: docs/formats.md says how a log tells it.";
  std::vector<std::string> all;
  const auto who = [](const Group& group) {
    return group.runs == 1 ? group.first : fmt::format("{} and {} more", group.first, group.runs - 1);
  };
  if (silent_.runs > 0) {
    all.push_back(fmt::format(
        "{} of {} runs {} rows on after the last with an estimate and its truth ({}: step {} of {}). {}",
        silent_.runs, runs_, silent_.runs == 1 ? "has" : "have", who(silent_), silent_.judged_to,
        silent_.steps, kFailure));
  }
  constexpr std::int64_t kFewest = 5;
  const auto usual =
      std::ranges::max_element(by_length_, {}, [](const auto& entry) { return entry.second.runs; });
  if (usual == by_length_.end() || usual->second.runs < kFewest ||
      10 * usual->second.runs < 9 * (runs_ - failed_))
    return all;
  Group early;
  for (const auto& [steps, group] : by_length_) {
    if (is_early(steps, usual->first)) early.add(group);
  }
  if (early.runs > 0) {
    all.push_back(fmt::format("{} of {} runs end{} early ({}: after {} of the {} steps of the others). {}",
                              early.runs, runs_, early.runs == 1 ? "s" : "", who(early), early.steps,
                              usual->first, kFailure));
  }
  return all;
}

}  // namespace credence::internal
