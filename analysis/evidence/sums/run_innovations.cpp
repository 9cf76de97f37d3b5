#include "analysis/evidence/sums/run_innovations.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <boost/sort/pdqsort/pdqsort.hpp>
#include <cmath>
#include <numeric>
#include <utility>

#include "analysis/laws/chi_square/chi_square.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Φ⁻¹(u) of a probability, finite at 0 and 1.
double normal_score(double u) {
  constexpr double kLeast = 1e-15;
  return quantile(boost::math::normal(), std::clamp(u, kLeast, 1.0 - kLeast));
}

/// How many of the values are equal to another, within what arithmetic leaves of numbers with few digits.
CoverageCount count_ties(std::vector<double> values) {
  constexpr double kEqual = 1e-9;
  boost::sort::pdqsort_branchless(values.begin(), values.end());
  CoverageCount ties;
  const auto equal = [&](std::size_t i) {  // to the one before
    return i > 0 && i < values.size() &&
           values[i] - values[i - 1] <= kEqual * std::max(1.0, std::abs(values[i]));
  };
  for (std::size_t i = 0; i < values.size(); ++i) ties.add(equal(i) || equal(i + 1));
  return ties;
}

/// Where the first fifth of a run ends: what comes before may be coloured by a wrong start.
std::size_t settled_from(std::size_t steps) { return steps / 5; }

/// Of each step of a run what ChangesOfRun::add takes.
std::vector<std::size_t> seen_at_steps(std::span<const RunInnovations> sensors) {
  constexpr std::size_t kMostComponents = 1'000'003;  // of a sensor; coprime to 2⁶⁴, if many sensors wrap it
  std::vector<std::size_t> seen(sensors.empty() ? 0 : sensors.front().steps(), 0);
  for (const RunInnovations& sensor : sensors) {
    for (std::size_t k = 0; k < seen.size(); ++k) seen[k] = kMostComponents * seen[k] + sensor.at(k).size();
  }
  return seen;
}

void add_sensor_pairs(std::span<const RunInnovations> sensors, const RunLayout& layout, Evidence& sums) {
  if (std::ssize(sensors) > kMostPairedSensors) return;
  Vector both;
  const auto values_at = [&](std::size_t sensor, std::size_t k) { return sensors[sensor].at(k); };
  for (std::size_t j = 1; j < sensors.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const Sensor &first = layout.sensors[i], &second = layout.sensors[j];
      const Index dim = first.dim + second.dim;
      if (first.nis_alone || second.nis_alone || dim > SensorPairSums::kLargest) continue;
      for (std::size_t k = 0; k < sensors[j].steps(); ++k) {
        const auto u = values_at(i, k), v = values_at(j, k);
        if (u.empty() || v.empty() || std::ssize(u) != first.dim || std::ssize(v) != second.dim) continue;
        both.resize(dim);
        std::ranges::copy(u, both.begin());
        std::ranges::copy(v, both.begin() + first.dim);
        SensorPairSums& pair = sums.sensor_pair(first.name, second.name, first.dim);
        if (pair.fits(first.dim, dim)) pair.both.add(both);
      }
    }
  }
}

}  // namespace

std::span<const double> RunInnovations::at(std::size_t k) const {
  const std::size_t end = k + 1 < begins_.size() ? begins_[k + 1] : values_.size();
  return std::span(values_).subspan(begins_[k], end - begins_[k]);
}

void RunInnovations::begin_run() {
  nis_.clear();
  values_.clear();
  squares_.clear();
  begins_.clear();
  pieces_ = true;
}

void RunInnovations::add(const Sensor& sensor, const NormalisedInnovation& value, double change,
                         double before) {
  pieces_ = pieces_ && !sensor.nis_alone && sensor.piece <= SensorSums::kLargestWhitened && value.complete &&
            value.dof % sensor.piece == 0 && value.nu.size() == value.dof &&
            (sensor.piece < sensor.dim || value.dof == sensor.dim);
  nis_.push_back({value.value, value.dof, value.noise_share, change, before});
  if (sensor.nis_alone) {
    values_.push_back(normal_score(chi_square_cdf(value.value, static_cast<double>(value.dof))));
  } else {
    const double* const u = value.whitened.data();
    values_.insert(values_.end(), u, u + value.whitened.size());
    if (sensor.piece >= 2 && pieces_) add_squares(sensor, value);
  }
}

