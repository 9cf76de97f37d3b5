#include "analysis/stability/boundedness.h"

#include <fmt/format.h>

#include <stdexcept>

#include "analysis/stability/dense_svd.h"
#include "analysis/stability/marginal_modes.h"
#include "core/enum_words.h"
#include "core/linear_algebra/decompositions.h"

namespace credence::internal {
namespace {

constexpr double kInvertible = 1e-13;

BoundednessReason reason_for(const ExactBoundedness& result) {
  if (result.unobserved == 0) return BoundednessReason::nothing_unobserved;
  return result.pairing.rank == result.unobserved ? BoundednessReason::paired : BoundednessReason::unpaired;
}

}  // namespace

std::string_view to_string(BoundednessReason reason) {
  return word_of(reason, {"paired", "nothing unobserved", "unpaired", "unstable", "undecided"});
}

ExactBoundedness exact_boundedness(MatrixRef F, MatrixRef H, MatrixRef Qt) {
  const MarginalModes modes = marginal_modes(F, H, Qt);
  ExactBoundedness result;
  result.noise = psd_rank(Qt);
  result.observability = modes.observability.decision;
  if (!modes.ok) return result;
  result.unobserved = modes.undetectable.cols();
  result.pairing = modes.pairing;
  result.reason = modes.unstable_undetectable > 0 ? BoundednessReason::unstable : reason_for(result);
  return result;
}

PaperBoundedness paper_boundedness(MatrixRef inflation, Index observability_rank) {
  return {.inflation_rank = psd_rank(inflation).rank, .observability_rank = observability_rank};
}

AccumulatedNoise::AccumulatedNoise(Index state_dim)
    : Phi_(Matrix::Identity(state_dim, state_dim)), S_(Matrix::Zero(state_dim, state_dim)) {}

void AccumulatedNoise::add(MatrixRef F_k, MatrixRef Qt_k) {
  const Index n = S_.rows();
  for (const MatrixRef* M : {&F_k, &Qt_k}) {
    if (M->rows() != n || M->cols() != n) {
      throw std::invalid_argument(
          fmt::format("a matrix of {}x{} does not go with {} states", M->rows(), M->cols(), n));
    }
  }
  Phi_ = (F_k * Phi_).eval();
  const Eigen::PartialPivLU<Matrix> lu(Phi_);
  if (!(lu.rcond() > kInvertible)) {
    ok_ = false;
    return;
  }
  const Matrix half = lu.solve(Qt_k);
  const Matrix back = lu.solve(half.transpose());
  S_ += 0.5 * (back + back.transpose());
}

ExactBoundedness exact_boundedness(const AccumulatedNoise& noise, const ObservabilityAnalysis& observability,
                                   double psd_tolerance) {
  ExactBoundedness result;
  result.noise = psd_rank(noise.S(), psd_tolerance);
  result.observability = observability.decision;
  result.unobserved = observability.unobservable.cols();
  if (!noise.ok()) return result;
  const Matrix untouched = psd_null_space(noise.S(), psd_tolerance);
  result.pairing = pair_subspaces(untouched, observability.unobservable);
  result.reason = reason_for(result);
  return result;
}

MeasuredBoundedness measure_boundedness(const RiccatiProblem& problem, const Matrix& P0) {
  constexpr int kDoublings = 21;
  const RiccatiGrowth growth = riccati_growth(problem, P0, kDoublings);
  MeasuredBoundedness measured;
  measured.bounded = !growth.grows();
  measured.growth_exponent = growth.exponent();
  measured.trace_per_step = growth.trace_per_step();
  measured.steps = growth.steps();
  return measured;
}

}  // namespace credence::internal
