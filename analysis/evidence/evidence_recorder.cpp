#include "analysis/evidence/evidence_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "analysis/evidence/consistency_nees.h"
#include "analysis/evidence/relative_place.h"
#include "analysis/evidence/step_series.h"
#include "analysis/laws/chi_square.h"
#include "core/linear_algebra/squared_norm.h"
#include "core/manifold/angle.h"

namespace credence {
namespace {

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
bool well_conditioned(const NeesSolver& solver, const MatrixRef& P) {
  const double tolerance = 100.0 * static_cast<double>(P.rows()) * std::numeric_limits<double>::epsilon();
  for (Index i = 0; i < P.rows(); ++i) {
    const double pivot = solver.pivot(i);
    if (!(pivot * pivot > tolerance * P(i, i))) return false;
  }
  return true;
}

/// tr(S⁻¹ R)/m with R of pieces of these variances, of the S that was solved last.
double share_of_noise(NeesSolver& S, const std::vector<double>& variances) {
  const Vector& inverse_diagonal = S.inverse_diagonal();
  const Index m = inverse_diagonal.size(), d = std::ssize(variances);
  double trace = 0.0;
  for (Index i = 0; i < m; ++i) trace += variances[static_cast<std::size_t>(i % d)] * inverse_diagonal[i];
  return trace / static_cast<double>(m);
}

/// Beyond it an angle is not wrapped; the least above π.
constexpr double kHalfTurn = std::numbers::pi * (1.0 + 1e-12);

/// A whole state is compared over the runs up to this dimension.
constexpr Index kLargestState = 60;

/// Φ⁻¹(u) of a probability, finite at 0 and 1.
double normal_score(double u) {
  constexpr double kLeast = 1e-15;
  return quantile(boost::math::normal(), std::clamp(u, kLeast, 1.0 - kLeast));
}

/// How many of the values are equal to another, within what arithmetic leaves of numbers with few digits.
CoverageCount count_ties(std::vector<double> values) {
  constexpr double kEqual = 1e-9;
  std::ranges::sort(values);
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

}  // namespace

void EvidenceRecorder::begin_file(const std::filesystem::path& file, const RunLayout& layout) {
  file_ = file.string();
  if (sums_.layout.states.empty()) sums_.layout = layout;
  if (layout == layout_) return;
  close_run(true);
  layout_ = layout;
  states_.clear();
  places_.assign(layout.blocks.size(), {});
  list_blocks();
}

void EvidenceRecorder::list_blocks() {
  block_at_.clear();
  position_ = pose_ = averaged_dim_ = -1;
  landmarks_.clear();
  sums_.law.averaged.clear();
  if (!layout_.has_truth) return;
  for (const Block& block : layout_.blocks) {
    if (block.part == Part::position && position_ < 0) position_ = std::ssize(block_at_);
    if (block.part == Part::pose && block.states.size() == 3) pose_ = std::ssize(block_at_);
    if (block.part == Part::landmark && block.states.size() == 2) landmarks_.push_back(block_at_.size());
    block_at_.push_back(static_cast<std::size_t>(&sums_.block(block) - sums_.blocks.data()));
  }
  const Index all = std::ssize(layout_.states);
  if (all <= LawSums::kLargestAveraged) {
    averaged_dim_ = all;
  } else if (!layout_.blocks.empty()) {
    const Block& first = layout_.blocks.front();
    const Index dim = std::ssize(first.states);
    if (dim <= LawSums::kLargestAveraged) averaged_dim_ = dim;
    sums_.law.averaged = first.name;
  }
}

void EvidenceRecorder::begin_run() {
  close_run(true);
  if (sums_.study.runs == kChunkRuns) full_.push_back(take());
  ++sums_.study.runs;
  run_ = {};
  run_.open = true;
  run_.squared_error.resize(layout_.blocks.size());
  run_.blocks.resize(layout_.blocks.size());
  run_.innovations.resize(layout_.sensors.size());
}

void EvidenceRecorder::end_run(Outcome outcome, std::int64_t step) {
  if (outcome != Outcome::ok) sums_.study.failures.push_back({sums_.study.runs - 1, step, outcome});
  close_run(outcome == Outcome::ok);
}

Evidence EvidenceRecorder::take() {
  close_run(true);
  Evidence taken = std::move(sums_);
  sums_ = Evidence();
  sums_.layout = layout_;
  list_blocks();
  return taken;
}

void EvidenceRecorder::Normalised::clear() {
  value = 0.0;
  dof = -1;
  factorised = false;
  log_determinant = noise_share = kNaN;
  problem = {};
}

void EvidenceRecorder::Normalised::take(const Step& step, const std::vector<Index>& places) {
  const Index n = std::ssize(places);
  error.resize(n);
  P.resize(n, n);
  for (Index j = 0; j < n; ++j) {
    const Index from = places[static_cast<std::size_t>(j)];
    error[j] = step.error[from];
    for (Index i = 0; i < n; ++i) P(i, j) = step.P(places[static_cast<std::size_t>(i)], from);
  }
}

void EvidenceRecorder::Normalised::normalise(const VectorRef& e, const MatrixRef& covariance) {
  clear();
  // The common case, with the arithmetic of the engine.
  if ((covariance.diagonal().array() > 0.0).all()) {
    const NeesValue nees = solver.solve(e, covariance);
    if (nees.dof >= 0 && std::isfinite(nees.value) && well_conditioned(solver, covariance)) {
      factorised = true;
      value = nees.value;
      whitened = solver.whitened();
      dof = nees.dof;
      return;
    }
  }
  const NormalisedError general = normalised_error(e, covariance);
  if (!general.ok) {
    problem = general.reason;
  } else if (!std::isfinite(general.value)) {
    problem = "an error where the covariance claims certainty";
  } else {
    value = general.value;
    whitened = general.whitened;
    dof = general.dof;
  }
}

void EvidenceRecorder::Normalised::normalise(double e, double variance) {
  const double u = e / std::sqrt(variance), squared = u * u;
  if (!(variance > 0.0) || !std::isfinite(squared)) {
    normalise(Vector::Constant(1, e), Matrix::Constant(1, 1, variance));
    return;
  }
  clear();
  value = squared;
  whitened.resize(1);
  whitened[0] = u;
  dof = 1;
}

void EvidenceRecorder::find_places(const Step& step) {
  if (step.states == states_) return;
  states_ = step.states;
  std::vector<Index> place(layout_.states.size(), -1);
  for (std::size_t i = 0; i < states_.size(); ++i) {
    place[static_cast<std::size_t>(states_[i])] = static_cast<Index>(i);
  }
  angles_.clear();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (layout_.angles[static_cast<std::size_t>(states_[i])]) angles_.push_back(static_cast<Index>(i));
  }
  for (std::size_t b = 0; b < places_.size(); ++b) {
    places_[b].clear();
    for (const Index state : layout_.blocks[b].states) {
      if (const Index at = place[static_cast<std::size_t>(state)]; at >= 0) places_[b].push_back(at);
    }
  }
}

std::string_view EvidenceRecorder::judge_state(const Step& step) {
  state_.clear();
  blocks_.resize(layout_.blocks.size());
  for (Normalised& block : blocks_) block.clear();
  if (step.states.empty()) return {};
  find_places(step);
  if (layout_.joint_covariance) {
    state_.normalise(step.error, step.P);
    if (!state_.problem.empty()) return state_.problem;
    if (state_.factorised) {
      state_.log_determinant = state_.solver.log_determinant();
    }
  } else {
    state_.dof = 0;
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const std::vector<Index>& places = places_[b];
    Normalised& block = blocks_[b];
    const bool whole = std::ssize(places) == step.error.size() && layout_.joint_covariance;
    const bool single = places.size() == 1;
    if (b == 0 || static_cast<Index>(b) == position_ || !(whole || single)) block.take(step, places);
    if (places.empty()) continue;
    if (whole) {
      block.value = state_.value;
      block.dof = state_.dof;
      block.whitened = state_.whitened;
    } else if (single) {
      block.normalise(step.error[places[0]], step.P(places[0], places[0]));
    } else {
      block.normalise(block.error, block.P);
    }
    if (!block.problem.empty()) return block.problem;
    if (layout_.joint_covariance) continue;
    state_.value += block.value;
    state_.dof += block.dof;
  }
  return {};
}

std::string_view EvidenceRecorder::judge_innovations(const Step& step) {
  innovations_.resize(step.innovations.size());
  for (std::size_t i = 0; i < step.innovations.size(); ++i) {
    const Innovation& innovation = step.innovations[i];
    Normalised& value = innovations_[i];
    value.clear();
    if (innovation.nu.size() == 0) continue;
    value.normalise(innovation.nu, innovation.S);
    if (!value.problem.empty()) return "S of an innovation is not positive semidefinite";
    const std::vector<double>& variances = layout_.sensors[i].variances;
    if (value.factorised && !variances.empty()) {
      value.noise_share = share_of_noise(value.solver, variances);
    }
  }
  return {};
}

void EvidenceRecorder::add_traces(const Step& step, StepStatistics& s) const {
  s[Quantity::trace].add(step.P.trace());
  for (std::size_t b = 0; b < places_.size(); ++b) {
    const std::vector<Index>& places = places_[b];
    const Part part = layout_.blocks[b].part;
    if (part == Part::other || part == Part::pose || part == Part::landmark) continue;
    double trace = 0.0, squared = 0.0;
    for (const Index i : places) {
      trace += step.P(i, i);
      squared += step.error[i] * step.error[i];
    }
    if (part == Part::map) {
      s[Quantity::trace_landmarks].add(trace);
      const double landmarks = static_cast<double>(places.size()) / static_cast<double>(layout_.landmark_dim);
      if (!places.empty()) s[Quantity::landmark_error_squared].add(squared / landmarks);
    } else if (!places.empty() && part == Part::position) {
      s[Quantity::trace_vehicle].add(trace);
      s[Quantity::position_error_squared].add(squared);
    } else if (!places.empty()) {
      s[Quantity::heading_error_squared].add(squared);
    }
  }
}

void EvidenceRecorder::add_state(const Step& step) {
  if (entry_ > 0) {
    StepStatistics& s = at_step(sums_.study.steps, entry_);
    s[Quantity::nees].add(state_.value);
    s.nees_dof += state_.dof;
    add_traces(step, s);
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (blocks_[b].dof < 0) continue;
    const Block& block = layout_.blocks[b];
    if (block.part == Part::pose) {
      if (entry_ > 0) {
        at_step(sums_.study.steps, entry_)[Quantity::vehicle_nees].add(blocks_[b].value);
      }
      run_.vehicle.add(blocks_[b].value, blocks_[b].dof);
    }
    run_.blocks[b].add(blocks_[b].value, blocks_[b].dof);
    if (entry_ > 0) at_step(sums_of_block(b).nees, entry_).add(blocks_[b].value, blocks_[b].dof);
    double squared = squared_norm(step.error, places_[b]);
    if (block.part == Part::map) {
      squared *= static_cast<double>(layout_.landmark_dim) / static_cast<double>(places_[b].size());
    }
    run_.squared_error[b].add(squared);
  }
  if (state_.dof <= 0) return;
  if (entry_ > 0) sums_.coverage.add(entry_, state_.value, state_.dof);
  run_.values.add(state_.value);
  run_.nees.push_back(state_.value / static_cast<double>(state_.dof));
  run_.whole.add(state_.value, state_.dof);
  run_.last_whitened = state_.whitened;
  if (!blocks_.empty()) {
    run_.last_error = blocks_.front().error;
    run_.last_covariance = blocks_.front().P;
  }
  add_angles(step);
  add_law(step);
  add_lateness(step);
  add_scores();
  if (sums_.study.runs == 1) sums_.first_run.push_back(state_.value / static_cast<double>(state_.dof));
  if (state_.value > outlier_limit(state_.dof)) {
    ++sums_.nees_outliers;
  } else if (entry_ > 0) {
    at_step(sums_.clean_nees, entry_).add(state_.value, state_.dof);
  }
}

void EvidenceRecorder::add_angles(const Step& step) {
  for (const Index i : angles_) sums_.narrow_angles.add(step.P(i, i) <= kWideAngle * kWideAngle);
}

void EvidenceRecorder::add_law(const Step& step) {
  const double dof = static_cast<double>(state_.dof);
  if (entry_ > 0) at_step(sums_.law.nees_at, entry_).add(state_.value / dof);
  run_.law.nees_tails.add(state_.value, dof);
  if (!layout_.joint_covariance) return;
  if (sums_.law.averaged.empty()) {
    if (state_.dof == averaged_dim_) run_.law.add_error(state_.whitened, step.error, step.P);
  } else if (const Normalised& first = blocks_.front(); first.dof == averaged_dim_) {
    run_.law.add_error(first.whitened, first.error, first.P);
  }
  const Index all = std::ssize(layout_.states);
  if (state_.dof == all && all <= LawSums::kLargestShape && is_shape_step(step.step)) {
    sums_.law.whitened[step.step].add(state_.whitened);
  }
}

/// The places of a pose and of one landmark that is in the state, another one at each step; empty: there is
/// none.
std::vector<Index> EvidenceRecorder::pose_and_landmark(std::int64_t step) const {
  if (pose_ < 0 || places_[static_cast<std::size_t>(pose_)].size() != 3) return {};
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const std::size_t at = (i + static_cast<std::size_t>(step)) % landmarks_.size();
    const std::vector<Index>& landmark = places_[landmarks_[at]];
    if (landmark.size() != 2) continue;
    std::vector<Index> both = places_[static_cast<std::size_t>(pose_)];
    both.insert(both.end(), landmark.begin(), landmark.end());
    return both;
  }
  return {};
}

