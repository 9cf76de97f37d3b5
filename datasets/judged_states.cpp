#include "datasets/judged_states.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/append_item.h"

namespace credence::internal {

std::size_t JudgedStates::place_of(const std::string& name) {
  const auto found = std::ranges::find(names_, name);
  if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
  names_.push_back(name);
  judged_.push_back(false);
  return names_.size() - 1;
}

void JudgedStates::begin_run(const std::string& name, const RunLayout& layout) {
  ends_.begin_run(name, layout.has_truth && !layout.states.empty());
  place_.clear();
  open_ = 0;
  has_truth_ = layout.has_truth && !layout.states.empty();
  if (!layout.has_truth) return;
  if (names_.empty()) {
    names_ = layout.states;
    judged_.assign(names_.size(), false);
  }
  const bool same = names_ == layout.states;
  for (std::size_t i = 0; i < layout.states.size(); ++i)
    place_.push_back(same ? i : place_of(layout.states[i]));
  open_ = static_cast<std::size_t>(
      std::ranges::count_if(place_, [this](std::size_t place) { return !judged_[place]; }));
}

void JudgedStates::add(const Step& step) {
  ends_.add(step.step, !step.states.empty());
  if (has_truth_) {
    ++rows_;
    silent_ += step.states.empty() ? 1 : 0;
  }
  if (open_ == 0) return;
  for (const Index state : step.states) {
    const std::size_t place = place_[static_cast<std::size_t>(state)];
    if (judged_[place]) continue;
    judged_[place] = true;
    --open_;
  }
}

void JudgedStates::merge(const JudgedStates& later) {
  ends_.merge(later.ends_);
  rows_ += later.rows_;
  silent_ += later.silent_;
  for (std::size_t i = 0; i < later.names_.size(); ++i) {
    const std::size_t place = place_of(later.names_[i]);
    if (later.judged_[i]) judged_[place] = true;
  }
}

std::string JudgedStates::never_judged() const {
  constexpr std::size_t kMost = 8;
  std::vector<std::string> never;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (!judged_[i]) never.push_back(names_[i]);
  }
  // Where no state is judged, there is no truth to speak of.
  if (never.empty() || never.size() == names_.size()) return {};
  return fmt::format("No row has an estimate and a truth of {}, which {} not judged.",
                     first_items(never, kMost), never.size() == 1 ? "is" : "are");
}

std::vector<std::string> JudgedStates::sentences() const {
  std::vector<std::string> all = ends_.sentences();
  if (std::string never = never_judged(); !never.empty()) all.insert(all.begin(), std::move(never));
  if (silent_ > 0 && silent_ < rows_)
    all.push_back(fmt::format("{} of {} rows have no estimate with its truth.", silent_, rows_));
  return all;
}

}  // namespace credence::internal
