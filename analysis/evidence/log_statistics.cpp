#include "analysis/evidence/log_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/evidence/consistency_nees.h"
#include "analysis/laws/chi_square.h"
#include "montecarlo/engine/engine.h"

namespace credence {
namespace {

/// "vehicle" of "vehicle.x"; the name itself without a dot.
std::string block_of(const std::string& state) { return state.substr(0, state.find('.')); }

/// The value beyond which a χ²(dof) is a gross outlier.
double outlier_limit(Index dof) {
  constexpr std::size_t kCached = 64;
  static const std::vector<double> limits = [] {
    std::vector<double> all(kCached, 0.0);
    for (std::size_t i = 1; i < kCached; ++i) {
      all[i] = chi_square_upper_quantile(kGrossOutlier, static_cast<double>(i));
    }
    return all;
  }();
  const auto i = static_cast<std::size_t>(dof);
  return i < kCached ? limits[i] : chi_square_upper_quantile(kGrossOutlier, static_cast<double>(dof));
}

/// A Cholesky factor of P that rounding has not eaten: every pivot well above it, relative to the variance.
bool well_conditioned(const Eigen::LLT<Matrix>& factor, const Matrix& P) {
  const double tolerance = 100.0 * static_cast<double>(P.rows()) * std::numeric_limits<double>::epsilon();
  for (Index i = 0; i < P.rows(); ++i) {
    const double pivot = factor.matrixLLT()(i, i);
    if (!(pivot * pivot > tolerance * P(i, i))) return false;
  }
  return true;
}

void merge_lags(std::optional<LagProducts>& all, const std::optional<LagProducts>& later) {
  if (!all || !later || all->dim() != later->dim()) {
    all.reset();
  } else {
    all->merge(*later);
  }
}

}  // namespace

void merge_sums(SumsOverSteps& sums, const SumsOverSteps& later) {
  if (sums.size() < later.size()) sums.resize(later.size());
  for (std::size_t k = 0; k < later.size(); ++k) {
    sums[k].value.merge(later[k].value);
    sums[k].dof += later[k].dof;
  }
}

SensorStatistics::SensorStatistics() : scalar_lags(1, kLags) {}

void SensorStatistics::merge(const SensorStatistics& later) {
  merge_sums(nis, later.nis);
  for (const auto& [m, sums] : later.by_dimension) {
    by_dimension[m].value.merge(sums.value);
    by_dimension[m].dof += sums.dof;
  }
  varies = varies || later.varies || dim != later.dim;
  dim = std::max(dim, later.dim);
  merge_lags(lags, later.lags);
  if (lags && mean && later.mean) {
    mean->merge(*later.mean);
  } else {
    mean.reset();
  }
  scalar_lags.merge(later.scalar_lags);
  scalar_mean.merge(later.scalar_mean);
}

void LogStatistics::merge(LogStatistics later) {
  if (later.rows == 0 && later.study.runs == 0) return;
  if (rows == 0 && study.runs == 0) {
    *this = std::move(later);
    return;
  }
  const std::size_t steps = std::max(study.steps.size(), later.study.steps.size());
  study.steps.resize(steps);
  later.study.steps.resize(steps);
  for (RunFailure& failure : later.study.failures) failure.run += study.runs;
  study.merge(later.study);
  for (const auto& [name, sums] : later.blocks) merge_sums(blocks[name], sums);
  for (const auto& [name, sensor] : later.sensors) {
    const auto [place, is_new] = sensors.try_emplace(name, sensor);
    if (!is_new) place->second.merge(sensor);
  }
  nis_fit.merge(later.nis_fit);
  merge_sums(clean_nees, later.clean_nees);
  merge_sums(clean_nis, later.clean_nis);
  nees_outliers += later.nees_outliers;
  nis_outliers += later.nis_outliers;
  rows += later.rows;
  for (const auto& [reason, these] : later.rejected) {
    RejectedRows& all = rejected[reason];
    if (all.count == 0) all.first = these.first;
    all.count += these.count;
  }
  first_run.clear();
  first_run.shrink_to_fit();
  state_dim = std::max(state_dim, later.state_dim);
  joint_covariance = joint_covariance && later.joint_covariance;
  has_truth = has_truth || later.has_truth;
}

std::int64_t LogStatistics::rejected_rows() const {
  std::int64_t count = 0;
  for (const auto& [reason, these] : rejected) count += these.count;
  return count;
}

void LogAccumulator::begin_file(const std::filesystem::path& file, const FilterLogLayout& layout) {
  file_ = file.string();
  if (layout == layout_) return;
  layout_ = layout;
  blocks_.clear();
  if (layout.has_truth) {
    for (Index i = 0; i < std::ssize(layout.states); ++i) {
      const std::string name = block_of(layout.states[static_cast<std::size_t>(i)]);
      const auto found = std::ranges::find(blocks_, name, &Block::name);
      if (found == blocks_.end()) {
        blocks_.push_back({name, {i}});
      } else {
        found->states.push_back(i);
      }
    }
  }
  for (Block& block : blocks_) {
    block.pose =
        block.states == std::vector<Index>{block.states[0], block.states[0] + 1, block.states[0] + 2} &&
        layout.angles[static_cast<std::size_t>(block.states[0]) + 2];
  }
  const bool vehicle_first = !blocks_.empty() && blocks_[0].name == "vehicle";
  planar_slam_ =
      vehicle_first && blocks_[0].pose && std::all_of(blocks_.begin() + 1, blocks_.end(), [](const Block& b) {
        return b.name.starts_with("landmark") && b.states.size() == 2;
      });
  line_world_ = vehicle_first && std::all_of(blocks_.begin(), blocks_.end(),
                                             [](const Block& b) { return b.states.size() == 1; });
}

void LogAccumulator::begin_run() {
  if (sums_.study.runs == kChunkRuns) full_.push_back(take());
  ++sums_.study.runs;
  for (auto& [name, sensor] : sums_.sensors) {
    if (sensor.lags) sensor.lags->begin_run();
    sensor.scalar_lags.begin_run();
  }
}

void LogAccumulator::end_run(Outcome outcome, std::int64_t step) {
  sums_.study.failures.push_back({sums_.study.runs - 1, step, outcome});
}

LogStatistics LogAccumulator::take() {
  LogStatistics taken = std::move(sums_);
  sums_ = LogStatistics();
  return taken;
}

StepSums& LogAccumulator::at(SumsOverSteps& sums, std::size_t k) const {
  if (sums.size() <= k) sums.resize(k + 1);
  return sums[k];
}

LogAccumulator::Normalised LogAccumulator::normalise(const Vector& error, const Matrix& P) {
  // The common case, with the arithmetic of a study of our own.
  const bool regular = (P.diagonal().array() > 0.0).all();
  if (regular) {
    const NeesValue nees = solver_.solve(error, P);
    if (nees.dof >= 0 && std::isfinite(nees.value) && well_conditioned(solver_.factor(), P)) {
      return {.value = nees.value, .whitened = solver_.whitened(), .dof = nees.dof};
    }
  }
  const NormalisedError general = normalised_error(error, P);
  if (!general.ok) return {.problem = general.reason};
  if (!std::isfinite(general.value)) return {.problem = "an error where the covariance claims certainty"};
  return {.value = general.value, .whitened = general.whitened, .dof = general.dof};
}

std::string_view LogAccumulator::judge_state(const FilterRow& row) {
  state_ = {};
  block_values_.assign(blocks_.size(), {});
  if (row.states.empty()) return {};
  if (layout_.joint_covariance) {
    state_ = normalise(row.error, row.P);
    if (!state_.problem.empty()) return state_.problem;
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    std::vector<Index> places;  // of the block's states among those of the row
    for (const Index state : blocks_[b].states) {
      const auto found = std::ranges::lower_bound(row.states, state);
      if (found != row.states.end() && *found == state) places.push_back(found - row.states.begin());
    }
    if (places.empty()) continue;
    const bool pose = blocks_[b].pose && places.size() == 3 && places[0] == 0;
    if (pose) block_values_[b] = pose_nees(row.error, row.P, solver_);
    if (pose && block_values_[b].dof == 3) continue;
    const Normalised block = normalise(row.error(places), row.P(places, places));
    if (!block.problem.empty()) return block.problem;
    block_values_[b] = {block.value, block.dof};
    if (layout_.joint_covariance) continue;
    state_.value += block.value;
    state_.dof += block.dof;
  }
  return {};
}

std::string_view LogAccumulator::judge_innovations(const FilterRow& row) {
  innovations_.clear();
  for (const FilterInnovation& innovation : row.innovations) {
    innovations_.push_back(innovation.nu.size() == 0 ? Normalised{} : normalise(innovation.nu, innovation.S));
    if (!innovations_.back().problem.empty()) return "S of an innovation is not positive semidefinite";
  }
  return {};
}

void LogAccumulator::add_planar_slam(const FilterRow& row, StepStatistics& s) const {
  const Index n = row.error.size();
  const double trace = row.P.trace();
  if (planar_slam_ && n >= 3 && row.states[2] == 2) {
    const double vehicle = row.P(0, 0) + row.P(1, 1);
    s[Quantity::trace_vehicle].add(vehicle);
    s[Quantity::trace_landmarks].add(trace - vehicle - row.P(2, 2));
    s[Quantity::position_error_squared].add(row.error.head<2>().squaredNorm());
    s[Quantity::heading_error_squared].add(row.error[2] * row.error[2]);
    if (n > 3) {
      s[Quantity::landmark_error_squared].add(2.0 * row.error.tail(n - 3).squaredNorm() /
                                              static_cast<double>(n - 3));
    }
  } else if (line_world_ && row.states[0] == 0) {
    s[Quantity::trace_vehicle].add(row.P(0, 0));
    s[Quantity::trace_landmarks].add(row.P.diagonal().tail(n - 1).sum());
  }
}

void LogAccumulator::add_state(const FilterRow& row, StepStatistics& s) {
  const auto k = static_cast<std::size_t>(row.step) - 1;
  s[Quantity::nees].add(state_.value);
  s.nees_dof += state_.dof;
  s[Quantity::trace].add(row.P.trace());
  add_planar_slam(row, s);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (block_values_[b].dof < 0) continue;
    if (blocks_[b].name == "vehicle") s[Quantity::vehicle_nees].add(block_values_[b].value);
    StepSums& sums = at(sums_.blocks[blocks_[b].name], k);
    sums.value.add(block_values_[b].value);
    sums.dof += block_values_[b].dof;
  }
  if (state_.dof > 0) {
    if (sums_.study.runs == 1) {
      sums_.first_run.push_back(state_.value / static_cast<double>(state_.dof));
    }
    if (state_.value > outlier_limit(state_.dof)) {
      ++sums_.nees_outliers;
    } else {
      StepSums& clean = at(sums_.clean_nees, k);
      clean.value.add(state_.value);
      clean.dof += state_.dof;
    }
  }
}

