#pragma once

#include <nlopt.hpp>
#include <span>
#include <vector>

#include "analysis/tuning/linear_score.h"
#include "core/linear_algebra/decompositions.h"

/// @file
/// What others tune by, for comparison: autocovariance least squares, and a cost on NIS.

namespace credence::internal::testing {

/// Σ_i A^i W (A^i)ᵀ for a spectral radius below 1, by doubling.
inline Matrix stationary(Matrix A, Matrix W) {
  for (int i = 0; i < 60 && A.norm() > 1e-300; ++i) {
    W += (A * W * A.transpose()).eval();
    A = (A * A).eval();
  }
  return W;
}

/// A filter whose gain has settled, whose innovations have an autocovariance that is linear in the true Q and
/// R [Odelson 2006]:
///
///   P = A P Aᵀ + G Q Gᵀ + F K R Kᵀ Fᵀ,  A = F (I − K H),
///   C_0 = H P Hᵀ + R,  C_j = H A^j P Hᵀ − H A^{j−1} F K R.
class AutocovarianceLeastSquares {
 public:
  /// `basis`: the covariances as a sum of these, the unknowns being the coefficients; of P0 nothing is said.
  AutocovarianceLeastSquares(const LinearModel& filter, std::span<const NoiseDerivative> basis, Index lags)
      : H_(filter.H), F_(filter.F), lags_(lags) {
    const Index n = filter.state_dim(), m = filter.measurement_dim();
    const InnovationSensitivities steps(filter, {}, 10000);
    const InnovationStep& last = steps.step(9999);
    FK_ = last.FK;
    closed_ = last.closed;
    design_.resize(m * m * lags, std::ssize(basis));
    for (std::size_t i = 0; i < basis.size(); ++i) {
      const Matrix R = basis[i].R.size() > 0 ? basis[i].R : Matrix::Zero(m, m);
      Matrix W = FK_ * R * FK_.transpose();
      if (basis[i].Q.size() > 0) W += filter.G * basis[i].Q * filter.G.transpose();
      const Matrix P = stationary(closed_, W);
      Matrix C = H_ * P * H_.transpose() + R, power = Matrix::Identity(n, n);
      for (Index j = 0; j < lags; ++j) {
        if (j > 0) {
          C = H_ * power * (closed_ * P * H_.transpose() - FK_ * R);
          power = (power * closed_).eval();
        }
        design_.block(m * m * j, static_cast<Index>(i), m * m, 1) = Vector::Map(C.data(), m * m);
      }
    }
  }

  const Matrix& design() const { return design_; }

  /// The coefficients from a record, of which `settling` steps are left out.
  Vector estimate(const MeasuredRun& run, Index settling) const {
    const Index m = H_.rows(), steps = run.z.cols();
    Matrix nu(m, steps);
    Vector x = F_ * run.start;
    for (Index k = 0; k < steps; ++k) {
      nu.col(k) = run.z.col(k) - H_ * x;
      x = (F_ * x + FK_ * nu.col(k)).eval();
    }
    Vector measured(design_.rows());
    for (Index j = 0; j < lags_; ++j) {
      const Index count = steps - settling - j;
      const Matrix C = nu.middleCols(settling + j, count) * nu.middleCols(settling, count).transpose() /
                       static_cast<double>(count);
      measured.segment(m * m * j, m * m) = Vector::Map(C.data(), m * m);
    }
    return Eigen::ColPivHouseholderQR<Matrix>(design_).solve(measured);
  }

 private:
  Matrix H_, F_, FK_, closed_, design_;
  Index lags_;
};

/// Tunes by the cost (mean NIS / dof − 1)² [Chen 2018], with NLopt's BOBYQA from `start`.
inline Vector tune_by_nis(const ScoreModel& model, Vector start) {
  nlopt::opt search(nlopt::LN_BOBYQA, static_cast<unsigned>(start.size()));
  const auto cost = [](const std::vector<double>& phi, std::vector<double>&, void* data) {
    const auto& scored = *static_cast<const ScoreModel*>(data);
    const UnitScores s = scored.scores(Vector::Map(phi.data(), std::ssize(phi)), false);
    const double excess = s.mean_nis() * s.steps / s.dof - 1.0;
    return excess * excess;
  };
  search.set_min_objective(cost, const_cast<ScoreModel*>(&model));
  search.set_xtol_abs(1e-7);
  search.set_stopval(1e-12);
  search.set_maxeval(500);
  search.set_lower_bounds(-3.0);
  search.set_upper_bounds(3.0);
  std::vector<double> phi(start.begin(), start.end());
  double value = 0.0;
  search.optimize(phi, value);
  return Vector::Map(phi.data(), std::ssize(phi));
}

}  // namespace credence::internal::testing