void RunInnovations::add_squares(const Sensor& sensor, const NormalisedInnovation& value) {
  constexpr double kLeast =
      1e-9;  // of the variance of a sum: less is what rounding leaves of two that are one
  constexpr std::size_t kLargest = SensorSums::kLargestWhitened;
  const auto d = static_cast<std::size_t>(sensor.piece);
  const double *nu = value.nu.data(), *variance = value.variance.data(),
               *covariance = value.covariance.data();
  const std::size_t at = squares_.size();
  squares_.resize(at + static_cast<std::size_t>(value.nu.size()) * d);
  std::array<double, kLargest> u, inverse_sigma;
  for (double *to = squares_.data() + at, *end = squares_.data() + squares_.size(); to != end;
       nu += d, variance += d) {
    for (std::size_t j = 0; j < d; ++j) {
      inverse_sigma[j] = 1.0 / std::sqrt(variance[j]);
      u[j] = nu[j] * inverse_sigma[j];
      *to++ = u[j] * u[j];
    }
    for (std::size_t p = 1; p < d; ++p) {
      for (std::size_t q = 0; q < p; ++q) {
        const double correlation = *covariance++ * inverse_sigma[p] * inverse_sigma[q];
        for (const double sign : {1.0, -1.0}) {
          const double of_sum = 2.0 * (1.0 + sign * correlation), sum = u[p] + sign * u[q];
          *to++ = of_sum > kLeast ? sum * sum / of_sum : kNaN;
        }
      }
    }
  }
}

std::size_t RunInnovations::early() const {
  std::size_t early = 0;
  for (std::size_t k = 0; k < settled_from(steps()); ++k) early += !at(k).empty();
  return early;
}

// Every so many steps a sensor speaks: the greatest common divisor of the steps between its innovations, as a
// sensor that is slower than the filter has successive ones too.
RunInnovations::Settled RunInnovations::settled() const {
  Settled settled{.first = settled_from(steps())};
  while (settled.first < steps() && at(settled.first).empty()) ++settled.first;
  std::size_t interval = 0, last = steps();
  for (std::size_t k = settled.first; k < steps() && interval != 1; ++k) {
    if (at(k).empty()) continue;
    if (last < steps()) interval = std::gcd(interval, k - last);
    last = k;
  }
  settled.interval = std::max<std::size_t>(1, interval);
  return settled;
}

ChangesOfRun::Comparable RunInnovations::comparable_changes(std::span<const std::size_t> seen,
                                                            std::size_t early) const {
  ChangesOfRun changes;
  std::size_t i = 0;
  for (std::size_t k = 0; k < steps(); ++k) {
    if (at(k).empty()) continue;
    if (i++ < early) continue;
    changes.add(seen[k], nis_[i - 1].before, nis_[i - 1].change);
  }
  return changes.comparable();
}

void RunInnovations::add_law(std::span<const std::size_t> seen, SensorSums& sums) const {
  std::vector<double> nis;
  const std::size_t early = this->early();
  const ChangesOfRun::Comparable changes = comparable_changes(seen, early);
  for (const auto& [value, dof, noise_share, change, before] : nis_) {
    sums.by_dimension[dof].add(value, dof);
    const double u = chi_square_cdf(value, static_cast<double>(dof));
    sums.fit.add(u);
    sums.far_tail.add(u <= SensorSums::kFarTail);
    sums.largest_nis = std::max(sums.largest_nis, value);
    if (!std::isnan(noise_share)) sums.measurement_share.add(noise_share);
    if (nis.size() >= early) sums.changes.add(1.0 - u, changes.changes[nis.size() - early], changes.variance);
    nis.push_back(value);
  }
  sums.ties.merge(count_ties(std::move(nis)));
}