// Of what moves: in a map a landmark as seen from the vehicle, since a map made of late sights is displaced
// and the vehicle within it is not; else the position, or a state without one, unless it is large. The step
// is that of the mean over a few, in which what corrections add is smaller.
void EvidenceRecorder::add_lateness_of(const Step& step) {
  const double steps = static_cast<double>(run_.way.size());
  const Vector& before = run_.way.front();
  if (pose_ >= 0 && !landmarks_.empty()) {
    const std::vector<Index> five = pose_and_landmark(step.step);
    if (five.empty()) return;
    const RelativePlace now = relative_place(step.estimate(five));
    const RelativePlace truth = relative_place(step.estimate(five) - step.error(five));
    const Eigen::Matrix2d P = now.J * step.P(five, five) * now.J.transpose();
    run_.lateness.add(now.r - truth.r, (now.r - relative_place(before(five)).r) / steps, P);
  } else if (position_ >= 0) {
    const auto p = static_cast<std::size_t>(position_);
    const Vector motion = (step.estimate - before)(places_[p]) / steps;
    if (blocks_[p].dof == motion.size()) run_.lateness.add(blocks_[p].error, motion, blocks_[p].P);
  } else if (layout_.joint_covariance && averaged_dim_ == state_.dof) {
    Vector motion = step.estimate - before;
    for (const Index i : angles_) motion[i] = wrap_angle(motion[i]);
    run_.lateness.add(step.error, motion / steps, step.P);
  }
}

