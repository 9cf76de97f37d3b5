#include "datasets/arrays/array_reader.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "core/linear_algebra/symmetry.h"
#include "core/manifold/angle.h"

namespace credence::internal {

void ArrayReader::fail(const Place& place, std::string_view inner, const std::string& problem) const {
  std::string name(place.array);
  if (!place.sensor.empty()) name += fmt::format("['{}']", place.sensor);
  switch (arrays_.indexing) {
    case ArrayIndexing::single: name += fmt::format("[{}{}]", place.row, inner); break;
    case ArrayIndexing::stacked: name += fmt::format("[{}, {}{}]", place.run, place.row, inner); break;
    case ArrayIndexing::listed: name += fmt::format("[{}][{}{}]", place.run, place.row, inner); break;
  }
  throw std::invalid_argument(fmt::format("{} {}", name, problem));
}

void ArrayReader::keep_finite(const double* values, Index size, const Place& place) {
  kept_.clear();
  for (Index i = 0; i < size; ++i) {
    if (std::isinf(values[i])) fail(place, fmt::format(", {}", i), fmt::format("is {}", values[i]));
    if (!std::isnan(values[i])) kept_.push_back(i);
  }
}

void ArrayReader::read_covariance(const double* entries, Index size, const Place& place, Matrix& out) const {
  const Index n = std::ssize(kept_);
  out.resize(n, n);
  const auto entry = [&](Index i, Index j) { return entries[i * size + j]; };
  const auto at = [&](Index i) { return n == size ? i : kept_[static_cast<std::size_t>(i)]; };
  for (Index i = 0; i < n; ++i) {
    const double variance = entry(at(i), at(i));
    for (Index j = i; j < n; ++j) {
      const double upper = entry(at(i), at(j)), lower = entry(at(j), at(i));
      out(i, j) = out(j, i) = upper;
      const double apart = upper - lower;
      if (apart == 0.0) continue;
      const double limit = kMostAsymmetry * kMostAsymmetry * std::abs(variance * entry(at(j), at(j)));
      if (apart * apart <= limit) continue;
      const std::string inner = fmt::format(", {}, {}", at(i), at(j));
      if (!std::isfinite(upper)) fail(place, inner, fmt::format("is {}", upper));
      if (!std::isfinite(lower)) {
        fail(place, fmt::format(", {}, {}", at(j), at(i)), fmt::format("is {}", lower));
      }
      fail(place, "",
           fmt::format("is not symmetric: its entries [{0}, {1}] and [{1}, {0}] are {2} and {3}", at(i),
                       at(j), upper, lower));
    }
  }
}

void ArrayReader::read_state(const ArrayRun& run, Place place, Step& step) {
  const RunLayout& layout = arrays_.layout;
  const Index n = std::ssize(layout.states);
  kept_.clear();
  if (run.error.data != nullptr) {
    place.array = "error";
    keep_finite(run.error.at(place.row), n, place);
  }
  step.states = kept_;
  step.error.resize(std::ssize(kept_));
  step.estimate.resize(0);
  step.P.resize(0, 0);
  if (kept_.empty()) return;
  const double* const error = run.error.at(place.row);
  for (Index i = 0; i < step.error.size(); ++i) {
    const Index state = kept_[static_cast<std::size_t>(i)];
    step.error[i] = layout.angles[static_cast<std::size_t>(state)] ? wrap_angle(error[state]) : error[state];
  }
  if (run.estimate.data != nullptr) {
    place.array = "estimate";
    const double* const estimate = run.estimate.at(place.row);
    step.estimate.resize(step.error.size());
    for (Index i = 0; i < step.error.size(); ++i) {
      const Index state = kept_[static_cast<std::size_t>(i)];
      step.estimate[i] = estimate[state];
      if (!std::isfinite(estimate[state])) {
        fail(place, fmt::format(", {}", state), fmt::format("is {}", estimate[state]));
      }
    }
  }
  place.array = "P";
  read_covariance(run.P.at(place.row), n, place, step.P);
}

void ArrayReader::read_innovation(std::size_t s, const InnovationRows& rows, Place place, Innovation& out) {
  const Sensor& sensor = arrays_.layout.sensors[s];
  place.array = "innovation";
  place.sensor = sensor.name;
  const double* const nu = rows.nu.at(place.row);
  keep_finite(nu, sensor.dim, place);
  out.nu.resize(std::ssize(kept_));
  for (Index i = 0; i < out.nu.size(); ++i) out.nu[i] = nu[kept_[static_cast<std::size_t>(i)]];
  out.complete = are_complete(kept_, sensor.piece);
  if (kept_.empty()) return;
  place.array = "S";
  read_covariance(rows.S.at(place.row), sensor.dim, place, out.S);
  out.R.resize(0, 0);
  if (rows.R.data == nullptr) return;
  place.array = "R";
  read_covariance(rows.R.at(place.row), sensor.dim, place, out.R);
  for (Index i = 0; i < out.R.rows(); ++i) {
    const double variance = out.R(i, i);
    const Index at = kept_[static_cast<std::size_t>(i)];
    if (!(variance >= 0.0)) fail(place, fmt::format(", {}, {}", at, at), fmt::format("is {}", variance));
  }
}

void ArrayReader::read(std::int64_t run, std::int64_t row, Step& step) {
  const ArrayRun& of = arrays_.runs[static_cast<std::size_t>(run)];
  const Place place{.array = {}, .sensor = {}, .run = arrays_.first_run + run, .row = row};
  step.step = step.line = row + 1;
  step.problem = {};
  read_state(of, place, step);
  step.innovations.resize(of.innovations.size());
  for (std::size_t s = 0; s < of.innovations.size(); ++s) {
    read_innovation(s, of.innovations[s], place, step.innovations[s]);
  }
}

}  // namespace credence::internal