void RunInnovations::add_scalars(const Sensor& sensor, const Settled& settled, SensorSums& sums) const {
  double level = 0.0;
  if (sensor.nis_alone && settled.first < steps()) {
    const auto values = std::span(values_).subspan(begins_[settled.first]);
    for (const double value : values) level += value / static_cast<double>(values.size());
  }
  Moments mean;
  LagSeries series(1);
  Vector value(1);
  for (std::size_t k = settled.first; k < steps(); k += settled.interval) {
    const auto u = at(k);
    if (u.empty()) {
      series.add_missing();
      continue;
    }
    double sum = -level;
    for (const double component : u) sum += component;
    value[0] = sum / std::sqrt(static_cast<double>(u.size()));
    series.add(value);
    mean.add(value[0]);
    sums.scalar_values.add(value);
  }
  if (sensor.nis_alone && mean.count > 1) {
    LongLags of_run(1);
    of_run.add_run(series);
    sums.scalar_lags.merge(
        of_run.plus(Matrix::Constant(1, 1, mean.variance() / static_cast<double>(mean.count))));
  } else {
    sums.scalar_lags.add_run(series);
  }
  if (mean.count > 0) sums.scalar_run_means.add(Vector::Constant(1, mean.mean));
}

void RunInnovations::add_pieces(const Sensor& sensor, const Settled& settled, SensorSums& sums) const {
  const auto d = static_cast<std::size_t>(sums.lags.dim());
  if (pieces_ && !values_.empty() && sensor.piece == sensor.dim) {
    sums.first.add(Eigen::Map<const Vector>(values_.data(), static_cast<Index>(d)));
  }
  std::size_t most = 0;
  for (std::size_t k = settled.first; k < steps(); k += settled.interval) {
    most = std::max(most, at(k).size() / d);
  }
  Vector total = Vector::Zero(static_cast<Index>(d));
  double pieces = 0.0;
  LagSeries series(sums.lags.dim());
  for (std::size_t j = 0; j < most; ++j) {
    series.clear();
    for (std::size_t k = settled.first; k < steps(); k += settled.interval) {
      if (j >= at(k).size() / d) {
        series.add_missing();
        continue;
      }
      const Eigen::Map<const Vector> u(at(k).data() + j * d, static_cast<Index>(d));
      series.add(u);
      sums.values.add(u);
      total += u;
      pieces += 1.0;
    }
    sums.lags.add_run(series);
  }
  if (pieces > 0.0) sums.run_means.add(total / pieces);
}

void RunInnovations::add_components(const Settled& settled, SensorSums& sums) const {
  const auto d = static_cast<std::size_t>(sums.lags.dim());
  if (d < 2) return;
  sums.components.resize(d);
  sums.pairs.resize(d * (d - 1));
  for (std::size_t k = settled.first; k < steps(); ++k) {
    const std::size_t pieces = at(k).size() / d;
    // Of each component, and direction of a pair, there are as many squares of a piece as d of it.
    const std::span<const double> squares = std::span(squares_).subspan(begins_[k] * d, pieces * d * d);
    for (std::size_t j = 0; j < d * d && pieces > 0; ++j) {
      double sum = 0.0;
      for (std::size_t i = j; i < squares.size(); i += d * d) sum += squares[i];
      if (std::isnan(sum)) continue;
      Moments& moments = j < d ? sums.components[j] : sums.pairs[j - d];
      moments.add(sum / static_cast<double>(pieces));
    }
  }
}

void RunInnovations::add_to(const Sensor& sensor, std::span<const std::size_t> seen, SensorSums& sums) const {
  sums.varies = sums.varies || !pieces_ || sums.sensor.piece != sensor.piece;
  add_law(seen, sums);
  const Settled settled = this->settled();
  add_scalars(sensor, settled, sums);
  if (sums.varies) return;
  add_pieces(sensor, settled, sums);
  add_components(settled, sums);
}

void add_innovations_of_run(std::span<const RunInnovations> sensors, const RunLayout& layout,
                            Evidence& sums) {
  const std::vector<std::size_t> seen = seen_at_steps(sensors);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    sensors[i].add_to(layout.sensors[i], seen, sums.sensor(layout.sensors[i]));
  }
  add_sensor_pairs(sensors, layout, sums);
}

}  // namespace credence::internal