void EvidenceRecorder::add_lateness(const Step& step) {
  constexpr std::size_t kSteps = 4;
  if (!layout_.componentwise || step.estimate.size() != step.error.size()) return;
  if (run_.way_states != step.states) {
    run_.way_states = step.states;
    run_.way.clear();
  }
  if (!run_.way.empty()) add_lateness_of(step);
  run_.way.push_back(step.estimate);
  if (run_.way.size() > kSteps) run_.way.pop_front();
}

void EvidenceRecorder::add_scores() {
  if (!layout_.joint_covariance) return;
  run_.score.add(state_.value, state_.dof, state_.log_determinant);
  if (position_ < 0) return;
  const Normalised& position = blocks_[static_cast<std::size_t>(position_)];
  if (position.dof >= 0) run_.score.set_position(position.error, position.P);
}

void EvidenceRecorder::add_sensor_pairs() {
  const auto whole = [this](std::size_t i) {
    return innovations_[i].dof > 0 && innovations_[i].dof == layout_.sensors[i].dim &&
           !layout_.sensors[i].nis_alone;
  };
  Vector both;
  for (std::size_t j = 1; j < innovations_.size(); ++j) {
    for (std::size_t i = 0; i < j && whole(j); ++i) {
      const Index dim = innovations_[i].dof + innovations_[j].dof;
      if (!whole(i) || dim > SensorPairSums::kLargest) continue;
      both.resize(dim);
      both << innovations_[i].whitened, innovations_[j].whitened;
      sums_.sensor_pair(layout_.sensors[i].name, layout_.sensors[j].name, innovations_[i].dof).both.add(both);
    }
  }
}