void LogAccumulator::add_innovations(StepStatistics& s, std::size_t k) {
  double total = 0.0;
  Index total_dof = 0;
  for (std::size_t i = 0; i < innovations_.size(); ++i) {
    const Normalised& value = innovations_[i];
    const Index columns = layout_.sensor_dims[i];
    const auto [place, is_new] = sums_.sensors.try_emplace(layout_.sensors[i]);
    SensorStatistics& sensor = place->second;
    if (is_new) {
      sensor.dim = columns;
      if (columns <= SensorStatistics::kLargestWhitened) {
        sensor.lags.emplace(columns, SensorStatistics::kLags);
        sensor.mean.emplace();
      }
    }
    if (value.dof == 0) {
      if (sensor.lags) sensor.lags->add_missing();
      sensor.scalar_lags.add_missing();
      continue;
    }
    total += value.value;
    total_dof += value.dof;
    StepSums& nis = at(sensor.nis, k);
    nis.value.add(value.value);
    nis.dof += value.dof;
    StepSums& of_dimension = sensor.by_dimension[value.dof];
    of_dimension.value.add(value.value);
    of_dimension.dof += value.dof;
    if (value.dof != columns || columns != sensor.dim) {
      sensor.varies = true;
      sensor.dim = std::max(sensor.dim, columns);
      sensor.lags.reset();
      sensor.mean.reset();
    }
    if (sensor.lags) {
      sensor.lags->add(value.whitened);
      sensor.mean->add(value.whitened);
    }
    const Vector scalar =
        Vector::Constant(1, value.whitened.sum() / std::sqrt(static_cast<double>(value.dof)));
    sensor.scalar_lags.add(scalar);
    sensor.scalar_mean.add(scalar);
    sums_.nis_fit.add(chi_square_cdf(value.value, static_cast<double>(value.dof)));
  }
  if (total_dof == 0) return;
  s[Quantity::nis].add(total);
  s.nis_dof += total_dof;
  if (total > outlier_limit(total_dof)) {
    ++sums_.nis_outliers;
    return;
  }
  StepSums& clean = at(sums_.clean_nis, k);
  clean.value.add(total);
  clean.dof += total_dof;
}

void LogAccumulator::add(const FilterRow& row) {
  ++sums_.rows;
  sums_.has_truth = sums_.has_truth || layout_.has_truth;
  sums_.joint_covariance = sums_.joint_covariance && layout_.joint_covariance;
  const auto k = static_cast<std::size_t>(row.step) - 1;
  if (sums_.study.steps.size() <= k) sums_.study.steps.resize(k + 1);
  std::string_view problem = row.problem;
  if (problem.empty()) problem = judge_state(row);
  if (problem.empty()) problem = judge_innovations(row);
  if (!problem.empty()) {
    RejectedRows& rejected = sums_.rejected[std::string(problem)];
    if (rejected.count++ == 0) rejected.first = fmt::format("{}:{}", file_, row.line);
    for (auto& [name, sensor] : sums_.sensors) {
      if (sensor.lags) sensor.lags->add_missing();
      sensor.scalar_lags.add_missing();
    }
    return;
  }
  StepStatistics& s = sums_.study.steps[k];
  sums_.state_dim = std::max(sums_.state_dim, row.error.size());
  if (!row.states.empty()) add_state(row, s);
  add_innovations(s, k);
}

}  // namespace credence
