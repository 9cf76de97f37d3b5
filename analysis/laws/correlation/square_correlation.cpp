#include "analysis/laws/correlation/square_correlation.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/decompositions.h"

namespace credence::internal {
namespace {

/// What is known of the correlation about one lag.
struct CorrelationAt {
  double lag = 0.0;
  double weight = 0.0;  ///< lags that it stands for
  Matrix R;             ///< of u_k and u_{k−lag}
  Matrix of_value;      ///< the covariance of what is correlated: of u, or of the mean of a block
  double pairs = 0.0;
};

constexpr double kFewestPairs = 10.0;

/// In the order of their lags; empty where u is singular.
std::vector<CorrelationAt> correlations_of(const TimeCorrelations& of) {
  std::vector<CorrelationAt> all;
  const LagProducts& of_values = of.lags.of_values();
  const auto values = static_cast<double>(of_values.pairs(0));
  const Eigen::LLT<Matrix> factor(of_values.product(0) / std::max(1.0, values));
  if (values == 0.0 || factor.info() != Eigen::Success) return all;
  const auto standardised = [&](const LagProducts& products, Index h) {
    const Matrix mean = products.product(h) / static_cast<double>(products.pairs(h));
    const Matrix half = factor.matrixL().solve(mean);
    return Matrix(factor.matrixL().solve(half.transpose()).transpose());
  };
  double block = 1.0, reached = 0.5;  // lags to here are there
  for (const LagProducts& products : of.lags.levels()) {
    if (products.pairs(0) == 0) break;
    const Matrix of_value = standardised(products, 0);
    // Neighbouring blocks touch: their correlation is that of the shortest lags as well.
    for (Index h = block > 1.0 ? 2 : 1; h <= products.lags(); ++h) {
      const auto pairs = static_cast<double>(products.pairs(h));
      if (pairs < kFewestPairs) break;
      const double lag = block * static_cast<double>(h), end = lag + 0.5 * block;
      all.push_back({lag, end - std::exchange(reached, end), standardised(products, h), of_value, pairs});
    }
    block *= LongLags::kOfBlock;
  }
  return all;
}

/// What the correlation of the last half of the lags says of the variance that stays in whole runs.
struct Standing {
  double share = 0.0;         ///< of all
  double of_component = 0.0;  ///< in the direction where it is largest
  double beyond = 0.0;        ///< Σ 2 (1 − h/n) over the lags that are not looked at, of n steps
};

Standing standing_of(const std::vector<CorrelationAt>& all, const TimeCorrelations& of, double steps) {
  constexpr double kStandardErrors = 3.0, kAlike = 3.0;  // neighbouring lags have about the same error
  constexpr double kLowest = 0.1;
  const double last = all.back().lag;
  Matrix mean = Matrix::Zero(of.lags.dim(), of.lags.dim());
  double weights = 0.0, variance = 0.0;
  const auto m = static_cast<double>(of.lags.dim());
  for (const CorrelationAt& at : all) {
    if (at.lag <= 0.5 * last) continue;
    mean += at.weight * at.R;
    weights += at.weight;
    variance += at.weight * at.weight * at.of_value.squaredNorm() / (m * m * at.pairs);
  }
  mean /= weights;
  const double share = mean.trace() / m;
  if (!(share > kStandardErrors * std::sqrt(kAlike * variance) / weights)) return {};
  const double dof = static_cast<double>(of.runs) * m;
  const double may_be = dof / quantile(boost::math::chi_squared(dof), kLowest);
  const double largest = Eigen::JacobiSVD<Matrix>(mean).singularValues()[0];
  const double left = std::max(0.0, 1.0 - last / steps);
  return {.share = std::min(1.0, may_be * share),
          .of_component = std::min(1.0, may_be * largest),
          .beyond = steps * left * left};
}

/// 1 + 2 Σ of what is added at each lag, of sums and of a component; power: how these go with the share that
/// stays in whole runs.
struct Times {
  double of_sum = 1.0, of_component = 1.0;
  double power = 2.0;
};

SquareCorrelation correlation_of(const TimeCorrelations& of,
                                 const std::function<Times(const std::vector<CorrelationAt>&)>& times_of) {
  constexpr double kFewest = 20.0, kLess = 10.0;
  const auto values = static_cast<double>(of.lags.of_values().pairs(0));
  const double steps = std::max(1.0, of.dof / static_cast<double>(of.runs * of.lags.dim()));
  const std::vector<CorrelationAt> all = correlations_of(of);
  if (all.empty()) return {.of_sum = steps, .of_component = steps, .known = false};
  const Standing standing = standing_of(all, of, steps);
  const Times times = times_of(all);
  const auto cautious = [&](double time, double share) {
    const double worth = values / std::max(1.0, time);
    if (worth < kFewest) return steps;
    return std::min(steps, values / (worth - kLess) + standing.beyond * std::pow(share, times.power));
  };
  return {.of_sum = cautious(times.of_sum, standing.share),
          .of_component = cautious(times.of_component, standing.of_component),
          .known =
              standing.share == 0.0 && values / std::max({1.0, times.of_sum, times.of_component}) >= kFewest};
}

}  // namespace

SquareCorrelation square_correlation(const TimeCorrelations& of) {
  return correlation_of(of, [&of](const std::vector<CorrelationAt>& all) {
    const Index m = of.lags.dim();
    Matrix added = Matrix::Zero(m, m);  // Σ R_h R_hᵀ, without what chance makes of it where R_h is 0
    for (const CorrelationAt& at : all) {
      const Matrix chance = at.of_value.trace() / at.pairs * at.of_value;
      added += at.weight * (at.R * at.R.transpose() - chance);
    }
    // aᵀR_h a is at most |R_hᵀa|, whichever a.
    const Eigen::SelfAdjointEigenSolver<Matrix> along(added, Eigen::EigenvaluesOnly);
    return Times{.of_sum = 1.0 + 2.0 * added.trace() / static_cast<double>(m),
                 .of_component = 1.0 + 2.0 * along.eigenvalues().maxCoeff()};
  });
}

SquareCorrelation score_correlation(const TimeCorrelations& of) {
  return correlation_of(of, [](const std::vector<CorrelationAt>& all) {
    constexpr double kTimes = 5.0;  // errors of r_h add up: to the window of [Sokal 1989]
    double time = 1.0;
    for (const CorrelationAt& at : all) {
      if (at.lag > kTimes * time) break;
      time += 2.0 * at.weight * at.R(0, 0);
    }
    return Times{.of_sum = time, .of_component = time, .power = 1.0};
  });
}

}  // namespace credence::internal
