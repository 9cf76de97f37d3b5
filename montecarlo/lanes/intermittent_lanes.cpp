#include "montecarlo/lanes/intermittent_lanes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace credence::internal {
namespace {

static_assert(IntermittentLanes::kLanes == kNoiseLanes);

constexpr std::size_t kTile = kNoiseLanes;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

Index anchors_of(const LinearModel& model) { return model.measurement_dim() - (model.state_dim() - 1); }

/// True for what monobot_model makes.
bool is_monobot(const LinearModel& m) {
  const Index anchors = anchors_of(m);
  if (m.state_dim() < 1 || m.measurement_dim() < 1 || anchors < 0 || m.Q.size() != 1) return false;
  const LinearModel like = monobot_model(m.state_dim() - 1, anchors, m.Q(0, 0), m.R(0, 0), m.P0(0, 0));
  return m.F == like.F && m.G == like.G && m.H == like.H && m.R == like.R && m.P0 == like.P0;
}

/// Of all runs at a step; NIS is only of those that saw something.
constexpr std::pair<Quantity, IntermittentValue> kQuantities[] = {
    {Quantity::nees, kNeesValue},
    {Quantity::trace_prior, kTracePriorValue},
    {Quantity::trace, kTraceValue},
    {Quantity::trace_vehicle, kVehicleValue},
    {Quantity::trace_landmarks, kLandmarksValue},
};

/// The sum of whole numbers.
std::int64_t total(const double* x) {
  double sums[8] = {};
  for (std::size_t i = 0; i < kTile; ++i) sums[i % 8] += x[i];
  return static_cast<std::int64_t>(std::accumulate(sums, sums + 8, 0.0));
}

/// Of all lanes, `count` of which are not zero by definition, the moments of these.
Moments without_zeros(double mean, double m2, std::int64_t count) {
  if (count == 0) return {};
  const auto n = static_cast<double>(count);
  const double own = mean * kNoiseLanes / n;
  // Chan's rule for merging, backwards; rounding may leave less than nothing.
  return {
      .count = count, .mean = own, .m2 = std::max(0.0, m2 - own * own * n * (kNoiseLanes - n) / kNoiseLanes)};
}

std::vector<LinearModel> joined(const LinearModel& first, const std::vector<LinearModel>& later) {
  std::vector<LinearModel> all{first};
  all.insert(all.end(), later.begin(), later.end());
  return all;
}

/// Steps whose noise fills half of a common L1 cache.
Index steps_of_block(Index measurements) {
  constexpr Index kDoubles = 2048;
  return std::clamp<Index>(kDoubles / ((2 * measurements + 1) * kNoiseLanes) / 4, 1, 4) * 4;
}

}  // namespace

std::vector<LinearModel> IntermittentProblem::truth_period() const { return joined(truth, truth_later); }

std::vector<LinearModel> IntermittentProblem::assumed_period() const {
  return joined(assumed, assumed_later);
}

bool IntermittentLanes::support(const IntermittentProblem& p) {
  const bool decorrelates = p.rule.inflation != Inflation::none;
  return p.measurement_delay == 0 && !p.is_periodic() && is_monobot(p.truth) && is_monobot(p.assumed) &&
         p.truth.H == p.assumed.H && p.assumed.R(0, 0) > 0.0 && p.assumed.P0(0, 0) > 0.0 &&
         (!decorrelates || p.rule.solution == InflationSolution::pairwise);
}

