#include "datasets/logs/rounded_copies.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

#include "core/types.h"

namespace credence::internal {
namespace {

constexpr std::size_t kWidest = 8;
constexpr std::size_t kKeyRows = 8;  // up to row 16

/// 1, 2, 3, 4, 6, 8, 12, 16, …
bool is_kept(std::int64_t row) {
  const auto number = static_cast<std::uint64_t>(row);
  return std::has_single_bit(number) || (number % 3 == 0 && std::has_single_bit(number / 3));
}

/// Root mean square of each component over so many rows.
std::vector<double> sizes(std::span<const double> numbers, std::size_t width, std::size_t rows) {
  std::vector<double> sizes(width, 0.0);
  for (std::size_t i = 0; i < rows * width; ++i) sizes[i % width] += numbers[i] * numbers[i];
  for (double& size : sizes) size = std::sqrt(size / static_cast<double>(rows));
  return sizes;
}

}  // namespace

void RoundedCopies::add_row(std::span<const double> numbers) {
  Run& run = runs_.back();
  if (!is_kept(++run.rows)) return;
  const std::size_t width = std::min(numbers.size(), kWidest);
  if (run.rows == 1) run.width = width;
  if (width != run.width) run.width = 0;
  run.numbers.insert(run.numbers.end(), numbers.begin(),
                     numbers.begin() + static_cast<std::ptrdiff_t>(width));
}

void RoundedCopies::append(RoundedCopies later) { std::ranges::move(later.runs_, std::back_inserter(runs_)); }

bool RoundedCopies::alike(const Run& a, const Run& b, Pair& pair) const {
  constexpr double kRounding = 1.0 / 50.0, kVaries = 1.0 / 5.0;
  constexpr double kByChance = 1e-12;
  const std::size_t width = a.width, rows = std::min(a.numbers.size(), b.numbers.size()) / width;
  const std::vector<double> size = sizes(a.numbers, width, rows);
  std::size_t good = 0, moving = 0;
  double chance = 1.0;
  pair.rows = std::min(a.rows, b.rows);
  pair.largest = 0.0;
  for (std::size_t c = 0; c < width; ++c) {
    if (!(size[c] > 0.0) || !std::isfinite(size[c])) continue;
    ++moving;
    double largest = 0.0;
    int varies = 0;
    for (std::size_t i = c; i < rows * width; i += width) {
      largest = std::fmax(largest, std::abs(a.numbers[i] - b.numbers[i]));
      if (!std::isfinite(b.numbers[i])) return false;
      if (i >= width && std::abs(a.numbers[i] - a.numbers[i - width]) > kVaries * size[c]) ++varies;
    }
    if (largest > kRounding * size[c]) continue;
    ++good;
    std::size_t agree = 0;  // in different rows
    for (std::size_t i = c; i < rows * width; i += width) {
      for (std::size_t j = c; j < rows * width; j += width)
        agree += i != j && std::abs(a.numbers[i] - b.numbers[j]) <= kRounding * size[c] ? 1 : 0;
    }
    chance *= std::pow(static_cast<double>(agree + 1) / static_cast<double>(rows * (rows - 1) + 1), varies);
    pair.largest = std::max(pair.largest, largest / size[c]);
  }
  return 2 * good >= moving && chance <= kByChance;
}

bool RoundedCopies::is_combination(std::size_t number, std::size_t twin) const {
  constexpr std::size_t kOthers = 6;
  constexpr double kLeast = 0.1;  // of the numbers, that noise leaves
  const Run& run = runs_[number];
  std::vector<const Run*> others;
  std::size_t count = run.numbers.size();
  Pair unused;
  const std::size_t stride = std::max<std::size_t>(1, runs_.size() / (2 * kOthers));
  const std::size_t most = std::min(kOthers, count / 2);
  for (std::size_t i = 0; i < runs_.size() && others.size() < most; i += stride) {
    const Run& other = runs_[i];
    if (i == number || i == twin || other.width != run.width ||
        other.numbers.size() < std::min(run.numbers.size(), kKeyRows * run.width) ||
        alike(run, other, unused)) {
      continue;
    }
    others.push_back(&other);
    count = std::min(count, other.numbers.size());
  }
  if (others.empty() || count < 2 * others.size()) return false;
  const auto rows = static_cast<Index>(count);
  const std::vector<double> size = sizes(run.numbers, run.width, count / run.width);
  const auto scaled = [&](const Run& of) {
    Vector column(rows);
    for (Index i = 0; i < rows; ++i) {
      const double by = size[static_cast<std::size_t>(i) % run.width];
      column(i) = by > 0.0 ? of.numbers[static_cast<std::size_t>(i)] / by : 0.0;
    }
    return column;
  };
  Matrix A(rows, std::ssize(others));
  for (Index j = 0; j < A.cols(); ++j) A.col(j) = scaled(*others[static_cast<std::size_t>(j)]);
  const Vector b = scaled(run);
  const Vector left = b - A * A.colPivHouseholderQr().solve(b);
  return !(left.norm() > kLeast * b.norm());
}

std::vector<RoundedCopies::Pair> RoundedCopies::pairs() const {
  constexpr std::size_t kNeighbours = 32;
  struct Key {
    std::size_t rows;  ///< kept, of which the value is of the last
    double value;
    std::size_t run;
  };
  std::vector<Key> keys;
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const Run& run = runs_[r];
    if (run.width == 0) continue;
    const std::size_t rows = std::min(kKeyRows, run.numbers.size() / run.width);
    const double value = run.numbers[(rows - 1) * run.width];
    if (std::isfinite(value)) keys.push_back({rows, value, r});
  }
  std::ranges::sort(keys, {}, [](const Key& key) { return std::tuple(key.rows, key.value, key.run); });
  std::vector<Pair> found;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    for (std::size_t j = i + 1; j < std::min(keys.size(), i + 1 + kNeighbours); ++j) {
      const auto [first, later] = std::minmax(keys[i].run, keys[j].run);
      Pair pair{.run = later, .other = first};
      if (runs_[first].width != runs_[later].width || keys[i].rows != keys[j].rows ||
          !alike(runs_[first], runs_[later], pair) || is_combination(later, first)) {
        continue;
      }
      found.push_back(pair);
    }
  }
  std::ranges::sort(found, {}, [](const Pair& pair) { return std::pair(pair.run, pair.other); });
  const auto same_run = [](const Pair& a, const Pair& b) { return a.run == b.run; };
  found.erase(std::unique(found.begin(), found.end(), same_run), found.end());
  return found;
}

CopiedRuns RoundedCopies::found(const std::function<std::string(std::size_t run)>& name) const {
  const std::vector<Pair> all = pairs();
  CopiedRuns copied{.runs = std::ssize(all), .of = std::ssize(runs_), .says = {}};
  if (all.empty()) return copied;
  const Pair& pair = all.front();
  copied.says = fmt::format(
      "{} has, in all rows that were looked at of the {} it shares, the errors of {}, but for {:.2g} of "
      "their size or less{}: if it is a copy that was rounded, was given a little noise or is in another "
      "format, it is no independent run, and counted twice. Independent runs agree so by chance, and where "
      "no noise drives them.",
      name(pair.run), pair.rows, name(pair.other), pair.largest,
      all.size() == 1   ? ""
      : all.size() == 2 ? ", and so has one more run those of another"
                        : fmt::format(", and so have {} more runs those of others", all.size() - 1));
  return copied;
}

}  // namespace credence::internal