void EvidenceRecorder::add_missing(std::size_t sensor) {
  RunInnovations& run = run_.innovations[sensor];
  run.begins.push_back(run.values.size());
}

void EvidenceRecorder::add_innovation(std::size_t i, const Step& step) {
  const Normalised& value = innovations_[i];
  const Sensor& sensor = layout_.sensors[i];
  SensorSums& sums = sums_.sensor(sensor);
  const bool pieces = !sensor.nis_alone && sensor.piece <= SensorSums::kLargestWhitened &&
                      value.dof % sensor.piece == 0 && step.innovations[i].nu.size() == value.dof &&
                      (sensor.piece < sensor.dim || value.dof == sensor.dim);
  sums.varies = sums.varies || !pieces;
  if (entry_ > 0) at_step(sums.nis, entry_).add(value.value, value.dof);
  sums.by_dimension[value.dof].add(value.value, value.dof);
  const double u = chi_square_cdf(value.value, static_cast<double>(value.dof));
  sums.fit.add(u);
  sums.far_tail.add(u <= SensorSums::kFarTail);
  sums.largest_nis = std::max(sums.largest_nis, value.value);
  if (!std::isnan(value.noise_share)) sums.measurement_share.add(value.noise_share);
  for (Index j = 0; j < step.innovations[i].nu.size() && !sensor.angles.empty(); ++j) {
    const bool angle = sensor.angles[static_cast<std::size_t>(j % std::ssize(sensor.angles))];
    if (angle && std::abs(step.innovations[i].nu[j]) > kHalfTurn) ++sums.unwrapped;
  }
  RunInnovations& run = run_.innovations[i];
  run.begins.push_back(run.values.size());
  if (sensor.nis_alone) {
    run.values.push_back(normal_score(u));
  } else {
    run.values.insert(run.values.end(), value.whitened.begin(), value.whitened.end());
  }
}

