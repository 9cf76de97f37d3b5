#include "montecarlo/worlds/posterior_bound.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/mirror.h"
#include "core/nan.h"
#include "montecarlo/scenario/noise_switches.h"

namespace credence::internal {
namespace {

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

void move(const PosteriorRecursion::Truth& by, Matrix& P) {
  const Matrix FP = by.F * P;
  P.noalias() = FP * by.F.transpose();
  P += by.Q;
  symmetrise(P);
}

}  // namespace

std::string no_bound_reason(const Scenario& scenario) {
  if (!noise_source(scenario).is_plain()) return "the bound is that of white Gaussian noise";
  if (measurement_delay(scenario) > 0) return "the bound is that of measurements that arrive in time";
  return {};
}

BoundRecorder::BoundRecorder(const RunLayout& layout, std::int64_t runs) {
  result_.runs = runs;
  for (const Block& block : layout.blocks) {
    if (block.part == Part::pose || block.part == Part::landmark) continue;
    const auto size = static_cast<double>(block.states.size());
    const double shares = block.part == Part::map ? size / static_cast<double>(layout.landmark_dim) : 1.0;
    places_.push_back({block.states, shares});
    result_.blocks.push_back({.block = block.name, .bound = {}, .at_truth = {}});
  }
}

void BoundRecorder::add(const VectorRef& bound, const VectorRef& at_truth) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto& [states, shares] = places_[i];
    const double claimed = at_truth(states).sum() / shares;
    result_.blocks[i].bound.push_back(std::isnan(claimed) ? claimed : bound(states).sum() / shares);
    result_.blocks[i].at_truth.push_back(claimed);
  }
}

void learn(const Matrix& information, Matrix& P) {
  if (information.isZero(0.0)) return;
  const Index n = P.rows();
  const Matrix A = Matrix::Identity(n, n) + P * information;
  P = Eigen::PartialPivLU<Matrix>(A).solve(P).eval();
  symmetrise(P);
}

PosteriorRecursion::PosteriorRecursion(std::vector<Matrix> P0, Motion motion)
    : bounds_(motion == Motion::of_input ? P0 : std::vector<Matrix>{P0.front()}), at_truth_(std::move(P0)) {}

/// The bound of all truths together, by F̄ and what the spread of F tells.
bool PosteriorRecursion::move_mean(const std::vector<Truth>& truths) {
  Truth mean = truths.front();
  const auto count = static_cast<double>(truths.size());
  mean.F.setZero();
  for (const Truth& truth : truths) mean.F += truth.F / count;
  Matrix& P = bounds_.front();
  Matrix spread = Matrix::Zero(P.rows(), P.cols());
  bool differ = false;
  for (const Truth& truth : truths) differ = differ || !truth.F.isApprox(truths.front().F, 1e-12);
  if (differ) {
    const Eigen::LLT<Matrix> root(mean.Q);
    if (root.info() != Eigen::Success) return false;
    for (const Truth& truth : truths) {
      const Matrix off = truth.F - mean.F;
      const Matrix weighted = root.matrixL().solve(off);
      spread += weighted.transpose() * weighted / count;
    }
  }
  learn(spread, P);
  move(mean, P);
  return true;
}

bool PosteriorRecursion::step(const std::vector<Truth>& truths) {
  Matrix information = Matrix::Zero(at_truth_.front().rows(), at_truth_.front().cols());
  for (const Truth& truth : truths) information += truth.information / static_cast<double>(truths.size());
  for (std::size_t i = 0; i < truths.size(); ++i) {
    move(truths[i], at_truth_[i]);
    learn(truths[i].information, at_truth_[i]);
  }
  if (bounds_.size() > 1) {
    for (std::size_t i = 0; i < truths.size(); ++i) move(truths[i], bounds_[i]);
  } else if (!move_mean(truths)) {
    return false;
  }
  for (Matrix& P : bounds_) learn(information, P);
  return true;
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

double BoundCurve::mean_bound() const { return mean_of(bound); }
double BoundCurve::mean_at_truth() const { return mean_of(at_truth); }

const BoundCurve* PosteriorBound::find(std::string_view block) const {
  const auto found = std::ranges::find(blocks, block, &BoundCurve::block);
  return found == blocks.end() ? nullptr : &*found;
}

double PosteriorBound::mean_bound(std::string_view block) const {
  const BoundCurve* curve = find(block);
  return curve == nullptr ? kNaN : curve->mean_bound();
}

}  // namespace credence
