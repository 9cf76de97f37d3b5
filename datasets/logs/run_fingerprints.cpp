#include "datasets/logs/run_fingerprints.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "datasets/data_error.h"
#include "datasets/logs/run_name.h"
#include "montecarlo/scenario/scenario_hash.h"

namespace credence::internal {
namespace {

std::string_view bytes_of(const std::uint64_t& number) {
  return {reinterpret_cast<const char*>(&number), sizeof(number)};
}

/// The bits of a number, scattered.
std::uint64_t scattered(double value) {
  constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15U;
  std::uint64_t bits = std::bit_cast<std::uint64_t>(value);
  bits = (bits ^ (bits >> 32)) * kOdd;
  return (bits ^ (bits >> 29)) * kOdd;
}

/// Those other than zero, in no order.
std::uint64_t sum_of(const Vector& numbers) {
  std::uint64_t sum = 0;
  for (const double value : numbers) {
    if (value != 0.0) sum += scattered(value);
  }
  return sum;
}

std::span<const double> span_of(const Vector& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

}  // namespace

void RunFingerprints::CoincidenceBits::add_row(const std::vector<double>& numbers) {
  double of_row = 0.0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const bool held = before_.size() == numbers.size() && before_[i] == numbers[i];
    if (numbers[i] == 0.0 || std::isnan(numbers[i]) || held) continue;
    equal_pairs_ += times_[numbers[i]]++;
    ++numbers_;
    orders_ += std::log2(++of_row);
  }
  before_ = numbers;
  const auto n = static_cast<double>(numbers_);
  if (numbers_ < 2) return;
  const double equal = (1.0 + static_cast<double>(equal_pairs_)) / (0.5 * n * (n - 1.0));
  enough_ = -n * std::log2(equal) - orders_ >= kEnough;
  if (enough_) times_.clear();
}

std::string RunFingerprints::name_of(const Run& run, const std::string& file) {
  return run_name(file, run.number);
}

std::string RunFingerprints::name_of(const Run& run, const Run& beside) {
  return name_of(run, run.file == beside.file ? "it" : run.file->string());
}

void RunFingerprints::begin_file(const std::filesystem::path& file) { file_ = &file; }

void RunFingerprints::begin_run(std::optional<std::string> number) {
  runs_.push_back({.file = file_, .number = std::move(number)});
  hash_ = 0;
  rows_ = 0;
  bits_ = {};
  repeated_.begin_run();
  rounded_.begin_run();
}

void RunFingerprints::add(const Step& step) {
  const bool of_error = step.error.size() > 0 || step.innovations.empty();
  rounded_.add_row(span_of(of_error ? step.error : step.innovations.front().nu));
  std::uint64_t sum = sum_of(step.error);
  for (const Innovation& innovation : step.innovations) sum += sum_of(innovation.nu);
  hash_ = stable_hash(bytes_of(sum), hash_);
  repeated_.add_row(sum);
  if (!bits_.enough()) {
    row_.assign(step.error.begin(), step.error.end());
    for (const Innovation& innovation : step.innovations)
      row_.insert(row_.end(), innovation.nu.begin(), innovation.nu.end());
    bits_.add_row(row_);
    if (bits_.enough()) repeated_.worth(CoincidenceBits::kEnough);
  }
  if (!std::has_single_bit(static_cast<std::uint64_t>(++rows_)) || !bits_.enough()) return;
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
  repeated_.append(std::move(later.repeated_));
  rounded_.append(std::move(later.rounded_));
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
  throw DataError(
      *run.file, "",
      fmt::format("{} has, in its first {} rows, the same errors and innovations to the last bit as {}: "
                  "independent runs cannot, and it would be counted twice",
                  name_of(run, "it"), found->first.rows, name_of(other, run)));
}

std::vector<RunFingerprints::Likeness> RunFingerprints::likenesses() const {
  std::vector<Likeness> all;
  const auto name = [](const Run& run) { return name_of(run, run.file->string()); };
  for (const RepeatedRows::Stretch& s : repeated_.stretches()) {
    const Run &run = runs_[s.run], &other = runs_[s.other];
    const std::string of_other =
        s.run == s.other ? "it, as in a log that was appended to itself" : name(other);
    all.push_back(
        {*run.file,
         fmt::format("Rows {} to {} of {}, and perhaps some beside them, have the same errors "
                     "and innovations to the last bit as rows {} to {} of {}. Rows with noise "
                     "of their own cannot: what is there twice is counted twice.",
                     s.first, s.last, name(run), s.other_first, s.other_first + s.last - s.first, of_other)});
  }
  return all;
}

CopiedRuns RunFingerprints::copies() const {
  return rounded_.found([this](std::size_t run) { return name_of(runs_[run], runs_[run].file->string()); });
}

}  // namespace credence::internal