void EvidenceRecorder::add_innovations(const Step& step) {
  double total = 0.0;
  Index dof = 0;
  for (std::size_t i = 0; i < innovations_.size(); ++i) {
    if (innovations_[i].dof <= 0) {
      add_missing(i);
      continue;
    }
    total += innovations_[i].value;
    dof += innovations_[i].dof;
    run_.law.nis_tails.add(innovations_[i].value, static_cast<double>(innovations_[i].dof));
    add_innovation(i, step);
  }
  if (dof == 0) return;
  if (innovations_.size() > 1) add_sensor_pairs();
  const double m = static_cast<double>(dof);
  run_.law.nis += total;
  run_.law.nis_dof += m;
  const bool outlier = total > outlier_limit(dof);
  if (outlier) ++sums_.nis_outliers;
  if (entry_ == 0) return;
  StepStatistics& s = at_step(sums_.study.steps, entry_);
  s[Quantity::nis].add(total);
  s.nis_dof += dof;
  at_step(sums_.law.nis_at, entry_).add(total / m);
  if (!outlier) at_step(sums_.clean_nis, entry_).add(total, dof);
}

void EvidenceRecorder::reject(const Step& step, std::string_view problem) {
  RejectedRows& rejected = sums_.rejected[std::string(problem)];
  if (rejected.count++ == 0) rejected.first = fmt::format("{}:{}", file_, step.line);
  for (std::size_t i = 0; i < run_.innovations.size(); ++i) add_missing(i);
}

void EvidenceRecorder::add(const Step& step) {
  ++sums_.rows;
  sums_.has_truth = sums_.has_truth || layout_.has_truth;
  sums_.joint_covariance = sums_.joint_covariance && layout_.joint_covariance;
  sums_.thin_steps(step.step);
  const std::int64_t stride = sums_.step_stride, before = step.step - 1;
  entry_ = before % stride == 0 ? before / stride + 1 : 0;
  if (entry_ > 0) at_step(sums_.study.steps, entry_);  // a step that is rejected is one, too
  std::string_view problem = step.problem;
  if (problem.empty()) problem = judge_state(step);
  if (problem.empty()) problem = judge_innovations(step);
  if (!problem.empty()) return reject(step, problem);
  sums_.state_dim = std::max(sums_.state_dim, step.error.size());
  if (!step.states.empty()) add_state(step);
  add_innovations(step);
}

