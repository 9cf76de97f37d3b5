#include "analysis/evidence/sums/evidence_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "analysis/evidence/causes/relative_place.h"
#include "analysis/evidence/sums/step_series.h"
#include "core/manifold/angle.h"
#include "core/record/unwrapped_angles.h"

namespace credence::internal {
namespace {

/// to = values(places), by which Eigen would copy the places onto the heap.
template <class To>
void copy_places(const Vector& values, std::span<const Index> places, To& to) {
  for (std::size_t i = 0; i < places.size(); ++i) to[static_cast<Index>(i)] = values[places[i]];
}

static_assert(is_checked(kLargestAveragedMap, 3, 100), "every step of what is averaged tells its covariance");

}  // namespace

void EvidenceRecorder::begin_file(const std::filesystem::path& file, const RunLayout& layout) {
  file_ = file.string();
  if (sums_.layout.states.empty()) sums_.layout = layout;
  if (layout == layout_) return;
  close_runs();
  layout_ = layout;
  places_.clear();
  list_blocks();
}

void EvidenceRecorder::list_blocks() {
  block_at_.clear();
  position_ = position_block(layout_);
  lead_ = lead_block(layout_);
  planar_map_ = has_planar_map(layout_);
  averaged_dim_ = -1;
  averaged_.clear();
  if (!layout_.has_truth) return;
  for (const Block& block : layout_.blocks) {
    const BlockSums& sums = sums_.block(block);  // which may move all of them
    block_at_.push_back(static_cast<std::size_t>(&sums - sums_.blocks.data()));
  }
  const Index all = std::ssize(layout_.states);
  if (const Index largest = largest_averaged(layout_); all <= largest) {
    averaged_dim_ = all;
  } else if (lead_ >= 0) {
    const Block& lead = layout_.blocks[static_cast<std::size_t>(lead_)];
    const Index dim = std::ssize(lead.states);
    if (dim <= largest) averaged_dim_ = dim;
    averaged_ = lead.name;
  }
  if (sums_.law.second_moments.dim() == 0) sums_.law.averaged = averaged_;
}

void EvidenceRecorder::begin_runs(std::int64_t count) {
  close_runs();
  if (sums_.study.runs == kChunkRuns) full_.push_back(take());
  const auto size = static_cast<std::size_t>(count);
  runs_.resize(size);
  places_.resize(size);
  const bool few = few_ && sums_.study.runs + count <= StretchSums::kMostRuns;
  for (OpenRun& run : runs_) {
    std::vector<RunInnovations> innovations = std::move(run.innovations);  // they keep their memory
    run = {};
    run.open = true;
    run.law.few = run.law.averaged.by_group = few;
    run.first = sums_.study.runs++ == 0;
    run.squares.resize(layout_.blocks.size());
    run.blocks.resize(layout_.blocks.size());
    if (few) run.block_nees.resize(layout_.blocks.size());
    for (RunInnovations& of_sensor : innovations) of_sensor.begin_run();
    innovations.resize(layout_.sensors.size());
    run.innovations = std::move(innovations);
  }
}

void EvidenceRecorder::end_run(Outcome outcome, std::int64_t step, std::size_t i) {
  OpenRun& run = runs_[i];
  if (outcome != Outcome::ok) {
    const std::int64_t number = sums_.study.runs - std::ssize(runs_) + static_cast<std::int64_t>(i);
    sums_.study.failures.push_back({number, step, outcome});
    if (!run.nees.empty()) {
      const auto least_dof = static_cast<double>(run.whole.least_dof);
      sums_.whole_runs.failed.push_back({number, step, course_of(run.nees, least_dof)});
    }
  }
  close_run(run, outcome == Outcome::ok);
}

Evidence EvidenceRecorder::take() {
  close_runs();
  Evidence taken = std::move(sums_);
  sums_ = Evidence();
  sums_.layout = layout_;
  list_blocks();
  return taken;
}

void EvidenceRecorder::count(std::int64_t step) {
  ++sums_.rows;
  sums_.has_truth = sums_.has_truth || layout_.has_truth;
  sums_.joint_covariance = sums_.joint_covariance && layout_.joint_covariance;
  sums_.thin_steps(step);
  const std::int64_t stride = sums_.step_stride, before = step - 1;
  entry_ = stride == 1 ? step : before % stride == 0 ? before / stride + 1 : 0;
  if (entry_ > 0) at_step(sums_.study.steps, entry_);  // a step that is rejected is one, too
}

bool EvidenceRecorder::add(const Step& step, std::size_t i) {
  count(step.step);
  StepPlaces& places = places_[i];
  if (!step.states.empty()) places.find(step.states, layout_);
  const std::string_view problem = normaliser_.normalise(step, layout_, places, normalised_);
  if (!problem.empty()) {
    reject(runs_[i], step.line, problem);
    return false;
  }
  add(runs_[i], places, normalised_);
  return true;
}

void EvidenceRecorder::add(const NormalisedStep& step, std::size_t i) {
  count(step.step);
  if (!step.states.empty()) places_[i].find(step.states, layout_);
  add(runs_[i], places_[i], step);
}

void EvidenceRecorder::reject(std::int64_t step, std::int64_t line, std::string_view problem, std::size_t i) {
  count(step);
  reject(runs_[i], line, problem);
}

void EvidenceRecorder::add(OpenRun& run, const StepPlaces& places, const NormalisedStep& step) {
  sums_.state_dim = std::max(sums_.state_dim, step.error.size());
  run.change = kNaN;
  ++run.rows;
  for (const Index state : step.wrongly_certain)
    count_row(step.line, sums_.wrongly_certain[layout_.states[static_cast<std::size_t>(state)]]);
  if (!step.states.empty()) add_state(run, places, step);
  add_innovations(run, step);
}

void EvidenceRecorder::count_row(std::int64_t line, CountedRows& rows) const {
  if (rows.count++ == 0 && !file_.empty()) rows.first = fmt::format("{}:{}", file_, line);
}

void EvidenceRecorder::reject(OpenRun& run, std::int64_t line, std::string_view problem) {
  count_row(line, sums_.rejected[std::string(problem)]);
  for (RunInnovations& innovations : run.innovations) innovations.begin_step();
}

void EvidenceRecorder::sum_blocks(const StepPlaces& at, const NormalisedStep& step) {
  squares_.assign(at.of_block.size(), {});
  for (std::size_t b = 0; b < squares_.size(); ++b) {
    BlockSquares& of = squares_[b];
    for (const Index i : at.of_block[b]) {
      of.claimed += step.variance[i];
      of.error += step.error[i] * step.error[i];
    }
  }
}

void EvidenceRecorder::add_traces(const StepPlaces& at, const NormalisedStep& step, StepStatistics& s) const {
  double all = 0.0;
  for (const double variance : step.variance) all += variance;  // in the order of the engine, for its bits
  s[Quantity::trace].add(all);
  for (std::size_t b = 0; b < at.of_block.size(); ++b) {
    const std::vector<Index>& places = at.of_block[b];
    const Part part = layout_.blocks[b].part;
    if (part == Part::other || part == Part::pose || part == Part::landmark) continue;
    const double trace = squares_[b].claimed, squared = squares_[b].error;
    if (part == Part::map) {
      s[Quantity::trace_landmarks].add(trace);
      if (places.empty()) continue;
      const double landmarks = static_cast<double>(places.size()) / static_cast<double>(layout_.landmark_dim);
      s[Quantity::landmark_error_squared].add(squared / landmarks);
      s[Quantity::landmark_variance].add(trace / landmarks);
    } else if (!places.empty() && part == Part::position) {
      s[Quantity::trace_vehicle].add(trace);
      s[Quantity::position_error_squared].add(squared);
    } else if (!places.empty()) {
      s[Quantity::heading_error_squared].add(squared);
      s[Quantity::heading_variance].add(trace);
    }
  }
}

void EvidenceRecorder::add_state(OpenRun& run, const StepPlaces& places, const NormalisedStep& step) {
  const NormalisedSquare& whole = step.whole;
  sum_blocks(places, step);
  if (entry_ > 0) {
    StepStatistics& s = at_step(sums_.study.steps, entry_);
    s[Quantity::nees].add(whole.value);
    s.nees_dof += whole.dof;
    add_traces(places, step, s);
  }
  for (std::size_t b = 0; b < step.blocks.size(); ++b) {
    const auto [value, dof] = step.blocks[b];
    if (dof < 0) continue;
    const Block& block = layout_.blocks[b];
    if (block.part == Part::pose) {
      if (entry_ > 0) at_step(sums_.study.steps, entry_)[Quantity::vehicle_nees].add(value);
      run.vehicle.add(value, dof);
    }
    run.blocks[b].add(value, dof);
    if (dof > 0 && !run.block_nees.empty()) run.block_nees[b].add(value / static_cast<double>(dof));
    if (entry_ > 0) at_step(sums_of_block(b).nees, entry_).add(value, dof);
    const std::vector<Index>& at = places.of_block[b];
    const double share = block.part == Part::map
                             ? static_cast<double>(layout_.landmark_dim) / static_cast<double>(at.size())
                             : 1.0;
    BlockSquares& of_run = run.squares[b];
    of_run.error += share * squares_[b].error;
    of_run.claimed += share * squares_[b].claimed;
    ++of_run.steps;
  }
  if (whole.dof <= 0) return;
  const double per_dof = whole.value / static_cast<double>(whole.dof);
  if (whole.dof == run.dof) run.change = step.log_determinant - run.log_determinant;
  run.dof = whole.dof;
  run.log_determinant = step.log_determinant;
  if (entry_ > 0) sums_.coverage.add(entry_, whole.value, whole.dof);
  run.values.add(whole.value);
  run.nees.push_back(per_dof);
  run.whole.add(whole.value, whole.dof);
  if (step.P.size() > 0) {
    run.last_state.error = step.error;
    run.last_state.P = step.P;
  }
  if (lead_ >= 0) run.last = step.lead;
  if (whole.value > WholeTurns::kGross) add_turns_of_states(run, step);
  for (const Index i : places.angles) sums_.narrow_angles.add(step.variance[i] <= kWideAngle * kWideAngle);
  add_law(run, places, step);
  add_lateness(run, step);
  add_scores(run, step);
  if (run.first) sums_.first_run.push_back(per_dof);
  if (whole.value > outlier_limit(whole.dof)) {
    ++sums_.nees_outliers;
  } else if (entry_ > 0) {
    at_step(sums_.clean_nees, entry_).add(whole.value, whole.dof);
  }
}

void EvidenceRecorder::add_turns_of_states(OpenRun& run, const NormalisedStep& step) const {
  for (std::size_t i = 0; i < step.states.size(); ++i) {
    const Index state = step.states[i], at = static_cast<Index>(i);
    const double error = step.error[at], variance = step.variance[at];
    if (WholeTurns::concerns(error, variance) && !layout_.angles[static_cast<std::size_t>(state)])
      run.turns[state].add(error, variance);
  }
}

// Of a map that grows the landmarks to come have no error, as states that P knows for certain.
void EvidenceRecorder::add_large(RunLaw& run, const NormalisedStep& step) {
  constexpr Index kRowsOfGroup = 32;
  whitened_.setZero(std::min(std::ssize(layout_.states), StretchSums::kLargest));
  for (std::size_t i = 0; i < step.states.size(); ++i) {
    const auto from = static_cast<Index>(i);
    const Index at = step.states[i];
    if (at < whitened_.size() && step.variance[from] > 0.0)
      whitened_[at] = step.error[from] / std::sqrt(step.variance[from]);
  }
  run.large.add_each(whitened_, kRowsOfGroup);
}

void EvidenceRecorder::add_averaged(RunLaw& run, const Vector& error, const Vector& variance,
                                    const Matrix& P) {
  if (!run.add_error(error, variance) || !whitening_.compute(P)) return;
  whitening_.whiten(error, whitened_);
  run.add_whitened(whitened_, P);
}

void EvidenceRecorder::add_law(OpenRun& run, const StepPlaces& places, const NormalisedStep& step) {
  const NormalisedSquare& whole = step.whole;
  const double dof = static_cast<double>(whole.dof);
  run.law.nees_tails.add(whole.value, dof);
  if (!layout_.joint_covariance) return;
  const Index all = std::ssize(layout_.states);
  const bool whole_state = whole.dof == all, complete = whole_state && step.P.rows() == all;
  const bool averaged = averaged_.empty() && complete;
  if (run.law.few && !averaged) add_large(run.law, step);
  if (run.law.few && whole_state) run.law.samples.add(step.error, step.variance);
  if (run.law.few && lead_ >= 0 && step.lead.error.size() > 0) {
    variance_ = step.lead.P.diagonal();
    run.law.lead_samples.add(step.lead.error, variance_);
  }
  if (averaged) {
    add_averaged(run.law, step.error, step.variance, step.P);
  } else if (!averaged_.empty() && step.blocks[static_cast<std::size_t>(lead_)].dof == averaged_dim_) {
    const std::vector<Index>& lead = places.of_block[static_cast<std::size_t>(lead_)];
    variance_.resize(std::ssize(lead));
    copy_places(step.variance, lead, variance_);
    add_averaged(run.law, step.lead.error, variance_, step.lead.P);
  }
  if (complete && all <= LawSums::kLargestShape && is_shape_step(step.step) && whitening_.compute(step.P)) {
    whitening_.whiten(step.error, whitened_);
    sums_.law.add_whitened(step.step, whitened_);
  }
}

void EvidenceRecorder::add_moving(RunLateness& run, const VectorRef& error, const VectorRef& motion,
                                  const MatrixRef& P, CorrelationWhitening& whitening) {
  if (!whitening.compute(P)) return;
  whitening.whiten(error, moved_);
  whitening.whiten(motion, motion_);
  run.add(moved_, motion_);
}

// Of what moves: in a map a landmark as seen from the vehicle, since a map made of late observations is
// displaced and the vehicle within it is not. The step is that of the mean over a few, in which what
// corrections add is smaller.
void EvidenceRecorder::add_lateness(OpenRun& run, const NormalisedStep& step) {
  if (step.estimate.size() == 0) return;
  if (run.way_states != step.states) {
    run.way_states = step.states;
    run.way_steps = 0;
  }
  const std::size_t most = run.way.size();
  WayPoint& newest = run.way[run.way_steps++ % most];
  double sine = kNaN, cosine = kNaN;
  const std::vector<Index>& places = step.moving.places;
  if (run.way_steps > 1 && !places.empty()) {
    const WayPoint& oldest = run.way_steps > most ? newest : run.way.front();
    const Vector& before = oldest.estimate;
    const auto steps = static_cast<double>(std::min(most, run.way_steps - 1));
    if (planar_map_) {
      RelativePlace::State now, then;
      copy_places(step.estimate, places, now);
      copy_places(before, places, then);
      const RelativePlace place(now), truth(now - step.moving.error);
      const RelativePlace of_then =
          std::isnan(oldest.sine) ? RelativePlace(then) : RelativePlace(then, oldest.sine, oldest.cosine);
      sine = place.sine;
      cosine = place.cosine;
      const Eigen::Matrix2d P = place.covariance(RelativePlace::Covariance(step.moving.P));
      add_moving(run.lateness, Eigen::Vector2d(place.r - truth.r),
                 Eigen::Vector2d((place.r - of_then.r) / steps), P, of_moving_);
    } else if (std::ssize(places) <= RunLateness::kLargest) {
      Eigen::Matrix<double, Eigen::Dynamic, 1, 0, RunLateness::kLargest, 1> motion(std::ssize(places));
      for (Index i = 0; i < motion.size(); ++i) {
        const Index at = places[static_cast<std::size_t>(i)];
        const Index state = step.states[static_cast<std::size_t>(at)];
        motion[i] = step.estimate[at] - before[at];
        if (layout_.angles[static_cast<std::size_t>(state)]) motion[i] = wrap_angle(motion[i]);
        motion[i] /= steps;
      }
      const bool all = std::ssize(places) == step.P.rows();
      add_moving(run.lateness, step.moving.error, motion, step.moving.P, all ? whitening_ : of_moving_);
    }
  }
  newest.estimate = step.estimate;
  newest.sine = sine;
  newest.cosine = cosine;
}

void EvidenceRecorder::add_scores(OpenRun& run, const NormalisedStep& step) const {
  if (!layout_.joint_covariance) return;
  run.score.add(step.whole.value, step.whole.dof, step.log_determinant);
  if (position_ < 0) return;
  if (step.blocks[static_cast<std::size_t>(position_)].dof >= 0) run.score.last_position = step.position;
}

void EvidenceRecorder::add_innovation(OpenRun& run, std::size_t i, const NormalisedInnovation& value) {
  const Sensor& sensor = layout_.sensors[i];
  SensorSums& sums = sums_.sensor(sensor);
  if (entry_ > 0) at_step(sums.nis, entry_).add(value.value, value.dof);
  if (value.complete) sums.unwrapped += count_unwrapped(value.nu, sensor.angles);
  if (value.value > WholeTurns::kGross) {
    run.innovation_turns.resize(layout_.sensors.size());
    add_turns(value.nu, value.variance, sensor.piece, sensor.angles, run.innovation_turns[i]);
  }
  run.innovations[i].add(sensor, value, run.change, run.log_determinant - run.change);
}

void EvidenceRecorder::add_innovations(OpenRun& run, const NormalisedStep& step) {
  double total = 0.0;
  Index dof = 0;
  for (std::size_t i = 0; i < step.innovations.size(); ++i) {
    const NormalisedInnovation& value = step.innovations[i];
    run.innovations[i].begin_step();
    if (value.dof <= 0) continue;
    total += value.value;
    dof += value.dof;
    run.law.nis_tails.add(value.value, static_cast<double>(value.dof));
    add_innovation(run, i, value);
  }
  if (dof == 0) return;
  const double m = static_cast<double>(dof);
  run.law.nis += total;
  run.law.nis_dof += m;
  const bool outlier = total > outlier_limit(dof);
  if (outlier) ++sums_.nis_outliers;
  if (entry_ == 0) return;
  StepStatistics& s = at_step(sums_.study.steps, entry_);
  s[Quantity::nis].add(total);
  s.nis_dof += dof;
  at_step(sums_.law.nis_at, entry_).add(total / m);
  if (!outlier) at_step(sums_.clean_nis, entry_).add(total, dof);
}

void EvidenceRecorder::close_runs() {
  for (OpenRun& run : runs_) close_run(run, true);
}

void EvidenceRecorder::close_run(OpenRun& run, bool well) {
  if (!run.open) return;
  run.open = false;
  add_innovations_of_run(run.innovations, layout_, sums_);
  for (const auto& [state, turns] : run.turns)
    sums_.turns[layout_.states[static_cast<std::size_t>(state)]].add_run(turns, run.rows);
  for (std::size_t i = 0; i < run.innovation_turns.size(); ++i) {
    const std::vector<WholeTurns>& turns = run.innovation_turns[i];
    if (!turns.empty()) add_run(turns, run.rows, sums_.sensor(layout_.sensors[i]).turns);
  }
  if (well) run.law.add_to(sums_.law, averaged_);
  if (!well || run.nees.empty()) return;
  run.score.add_to(sums_.scores);
  run.lateness.add_to(sums_.lateness);
  RunSums& runs = sums_.whole_runs;
  runs.nees_values.merge(run.values);
  // Of blocks whose covariances are not known the sum is no χ²: the smallest of them bounds its spread.
  if (!layout_.joint_covariance) {
    for (const RunSum& block : run.blocks)
      run.whole.least_dof = std::min(run.whole.least_dof, block.least_dof);
  }
  run.whole.add_to(sums_.study.nees_of_runs);
  run.vehicle.add_to(sums_.study.vehicle_nees_of_runs);
  const RunSamples* samples = run.law.few ? &run.law.samples_of_all(std::ssize(run.nees)) : nullptr;
  runs.add(std::move(run.nees), samples);
  for (std::size_t b = 0; b < run.blocks.size(); ++b) {
    const BlockSquares& of_run = run.squares[b];
    if (of_run.steps == 0) continue;
    const auto steps = static_cast<double>(of_run.steps);
    BlockSums& sums = sums_of_block(b);
    sums.squared_error.add(of_run.error / steps);
    sums.claimed.add(of_run.claimed / steps);
    run.blocks[b].add_to(sums.runs);
    if (!run.block_nees.empty() && run.blocks[b].dof > 0.0) sums.few.push_back(std::move(run.block_nees[b]));
  }
  if (run.last_state.P.size() > 0) close_last(run.last_state);
  if (run.last.error.size() == 0) return;
  runs.last_error.push_back(std::move(run.last.error));
  runs.last_covariance.push_back(std::move(run.last.P));
}

/// The states that P does not know for certain, where it is of full rank over them.
void EvidenceRecorder::close_last(const BlockError& state) {
  std::vector<Index> varied;
  for (Index i = 0; i < state.error.size(); ++i) {
    if (state.P(i, i) > 0.0) varied.push_back(i);
  }
  const auto add = [&](const MatrixRef& P, const VectorRef& error) {
    if (!whitening_.compute(P)) return;
    whitening_.whiten(error, whitened_);
    VectorMoments& last = sums_.whole_runs.last_whitened;
    if (last.count == 0 || last.mean.size() == whitened_.size()) last.add(whitened_);
  };
  if (varied.empty()) return;
  if (std::ssize(varied) == state.error.size()) return add(state.P, state.error);
  add(Matrix(state.P(varied, varied)), Vector(state.error(varied)));
}

}  // namespace credence::internal
