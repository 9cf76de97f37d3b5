#include "montecarlo/intermittent_lanes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace credence {
namespace {

static_assert(IntermittentLanes::kLanes == kNoiseLanes);

constexpr std::size_t kWidth = kNoiseLanes;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

Index anchors_of(const LinearModel& model) { return model.measurement_dim() - (model.state_dim() - 1); }

/// True for what monobot_model makes.
bool is_monobot(const LinearModel& m) {
  const Index anchors = anchors_of(m);
  if (m.state_dim() < 1 || m.measurement_dim() < 1 || anchors < 0 || m.Q.size() != 1) return false;
  const LinearModel like = monobot_model(m.state_dim() - 1, anchors, m.Q(0, 0), m.R(0, 0), m.P0(0, 0));
  return m.F == like.F && m.G == like.G && m.H == like.H && m.R == like.R && m.P0 == like.P0;
}

/// Of 32 values: as eight sums, so that lanes of any width add them.
double sum_of(const double* x) {
  double sums[8];
  for (int i = 0; i < 8; ++i) sums[i] = (x[i] + x[i + 8]) + (x[i + 16] + x[i + 24]);
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

Moments moments_of(const double* x) {
  const double mean = sum_of(x) / kNoiseLanes;
  double squares[kWidth];
  for (std::size_t i = 0; i < kWidth; ++i) squares[i] = (x[i] - mean) * (x[i] - mean);
  return {.count = kNoiseLanes, .mean = mean, .m2 = sum_of(squares)};
}

constexpr std::pair<Quantity, IntermittentValue> kQuantities[] = {
    {Quantity::nees, kNeesValue},
    {Quantity::nis, kNisValue},
    {Quantity::trace_prior, kTracePriorValue},
    {Quantity::trace, kTraceValue},
    {Quantity::trace_vehicle, kVehicleValue},
    {Quantity::trace_landmarks, kLandmarksValue},
};

/// Steps whose noise fills half of a common L1 cache.
Index steps_of_block(Index measurements) {
  constexpr Index kDoubles = 2048;
  return std::clamp<Index>(kDoubles / ((2 * measurements + 1) * kNoiseLanes) / 4, 1, 4) * 4;
}

}  // namespace

bool IntermittentLanes::support(const IntermittentProblem& p) {
  const bool decorrelates = p.rule.inflation != Inflation::none;
  return is_monobot(p.truth) && is_monobot(p.assumed) && p.truth.H == p.assumed.H &&
         p.assumed.R(0, 0) > 0.0 && p.assumed.P0(0, 0) > 0.0 &&
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
  errors_.resize(at(n) * kWidth);
  covariance_.resize(at(triangle) * kWidth);
  work_.resize(at(triangle + 4 * n) * kWidth);
  process_.resize(at(block_) * kWidth);
  measurement_.resize(at(block_ * measurements_) * kWidth);
  seen_.resize(at(block_ * measurements_) * kWidth);
  values_.resize(at(block_ * kIntermittentValues) * kWidth);
}

void IntermittentLanes::start(std::int64_t first_run, int runs) {
  first_run_ = first_run;
  runs_ = runs;
  step_ = count_ = drawn_ = 0;
  ended_.fill({});
  const std::size_t n = at(plan_.states);
  for (std::size_t lane = 0; lane < kWidth; ++lane) {
    // into memory that is not used yet
    source_.normals(first_run + static_cast<std::int64_t>(lane), 0, NoisePurpose::initial, {work_.data(), n});
    for (std::size_t i = 0; i < n; ++i) errors_[i * kWidth + lane] = initial_std_ * work_[i];
  }
  double* row = covariance_.data();
  for (Index i = 0; i < plan_.states; ++i) {
    for (Index j = 0; j <= i; ++j, row += kWidth) std::fill_n(row, kWidth, initial_(i, j));
  }
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
  const std::size_t first = at(step_ - (drawn_ - block_)) * kWidth;
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
  find_failures();
  return count_;
}

const double* IntermittentLanes::values(Index step, int value) const {
  return values_.data() + at(step * kIntermittentValues + value) * kWidth;
}

void IntermittentLanes::find_failures() {
  for (Index k = 0; k < count_; ++k) {
    const double *check = values(k, kCheckValue), *nees = values(k, kNeesValue), *nis = values(k, kNisValue);
    double wrong[kWidth];  // 0, or less than 0, or NaN
    for (std::size_t i = 0; i < kWidth; ++i) wrong[i] = check[i] + ((nees[i] - nees[i]) + (nis[i] - nis[i]));
    if (sum_of(wrong) == 0.0) continue;
    for (int lane = 0; lane < runs_; ++lane) {
      RunFailure& end = ended_[at(lane)];
      if (wrong[lane] == 0.0 || end.outcome != Outcome::ok) continue;
      end = {first_run_ + lane, step_ - count_ + k + 1, Outcome::not_positive_definite};
    }
  }
}

bool IntermittentLanes::counts(int lane, Index step) const {
  const RunFailure& end = ended_[at(lane)];
  return end.outcome == Outcome::ok || step < end.step;
}

void IntermittentLanes::add_to(StudyStatistics& statistics) const {
  const bool whole = runs_ == kLanes && std::ranges::all_of(ended_, [](const RunFailure& end) {
                       return end.outcome == Outcome::ok;
                     });
  const Index begin = step_ - count_;
  for (Index k = 0; k < count_; ++k) {
    const Index step = begin + k + 1;
    StepStatistics& s = statistics.steps[at(begin + k)];
    std::array<double, kWidth> kept;
    for (int lane = 0; lane < kLanes; ++lane) kept[at(lane)] = lane < runs_ && counts(lane, step) ? 1.0 : 0.0;
    for (const auto& [quantity, value] : kQuantities) {
      const double* x = values(k, value);
      if (whole) {
        s[quantity].merge(moments_of(x));
      } else {
        for (std::size_t lane = 0; lane < kWidth; ++lane) {
          if (kept[lane] != 0.0) s[quantity].add(x[lane]);
        }
      }
    }
    double seen[kWidth] = {};
    const double* row = seen_.data() + at(begin + k - (drawn_ - block_)) * kWidth;
    for (Index r = 0; r < measurements_; ++r, row += at(block_) * kWidth) {
      for (std::size_t lane = 0; lane < kWidth; ++lane) seen[lane] += row[lane] * kept[lane];
    }
    s.nis_dof += static_cast<std::int64_t>(sum_of(seen));
    s.nees_dof += plan_.states * static_cast<std::int64_t>(sum_of(kept.data()));
  }
  for (const RunFailure& end : ended_) {
    if (end.outcome != Outcome::ok && end.step > begin && end.step <= step_)
      statistics.failures.push_back(end);
  }
}

Vector IntermittentLanes::error(int lane) const {
  Vector e(plan_.states);
  for (Index i = 0; i < e.size(); ++i) e[i] = errors_[at(i) * kWidth + at(lane)];
  return e;
}

Matrix IntermittentLanes::covariance(int lane) const {
  Matrix P(plan_.states, plan_.states);
  const double* row = covariance_.data() + lane;
  for (Index i = 0; i < P.rows(); ++i) {
    for (Index j = 0; j <= i; ++j, row += kWidth) P(i, j) = P(j, i) = *row;
  }
  return P;
}

bool IntermittentLanes::seen(Index row, int lane) const {
  return seen_[at(row * block_ + step_ - 1 - (drawn_ - block_)) * kWidth + at(lane)] != 0.0;
}

}  // namespace credence
