#include "datasets/logs/run_fingerprints.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "datasets/data_error.h"
#include "montecarlo/scenario/scenario_hash.h"

namespace credence::internal {
namespace {

std::string_view bytes_of(const auto& number) {
  return {reinterpret_cast<const char*>(&number), sizeof(number)};
}

/// The numbers of a row, in no order.
struct RowSum {
  std::uint64_t sum = 0;
  std::int64_t numbers = 0;  ///< other than zero

  void add(const Vector& values) {
    for (const double value : values) {
      if (value == 0.0) continue;
      sum += stable_hash(bytes_of(value));
      ++numbers;
    }
  }
};

}  // namespace

void RunFingerprints::begin_file(const std::filesystem::path& file) {
  file_ = &file;
  in_file_ = 0;
}

void RunFingerprints::begin_run() {
  runs_.push_back({.file = file_, .number = ++in_file_});
  hash_ = 0;
  rows_ = numbers_ = 0;
}

void RunFingerprints::add(const Step& step) {
  RowSum row;
  row.add(step.error);
  for (const Innovation& innovation : step.innovations) row.add(innovation.nu);
  hash_ = stable_hash(bytes_of(row.sum), hash_);
  numbers_ += row.numbers;
  if (!std::has_single_bit(static_cast<std::uint64_t>(++rows_)) || numbers_ < kLeastNumbers) return;
  runs_.back().longest = rows_;
  beginnings_.push_back({.hash = hash_, .run = runs_.size() - 1, .rows = rows_});
}

void RunFingerprints::append(RunFingerprints later) {
  const std::size_t before = runs_.size();
  runs_.insert(runs_.end(), later.runs_.begin(), later.runs_.end());
  for (Beginning& beginning : later.beginnings_) {
    beginning.run += before;
    beginnings_.push_back(beginning);
  }
}

void RunFingerprints::require_distinct() {
  std::ranges::sort(beginnings_, {}, [](const Beginning& b) { return std::tie(b.rows, b.hash, b.run); });
  const auto whole = [&](const Beginning& b) { return runs_[b.run].longest == b.rows; };
  std::optional<std::pair<Beginning, Beginning>> found;  // the later one and the one before it
  for (auto begin = beginnings_.begin(); begin != beginnings_.end();) {
    const auto end = std::find_if(begin, beginnings_.end(), [&](const Beginning& b) {
      return b.rows != begin->rows || b.hash != begin->hash;
    });
    const auto again = whole(*begin) ? begin + 1 : std::find_if(begin + 1, end, whole);
    if (again < end && (!found || again->run < found->first.run)) found = {*again, *begin};
    begin = end;
  }
  if (!found) return;
  const Run &run = runs_[found->first.run], &other = runs_[found->second.run];
  const auto text = [](const Run& r, const std::string& name) {
    return r.number == 1 ? name : fmt::format("run {} of {}", r.number, name);
  };
  throw DataError(
      *run.file, "",
      fmt::format("{} has, in its first {} rows, the same errors and innovations to the last bit as {}: "
                  "independent runs cannot, and it would be counted twice",
                  text(run, "it"), found->first.rows,
                  run.file == other.file ? fmt::format("run {} of it", other.number)
                                         : text(other, other.file->string())));
}

}  // namespace credence::internal
