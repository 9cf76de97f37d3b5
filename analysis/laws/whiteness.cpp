#include "analysis/laws/whiteness.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "analysis/laws/chi_square.h"
#include "analysis/laws/require.h"
#include "core/linear_algebra/cholesky.h"
#include "core/nan.h"

namespace credence {
namespace {

// E‖C_0^{-1/2} C_h C_0^{-1/2}‖_F² for white Gaussian values.
double expected_norm(double pairs, double values, double dim) {
  const double one_component = pairs / (values * (values + 2.0));
  return one_component * (dim + dim * (dim - 1.0) * (values + 1.0) / (values - 1.0));
}

// L⁻¹ C L⁻ᵀ
Matrix standardise(const Matrix& product, const Eigen::LLT<Matrix>& factor) {
  const Matrix half = factor.matrixL().solve(product);
  return factor.matrixL().solve(half.transpose()).transpose();
}

std::string_view reason_not_to_test(const LagProducts& products) {
  if (products.invalid() > 0) return "an innovation is not finite";
  if (products.pairs(0) <= products.dim()) return "not more values than components";
  if (products.pairs(1) == 0) return "no two successive values";
  return {};
}

}  // namespace

LagProducts::LagProducts(Index dim, Index lags) : dim_(dim) {
  if (dim < 1 || lags < 1) {
    throw std::invalid_argument(fmt::format("dim = {} and lags = {} must be >= 1", dim, lags));
  }
  products_.assign(static_cast<std::size_t>(lags) + 1, Matrix::Zero(dim, dim));
  pairs_.assign(static_cast<std::size_t>(lags) + 1, 0);
  recent_ = Matrix::Zero(dim, lags);
  present_.assign(static_cast<std::size_t>(lags), false);
}

LagProducts::LagProducts(std::vector<Matrix> products, std::vector<std::int64_t> pairs, std::int64_t invalid)
    : dim_(products.empty() ? 0 : products[0].rows()),
      products_(std::move(products)),
      pairs_(std::move(pairs)),
      invalid_(invalid) {
  const bool square = std::all_of(products_.begin(), products_.end(), [this](const Matrix& product) {
    return product.rows() == dim_ && product.cols() == dim_;
  });
  const bool counted =
      std::all_of(pairs_.begin(), pairs_.end(), [](std::int64_t count) { return count >= 0; });
  if (dim_ < 1 || products_.size() < 2 || pairs_.size() != products_.size() || !square || !counted ||
      invalid < 0) {
    throw std::invalid_argument(
        fmt::format("{} lag products and {} counts do not fit together", products_.size(), pairs_.size()));
  }
  recent_ = Matrix::Zero(dim_, lags());
  present_.assign(static_cast<std::size_t>(lags()), false);
}

void LagProducts::begin_run() {
  time_ = 0;
  present_.assign(present_.size(), false);
}

void LagProducts::add(VectorRef u) {
  if (u.size() != dim_) {
    throw std::invalid_argument(fmt::format("innovation of dimension {}, expected {}", u.size(), dim_));
  }
  if (!u.allFinite()) {
    ++invalid_;
    add_missing();
    return;
  }
  products_[0].noalias() += u * u.transpose();
  ++pairs_[0];
  for (Index lag = 1; lag <= std::min(lags(), time_); ++lag) {
    const Index earlier = (time_ - lag) % lags();
    if (!present_[static_cast<std::size_t>(earlier)]) continue;
    products_[static_cast<std::size_t>(lag)].noalias() += u * recent_.col(earlier).transpose();
    ++pairs_[static_cast<std::size_t>(lag)];
  }
  const Index now = time_++ % lags();
  recent_.col(now) = u;
  present_[static_cast<std::size_t>(now)] = true;
}

void LagProducts::add_missing() { present_[static_cast<std::size_t>(time_++ % lags())] = false; }

void LagProducts::merge(const LagProducts& other) {
  if (other.dim_ != dim_ || other.lags() != lags()) {
    throw std::invalid_argument(fmt::format("lag products of dim {} with {} lags and dim {} with {} lags",
                                            dim_, lags(), other.dim_, other.lags()));
  }
  for (std::size_t h = 0; h < products_.size(); ++h) {
    products_[h] += other.products_[h];
    pairs_[h] += other.pairs_[h];
  }
  invalid_ += other.invalid_;
}

WhitenessTest test_whiteness(const LagProducts& products, double confidence) {
  require_confidence(confidence);
  WhitenessTest result;
  result.values = products.pairs(0);
  result.dim = products.dim();
  result.statistic = result.p_value = result.share_outside = kNaN;
  result.reason = reason_not_to_test(products);
  if (!result.reason.empty()) return result;
  const Eigen::LLT<Matrix> factor(products.product(0));
  if (factor.info() != Eigen::Success) {
    result.reason = "the covariance of the innovations is singular";
    return result;
  }

  const double z = quantile(complement(boost::math::normal(), 0.5 * (1.0 - confidence)));
  const double values = static_cast<double>(products.pairs(0));
  const double dim = static_cast<double>(products.dim());
  double statistic = 0.0;
  Index outside = 0;
  for (Index h = 1; h <= products.lags() && products.pairs(h) > 0; ++h) {
    const double pairs = static_cast<double>(products.pairs(h));
    const Matrix correlation = standardise(products.product(h), factor);
    statistic += dim * dim * correlation.squaredNorm() / expected_norm(pairs, values, dim);
    result.dof += dim * dim;
    const double per_pair = values / pairs;
    result.autocorrelation.push_back(per_pair * correlation.trace() / dim);
    result.band.push_back(z * per_pair * std::sqrt(pairs / (dim * values * (values + 2.0))));
    outside += std::abs(result.autocorrelation.back()) > result.band.back() ? 1 : 0;
  }
  result.share_outside = static_cast<double>(outside) / static_cast<double>(result.band.size());
  result.statistic = statistic;
  result.p_value = chi_square_survival(statistic, result.dof);
  result.white = result.p_value > 1.0 - confidence;
  return result;
}

}  // namespace credence