IntermittentLanes::IntermittentLanes(const IntermittentProblem& problem, const NoiseSource& source)
    : probability_(problem.detection_probability),
      initial_std_(std::sqrt(problem.truth.P0(0, 0))),
      initial_(problem.assumed.P0),
      kernel_(&intermittent_kernel(source.instruction_set())),
      source_(source),
      measurements_(problem.truth.measurement_dim()),
      block_(steps_of_block(measurements_)) {
  if (!support(problem)) throw std::invalid_argument("IntermittentLanes: this problem does not go in lanes");
  const LinearModel &truth = problem.truth, &assumed = problem.assumed;
  const Index n = truth.state_dim(), triangle = n * (n + 1) / 2;
  const Matrix& constant = problem.rule.constant;
  constant_.resize(constant.size() > 0 ? triangle : 0);
  for (Index i = 0, k = 0; i < constant.rows(); ++i) {
    for (Index j = 0; j <= i; ++j) constant_[k++] = constant(i, j);
  }
  const Index first_decorrelated = problem.rule.inflation == Inflation::full  ? 0
                                   : problem.rule.inflation == Inflation::map ? 1
                                                                              : n;
  plan_ = {.states = static_cast<std::int32_t>(n),
           .anchors = static_cast<std::int32_t>(anchors_of(truth)),
           .first_decorrelated = static_cast<std::int32_t>(first_decorrelated),
           .process_variance = assumed.Q(0, 0),
           .measurement_variance = assumed.R(0, 0),
           .process_std = std::sqrt(truth.Q(0, 0)),
           .measurement_std = std::sqrt(truth.R(0, 0)),
           .constant = constant_.size() > 0 ? constant_.data() : nullptr};
  errors_.resize(at(n) * kTile);
  covariance_.resize(at(triangle) * kTile);
  work_.resize(at(triangle + 3 * n) * kTile);
  process_.resize(at(block_) * kTile);
  measurement_.resize(at(block_ * measurements_) * kTile);
  seen_.resize(at(block_ * measurements_) * kTile);
  values_.resize(at(block_ * kIntermittentValues) * kTile);
  mean_.resize(at(block_ * kIntermittentValues));
  m2_.resize(mean_.size());
}

void IntermittentLanes::start(std::int64_t first_run, int runs) {
  first_run_ = first_run;
  runs_ = runs;
  step_ = count_ = drawn_ = 0;
  ended_.fill({});
  run_nees_.fill(0.0);
  failed_ = false;
  const Index n = plan_.states, triangle = n * (n + 1) / 2;
  for (int lane = 0; lane < kLanes; ++lane) {
    // into memory that is not used yet
    source_.normals(first_run + lane, 0, NoisePurpose::initial, {work_.data(), at(n)});
    for (Index i = 0; i < n; ++i) errors_[index(n, i, lane)] = initial_std_ * work_[at(i)];
    for (Index i = 0, row = 0; i < n; ++i) {
      for (Index j = 0; j <= i; ++j) covariance_[index(triangle, row++, lane)] = initial_(i, j);
    }
  }
}

std::size_t IntermittentLanes::index(Index rows, Index row, int lane) const {
  const int width = kernel_->lanes;
  return at((lane / width * rows + row) * width + lane % width);
}

void IntermittentLanes::draw() {
  source_.normals_of_runs(first_run_, drawn_ + 1, block_, NoisePurpose::process, 1, process_);
  source_.normals_of_runs(first_run_, drawn_ + 1, block_, NoisePurpose::measurement, measurements_,
                          measurement_);
  source_.events_of_runs(first_run_, drawn_ + 1, block_, NoisePurpose::detection, probability_, measurements_,
                         seen_);
  drawn_ += block_;
}

Index IntermittentLanes::advance(Index most) {
  if (step_ == drawn_) draw();
  count_ = std::min(most, drawn_ - step_);
  const std::size_t first = at(step_ - (drawn_ - block_)) * kTile;
  kernel_->steps(plan_, count_,
                 {.errors = errors_.data(),
                  .covariance = covariance_.data(),
                  .process = process_.data() + first,
                  .measurement = measurement_.data() + first,
                  .seen = seen_.data() + first,
                  .drawn = block_,
                  .work = work_.data(),
                  .values = values_.data()});
  step_ += count_;
  kernel_->moments(values_.data(), count_ * kIntermittentValues, mean_.data(), m2_.data());
  find_failures();
  for (Index k = 0; k < count_; ++k) {
    const double* nees = values(k, kNeesValue);
    for (std::size_t lane = 0; lane < kTile; ++lane) run_nees_[lane] += nees[lane];
  }
  return count_;
}

const double* IntermittentLanes::values(Index step, int value) const {
  return values_.data() + at(step * kIntermittentValues + value) * kTile;
}

