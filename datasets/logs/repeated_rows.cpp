#include "datasets/logs/repeated_rows.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

namespace credence::internal {
namespace {

constexpr std::uint64_t kBase = 0x9e3779b97f4a7c15U;

/// kBase to the power of the window.
constexpr std::uint64_t power(std::int64_t exponent) {
  std::uint64_t result = 1;
  for (std::int64_t i = 0; i < exponent; ++i) result *= kBase;
  return result;
}

std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

}  // namespace

void RepeatedRows::begin_run() {
  runs_.emplace_back();
  last_ = rolling_ = 0;
  counted_ = 0;
  recent_.assign(kWindow, 0);
  recent_rows_.assign(kWindow, 0);
}

void RepeatedRows::add_row(std::uint64_t hash) {
  Run& run = runs_.back();
  ++run.rows;
  if (hash == 0 || hash == std::exchange(last_, hash)) return;
  const auto place = static_cast<std::size_t>(counted_ % kWindow);
  rolling_ = rolling_ * kBase + hash - std::exchange(recent_[place], hash) * power(kWindow);
  recent_rows_[place] = run.rows;
  if (++counted_ < kWindow) return;
  const std::uint64_t window = mixed(rolling_);
  if (run.windows.size() == kKept && window > run.windows.rbegin()->first) return;
  const std::int64_t begin = recent_rows_[static_cast<std::size_t>(counted_ % kWindow)];
  const auto [kept, is_new] = run.windows.try_emplace(window, Window{.row = begin});
  if (!is_new && kept->second.again == 0) kept->second.again = begin;
  if (run.windows.size() > kKept) run.windows.erase(std::prev(run.windows.end()));
}

void RepeatedRows::worth(double bits) {
  runs_.back().bits_per_row = bits / static_cast<double>(runs_.back().rows);
}

void RepeatedRows::append(RepeatedRows later) { std::ranges::move(later.runs_, std::back_inserter(runs_)); }

bool RepeatedRows::enough(const Run& run, std::int64_t rows, double all_rows) {
  constexpr double kBits = 20.0;
  return static_cast<double>(rows) * run.bits_per_row >= 2.0 * std::log2(all_rows) + kBits;
}

std::vector<RepeatedRows::Stretch> RepeatedRows::stretches() const {
  constexpr std::int64_t kFewest = 4;
  double all_rows = 0.0;
  for (const Run& run : runs_) all_rows += static_cast<double>(run.rows);

  /// The longest stretch of matches at one distance with no kept window between that has none.
  const auto longest = [&](std::vector<Match> matches, std::size_t r, std::size_t o) -> std::vector<Stretch> {
    const Run &run = runs_[r], &other = runs_[o];
    std::uint64_t most = std::min(run.windows.rbegin()->first, other.windows.rbegin()->first);
    std::vector<std::pair<std::int64_t, std::int64_t>> places;  // of all that both would keep: row, distance
    for (const auto& [hash, window] : run.windows) {
      if (hash <= most) places.emplace_back(r == o && window.again != 0 ? window.again : window.row, 0);
    }
    for (auto& [row, distance] : places) {
      const auto match = std::ranges::find(matches, row, &Match::row);
      if (match != matches.end()) distance = row - match->other;
    }
    std::ranges::sort(places);
    Stretch best;
    std::int64_t best_count = 0, count = 0, first = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto [row, distance] = places[i];
      if (distance == 0) {
        count = 0;
        continue;
      }
      if (count == 0 || distance != places[i - 1].second) {
        count = 0;
        first = row;
      }
      if (++count <= best_count) continue;
      best_count = count;
      best = {
          .run = r, .other = o, .first = first, .last = row + kWindow - 1, .other_first = first - distance};
    }
    if (best_count < kFewest || !enough(run, best.last - best.first + 1, all_rows)) return {};
    return {best};
  };

  std::vector<Stretch> found;
  const auto keep = [&found](std::vector<Stretch> more) {
    std::ranges::move(more, std::back_inserter(found));
  };
  std::vector<std::tuple<std::uint64_t, std::size_t, std::int64_t>> all;  // hash, run, row
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    std::vector<Match> matches;
    for (const auto& [hash, window] : runs_[r].windows) {
      all.emplace_back(hash, r, window.row);
      if (window.again != 0) matches.push_back({.row = window.again, .other = window.row});
    }
    if (std::ssize(matches) >= kFewest) keep(longest(std::move(matches), r, r));
  }
  std::ranges::sort(all);
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Match>> shared;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const auto [hash, run, row] = all[i];
    const auto [other_hash, other, other_row] = all[i - 1];
    if (hash == other_hash && row != other_row)
      shared[{run, other}].push_back({.row = row, .other = other_row});
  }
  for (auto& [pair, matches] : shared) {
    if (std::ssize(matches) >= kFewest) keep(longest(std::move(matches), pair.first, pair.second));
  }
  return found;
}

}  // namespace credence::internal
