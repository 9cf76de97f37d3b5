#include "analysis/evidence/battery_statistics.h"

#include <fmt/format.h>

#include "analysis/evidence/consistency_nees.h"
#include "analysis/laws/chi_square.h"
#include "core/linear_algebra/cholesky.h"
#include "core/manifold/angle.h"

namespace credence {
namespace {

constexpr Index kPoseDim = 3;

Vector state_error(const TraceStep& step, Index vehicle_dim) {
  Vector error = step.estimate - step.truth;
  if (vehicle_dim == kPoseDim) error[2] = wrap_angle(error[2]);
  return error;
}

Index piece_dim(const BatteryShape& shape) {
  const bool whole = shape.innovation_dim > 0 && shape.innovation_dim <= InnovationStatistics::kLargestDim;
  return whole ? shape.innovation_dim : shape.landmark_dim;
}

}  // namespace

BlockStatistics::BlockStatistics(const BatteryShape& shape)
    : vehicle_dim_(shape.vehicle_dim),
      landmark_dim_(shape.landmark_dim),
      single_landmarks_(std::min(shape.landmarks, kSingleLandmarks)),
      all_landmarks_(shape.landmarks > 1) {
  if (vehicle_dim_ == kPoseDim) {
    for (const char* name : {"pose", "position", "heading"}) series_.push_back({name, {}, {}});
  } else {
    series_.push_back({"vehicle", {}, {}});
  }
  for (Index i = 0; i < single_landmarks_; ++i)
    series_.push_back({fmt::format("landmark {}", i + 1), {}, {}});
  if (all_landmarks_) series_.push_back({"all landmarks", {}, {}});
  for (BlockSeries& block : series_) {
    block.nees.resize(shape.steps);
    block.dof.resize(shape.steps);
  }
  whole_ = {"the whole state", std::vector<Moments>(shape.steps), std::vector<double>(shape.steps)};
}

void BlockStatistics::add_block(std::size_t block, std::size_t k, VectorRef error, MatrixRef P) {
  const NormalisedError nees = normalised_error(error, P);
  if (!nees.ok || nees.dof == 0) return;
  series_[block].nees[k].add(nees.value);
  series_[block].dof[k] += static_cast<double>(nees.dof);
}

void BlockStatistics::add(std::size_t k, const Vector& error, const TraceStep& step) {
  whole_.nees[k].add(step.nees);
  whole_.dof[k] += static_cast<double>(step.nees_dof);
  const Index n = error.size(), v = vehicle_dim_, d = landmark_dim_;
  std::size_t first_landmark = 1;
  add_block(0, k, error.head(v), step.P.topLeftCorner(v, v));
  if (v == kPoseDim) {
    add_block(1, k, error.head(2), step.P.topLeftCorner(2, 2));
    add_block(2, k, error.segment(2, 1), step.P.block(2, 2, 1, 1));
    first_landmark = 3;
  }
  for (std::size_t i = 0; i < step.landmarks.size(); ++i) {
    if (step.landmarks[i] >= single_landmarks_) continue;
    const Index at = v + d * static_cast<Index>(i);
    const std::size_t block = first_landmark + static_cast<std::size_t>(step.landmarks[i]);
    add_block(block, k, error.segment(at, d), step.P.block(at, at, d, d));
  }
  if (all_landmarks_ && n > v) {
    add_block(series_.size() - 1, k, error.tail(n - v), step.P.bottomRightCorner(n - v, n - v));
  }
}

void BlockSeries::merge(const BlockSeries& other) {
  for (std::size_t k = 0; k < nees.size(); ++k) {
    nees[k].merge(other.nees[k]);
    dof[k] += other.dof[k];
  }
}

void BlockStatistics::merge(const BlockStatistics& other) {
  for (std::size_t b = 0; b < series_.size(); ++b) series_[b].merge(other.series_[b]);
  whole_.merge(other.whole_);
}

CoverageStatistics::CoverageStatistics(std::size_t steps) {
  for (Region& region : regions) {
    region.count.resize(steps);
    region.expected.resize(steps);
  }
}

void CoverageStatistics::add(std::size_t k, double nees, Index dof) {
  const auto [expected, unknown] = expected_of_dof_.try_emplace(dof);
  for (std::size_t i = 0; i < kSigmas.size(); ++i) {
    if (unknown) expected->second[i] = expected_coverage(kSigmas[i], static_cast<double>(dof));
    regions[i].count[k].add(nees <= kSigmas[i] * kSigmas[i]);
    regions[i].expected[k] += expected->second[i];
  }
}

void CoverageStatistics::merge(const CoverageStatistics& other) {
  for (std::size_t i = 0; i < regions.size(); ++i) {
    for (std::size_t k = 0; k < regions[i].count.size(); ++k) {
      regions[i].count[k].merge(other.regions[i].count[k]);
      regions[i].expected[k] += other.regions[i].expected[k];
    }
  }
}

InnovationStatistics::InnovationStatistics(const BatteryShape& shape)
    : products(piece_dim(shape), kLags),
      variances_(shape.measurement_variances),
      first_step_(shape.steps / 5) {}

void InnovationStatistics::begin_run() {
  pieces_.clear();
  piece_sum_ = Vector::Zero(products.dim());
  piece_count_ = 0;
}

void InnovationStatistics::add(std::size_t k, const TraceStep& step) {
  const Index d = products.dim(), m = step.innovation.size();
  const Eigen::LLT<Matrix> factor(step.S);
  const bool usable = m > 0 && step.nis_dof == m && factor.info() == Eigen::Success;
  const std::size_t count = usable ? static_cast<std::size_t>(m / d) : 0;
  while (pieces_.size() < count) pieces_.emplace_back(d, kLags);
  for (std::size_t j = count; j < pieces_.size(); ++j) pieces_[j].add_missing();
  if (step.nis_dof > 0) {
    const double u = chi_square_cdf(step.nis, static_cast<double>(step.nis_dof));
    nis.add(u);
    far_tail.add(u <= kFarTail);
  }
  if (!usable) return;

  if (variances_.size() > 0) {
    const Vector R = variances_.replicate(m / variances_.size(), 1);
    measurement_share.add(factor.solve(Matrix(R.asDiagonal())).trace() / static_cast<double>(m));
  }
  if (k < first_step_) return;
  const Vector u = factor.matrixL().solve(step.innovation);
  for (std::size_t j = 0; j < count; ++j) {
    const auto piece = u.segment(d * static_cast<Index>(j), d);
    pieces_[j].add(piece);
    piece_sum_ += piece;
    ++piece_count_;
  }
}

void InnovationStatistics::end_run() {
  for (const LagProducts& piece : pieces_) products.merge(piece);
  if (piece_count_ > 0) run_mean.add(piece_sum_ / static_cast<double>(piece_count_));
}

void InnovationStatistics::merge(const InnovationStatistics& other) {
  nis.merge(other.nis);
  products.merge(other.products);
  run_mean.merge(other.run_mean);
  far_tail.merge(other.far_tail);
  measurement_share.merge(other.measurement_share);
}

void RunStatistics::begin_run() {
  run_nees_.clear();
  run_dof_ = 0.0;
  run_squared_error_ = {};
}

void RunStatistics::add(const Vector& error, const TraceStep& step, const BatteryShape& shape) {
  const Index v = shape.vehicle_dim, n = error.size();
  nees_values.add(step.nees);
  run_nees_.push_back(step.nees);
  run_dof_ += static_cast<double>(step.nees_dof);
  run_squared_error_[position].add(error.head(std::min<Index>(v, 2)).squaredNorm());
  if (v == kPoseDim) run_squared_error_[heading].add(error[2] * error[2]);
  if (n > v) {
    const Index count = (n - v) / shape.landmark_dim;
    run_squared_error_[landmarks].add(error.tail(n - v).squaredNorm() / static_cast<double>(count));
  }
  vehicle_error_ = error.head(v);
  vehicle_covariance_ = step.P.topLeftCorner(v, v);
}

void RunStatistics::end_run() {
  if (run_nees_.empty()) return;
  double sum = 0.0;
  for (const double value : run_nees_) sum += value;
  nees_sum.add(sum);
  expected_nees_sum += run_dof_;
  nees.push_back(run_nees_);
  for (std::size_t i = 0; i < parts; ++i) {
    if (run_squared_error_[i].count > 0) squared_error[i].add(run_squared_error_[i].mean);
  }
  last_vehicle_error.push_back(vehicle_error_);
  last_vehicle_covariance.push_back(vehicle_covariance_);
}

void RunStatistics::merge(const RunStatistics& other) {
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  nees_values.merge(other.nees_values);
  nees_sum.merge(other.nees_sum);
  expected_nees_sum += other.expected_nees_sum;
  append(nees, other.nees);
  for (std::size_t i = 0; i < parts; ++i) squared_error[i].merge(other.squared_error[i]);
  append(last_vehicle_error, other.last_vehicle_error);
  append(last_vehicle_covariance, other.last_vehicle_covariance);
}

BatteryStatistics::BatteryStatistics(const BatteryShape& battery_shape)
    : shape(battery_shape), blocks(shape), coverage(shape.steps), innovations(shape) {}

void BatteryStatistics::begin_run() {
  step_ = 0;
  ++runs;
  innovations.begin_run();
  whole_runs.begin_run();
}

void BatteryStatistics::add(const TraceStep& step) {
  if (step_++ == 0) return;
  const std::size_t k = step_ - 2;
  innovations.add(k, step);
  if (step.nees_dof == 0) return;
  const Vector error = state_error(step, shape.vehicle_dim);
  blocks.add(k, error, step);
  coverage.add(k, step.nees, step.nees_dof);
  whole_runs.add(error, step, shape);
}

void BatteryStatistics::end_run(Outcome outcome) {
  innovations.end_run();
  if (outcome == Outcome::ok) whole_runs.end_run();
}

void BatteryStatistics::merge(const BatteryStatistics& other) {
  runs += other.runs;
  blocks.merge(other.blocks);
  coverage.merge(other.coverage);
  innovations.merge(other.innovations);
  whole_runs.merge(other.whole_runs);
}

}  // namespace credence