void IntermittentLanes::find_failures() {
  const auto find = [&](Index k) {
    const double *check = values(k, kCheckValue), *nees = values(k, kNeesValue), *nis = values(k, kNisValue);
    const double* trace = values(k, kTracePriorValue);
    for (int lane = 0; lane < runs_; ++lane) {
      RunFailure& end = ended_[at(lane)];
      const bool ok = check[lane] == 0.0 && trace[lane] < kLargestTrace && std::isfinite(nees[lane]) &&
                      std::isfinite(nis[lane]);
      if (ok || end.outcome != Outcome::ok) continue;
      end = {first_run_ + lane, step_ - count_ + k + 1, Outcome::not_positive_definite};
      failed_ = true;
    }
  };
  for (Index k = 0; k < count_; ++k) {
    // A sum of numbers of which none is positive, of positive ones, or of one that is not finite.
    const auto mean = [&](int value) { return mean_[at(k * kIntermittentValues + value)]; };
    const bool ok = mean(kCheckValue) == 0.0 && mean(kTracePriorValue) < kLargestTrace / kTile &&
                    std::isfinite(mean(kNeesValue)) && std::isfinite(mean(kNisValue));
    if (!ok) find(k);
  }
}

bool IntermittentLanes::counts(int lane, Index step) const {
  const RunFailure& end = ended_[at(lane)];
  return end.outcome == Outcome::ok || step < end.step;
}

void IntermittentLanes::add_to(StudyStatistics& statistics) const {
  const Index begin = step_ - count_;
  for (Index k = 0; k < count_; ++k) {
    StepStatistics& s = statistics.steps[at(begin + k)];
    if (runs_ == kLanes && !failed_) {
      add_all(k, s);
    } else {
      for (int lane = 0; lane < runs_; ++lane) {
        if (counts(lane, begin + k + 1)) add_one(k, lane, s);
      }
    }
  }
  for (const RunFailure& end : ended_) {
    if (end.outcome != Outcome::ok && end.step > begin && end.step <= step_)
      statistics.failures.push_back(end);
  }
}

void IntermittentLanes::add_runs_to(StudyStatistics& statistics) const {
  const auto dof = static_cast<double>(plan_.states * step_);
  for (int lane = 0; lane < runs_; ++lane) {
    if (ended_[at(lane)].outcome == Outcome::ok)
      statistics.nees_of_runs.add(run_nees_[at(lane)], dof, plan_.states);
  }
}

void IntermittentLanes::add_all(Index k, StepStatistics& s) const {
  for (const auto& [quantity, value] : kQuantities) {
    const std::size_t row = at(k * kIntermittentValues + value);
    s[quantity].merge({.count = kLanes, .mean = mean_[row], .m2 = m2_[row]});
  }
  double seen[kTile] = {};
  for (Index r = 0; r < measurements_; ++r) {
    const double* row = seen_of(r, k);
    for (std::size_t lane = 0; lane < kTile; ++lane) seen[lane] += row[lane];
  }
  s.nis_dof += total(seen);
  for (double& lane : seen) lane = lane > 0.0 ? 1.0 : 0.0;
  const std::size_t nis = at(k * kIntermittentValues + kNisValue);
  s[Quantity::nis].merge(without_zeros(mean_[nis], m2_[nis], total(seen)));
  s.nees_dof += plan_.states * kLanes;
}

void IntermittentLanes::add_one(Index k, int lane, StepStatistics& s) const {
  for (const auto& [quantity, value] : kQuantities) s[quantity].add(values(k, value)[lane]);
  std::int64_t seen = 0;
  for (Index r = 0; r < measurements_; ++r) seen += static_cast<std::int64_t>(seen_of(r, k)[lane]);
  if (seen > 0) s[Quantity::nis].add(values(k, kNisValue)[lane]);
  s.nis_dof += seen;
  s.nees_dof += plan_.states;
}

Vector IntermittentLanes::error(int lane) const {
  Vector e(plan_.states);
  for (Index i = 0; i < e.size(); ++i) e[i] = errors_[index(e.size(), i, lane)];
  return e;
}

Matrix IntermittentLanes::covariance(int lane) const {
  const Index n = plan_.states, triangle = n * (n + 1) / 2;
  Matrix P(n, n);
  for (Index i = 0, row = 0; i < n; ++i) {
    for (Index j = 0; j <= i; ++j) P(i, j) = P(j, i) = covariance_[index(triangle, row++, lane)];
  }
  return P;
}

const double* IntermittentLanes::seen_of(Index row, Index k) const {
  const Index in_block = step_ - count_ + k - (drawn_ - block_);
  return seen_.data() + at(row * block_ + in_block) * kTile;
}

}  // namespace credence::internal