void EvidenceRecorder::close_innovations(std::size_t i) {
  SensorSums& sums = sums_.sensor(layout_.sensors[i]);
  const RunInnovations& run = run_.innovations[i];
  const std::size_t steps = run.begins.size(), first = settled_from(steps);
  const auto count_at = [&](std::size_t k) {
    return (k + 1 < steps ? run.begins[k + 1] : run.values.size()) - run.begins[k];
  };
  const auto d = static_cast<std::size_t>(sums.varies ? 1 : sums.lags.dim());
  std::vector<double> nis;
  for (std::size_t k = 0; k < steps; ++k) {
    if (count_at(k) == 0) continue;
    const auto values = std::span(run.values).subspan(run.begins[k], count_at(k));
    nis.push_back(std::inner_product(values.begin(), values.end(), values.begin(), 0.0));
  }
  sums.ties.merge(count_ties(std::move(nis)));
  double level = 0.0;
  if (layout_.sensors[i].nis_alone && first < steps) {
    const auto settled = std::span(run.values).subspan(run.begins[first]);
    for (const double value : settled) level += value / static_cast<double>(settled.size());
  }
  std::size_t most = 0;
  Moments scalar_mean;
  LagProducts scalar(1, SensorSums::kLags);
  Vector value(1);
  for (std::size_t k = first; k < steps; ++k) {
    const std::size_t count = count_at(k);
    most = std::max(most, count / d);
    if (count == 0) {
      scalar.add_missing();
      continue;
    }
    double sum = -level;
    for (std::size_t j = 0; j < count; ++j) sum += run.values[run.begins[k] + j];
    value[0] = sum / std::sqrt(static_cast<double>(count));
    scalar.add(value);
    scalar_mean.add(value[0]);
    sums.scalar_values.add(value);
  }
  sums.scalar_lags.merge(scalar);
  if (scalar_mean.count > 0) sums.scalar_run_means.add(Vector::Constant(1, scalar_mean.mean));
  if (sums.varies) return;

  Vector total = Vector::Zero(static_cast<Index>(d));
  double pieces = 0.0;
  for (std::size_t j = 0; j < most; ++j) {
    LagProducts piece(static_cast<Index>(d), SensorSums::kLags);
    for (std::size_t k = first; k < steps; ++k) {
      if (j >= count_at(k) / d) {
        piece.add_missing();
        continue;
      }
      const Eigen::Map<const Vector> u(run.values.data() + run.begins[k] + j * d, static_cast<Index>(d));
      piece.add(u);
      sums.values.add(u);
      total += u;
      pieces += 1.0;
    }
    sums.lags.merge(piece);
  }
  if (pieces > 0.0) sums.run_means.add(total / pieces);
}

void EvidenceRecorder::close_run(bool well) {
  if (!run_.open) return;
  run_.open = false;
  for (std::size_t i = 0; i < run_.innovations.size(); ++i) close_innovations(i);
  if (well) run_.law.add_to(sums_.law);
  if (!well || run_.nees.empty()) return;
  run_.score.add_to(sums_.scores);
  run_.lateness.add_to(sums_.lateness);
  RunSums& runs = sums_.whole_runs;
  runs.nees_values.merge(run_.values);
  // Of blocks whose covariances are not known the sum is no χ²: the smallest of them bounds its spread.
  if (!layout_.joint_covariance) {
    for (const RunSum& block : run_.blocks)
      run_.whole.least_dof = std::min(run_.whole.least_dof, block.least_dof);
  }
  run_.whole.add_to(sums_.study.nees_of_runs);
  run_.vehicle.add_to(sums_.study.vehicle_nees_of_runs);
  runs.nees.push_back(std::move(run_.nees));
  for (std::size_t b = 0; b < run_.blocks.size(); ++b) {
    if (run_.squared_error[b].count == 0) continue;
    BlockSums& sums = sums_of_block(b);
    sums.squared_error.add(run_.squared_error[b].mean);
    run_.blocks[b].add_to(sums.runs);
  }
  if (const Vector& u = run_.last_whitened; u.size() > 0 && u.size() <= kLargestState) {
    if (runs.last_whitened.count == 0 || runs.last_whitened.mean.size() == u.size()) {
      runs.last_whitened.add(u);
    }
  }
  if (run_.last_error.size() == 0) return;
  runs.last_error.push_back(std::move(run_.last_error));
  runs.last_covariance.push_back(std::move(run_.last_covariance));
}

}  // namespace credence
