#include "datasets/logs/conventions/swapped_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/nan.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

constexpr std::size_t kMostRunsAndSteps = 128, kMostStatesKept = 16, kFewestAlong = 20;

/// Σ a b over neighbours, with what it takes to tell its error.
struct LagSum {
  double product = 0.0, square_of_products = 0.0;

  void add(double of_row) {
    product += of_row;
    square_of_products += of_row * of_row;
  }
};

/// Takes from each column its mean over the rows that have one.
void centre_columns(std::vector<std::vector<double>>& rows) {
  for (std::size_t c = 0; c < rows.front().size(); ++c) {
    double sum = 0.0, count = 0.0;
    for (const std::vector<double>& row : rows) {
      if (std::isnan(row[c])) continue;
      sum += row[c];
      count += 1.0;
    }
    for (std::vector<double>& row : rows) row[c] -= sum / count;
  }
}

/// Over the states of two rows; NaN counts as nothing.
double row_product(const double* a, const double* b, std::size_t width) {
  double sum = 0.0;
  for (std::size_t i = 0; i < width; ++i) {
    const double product = a[i] * b[i];
    if (std::isfinite(product)) sum += product;
  }
  return sum;
}

}  // namespace

void SwappedAxes::begin_run() {
  ++begun_;
  if (runs_.size() < kMostRunsAndSteps) runs_.emplace_back();
}

void SwappedAxes::add(const Step& step) {
  if (begun_ == 0 || begun_ > kMostRunsAndSteps) return;
  Run& run = runs_.back();
  if (run.steps++ >= kMostRunsAndSteps) return;
  if (width_ == 0) {
    for (const Index state : step.states) {
      width_ = std::min(kMostStatesKept, std::max(width_, static_cast<std::size_t>(state) + 1));
    }
    if (width_ == 0) return;
  }
  run.numbers.resize(std::min(run.steps, kMostRunsAndSteps) * width_, kNaN);
  for (Index i = 0; i < step.error.size(); ++i) {
    const auto state = static_cast<std::size_t>(step.states[static_cast<std::size_t>(i)]);
    const double variance = step.P(i, i);
    if (state >= width_ || !(variance > 0.0)) continue;
    run.numbers[run.numbers.size() - width_ + state] = step.error[i] / std::sqrt(variance);
  }
}

std::string SwappedAxes::says() const {
  if (runs_.size() < kFewestAlong || width_ == 0) return "";
  const std::size_t steps = runs_.front().steps;
  if (steps < kFewestAlong || std::ranges::any_of(runs_, [&](const Run& r) { return r.steps != steps; })) {
    return "";
  }
  const std::size_t kept = std::min(steps, kMostRunsAndSteps);
  std::vector<std::vector<double>> rows;
  for (const Run& run : runs_) {
    rows.push_back(run.numbers);
    rows.back().resize(kept * width_, kNaN);
  }
  centre_columns(rows);
  double square = 0.0;
  LagSum along_runs, along_steps;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t k = 0; k < kept; ++k) {
      const double* const here = rows[r].data() + k * width_;
      square += row_product(here, here, width_);
      if (r > 0) along_runs.add(row_product(here, rows[r - 1].data() + k * width_, width_));
      if (k > 0) along_steps.add(row_product(here, here - width_, width_));
    }
  }
  constexpr double kLeast = 0.2, kFarOff = 8.0, kWithin = 4.0;
  const double of_runs = along_runs.product / square, of_steps = along_steps.product / square;
  const double error_of_runs = std::sqrt(along_runs.square_of_products) / square;
  const double longer = std::sqrt((1.0 + of_runs * of_runs) / std::max(1e-6, 1.0 - of_runs * of_runs));
  const double error_of_steps = std::sqrt(along_steps.square_of_products) / square * longer;
  if (!(of_runs > std::max(kLeast, kFarOff * error_of_runs))) return "";
  if (!(std::abs(of_steps) < std::min(kWithin * error_of_steps, 0.5 * of_runs))) return "";
  return fmt::format(
      "The axes of the arrays look swapped: errors are correlated from run to run ({}) and not from step to "
      "step ({}), as where (steps, runs, n) is given for (runs, steps, n). Swap the first two axes of every "
      "array; the numbers as they are given are not judged.",
      number_text(of_runs, 2), number_text(of_steps, 2));
}

}  // namespace credence::internal
