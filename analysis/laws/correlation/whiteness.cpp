#include "analysis/laws/correlation/whiteness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/normal_quantile.h"
#include "analysis/laws/require.h"
#include "core/linear_algebra/cholesky.h"
#include "core/nan.h"
#include "core/simd/cpu_dispatch.h"

namespace credence::internal {
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

constexpr Index kSums = LagProducts::kMostLags + 1;

/// sums[h] += Σ_k x_k y_{k−h} of two series that begin with their last step, in the order of the steps.
[[gnu::always_inline]] inline void add_products(const double* x, const double* y, Index steps,
                                                std::array<double, kSums>& sums) {
  std::array<double, kSums> all = sums;
  for (Index k = steps - 1; k >= 0; --k) {
    const double factor = x[k];
    if (factor == 0.0) continue;
    for (Index h = 0; h < kSums; ++h) all[static_cast<std::size_t>(h)] += factor * y[k + h];
  }
  sums = all;
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void add_products_avx2(const double* x, const double* y, Index steps,
                                               std::array<double, kSums>& sums) {
  add_products(x, y, steps, sums);
}
#endif

/// The same of lags 0 to H, one sum of each.
template <class Sum>
void add_lags(const double* x, const double* y, Index steps, std::span<Sum> sums) {
  std::array<double, kSums> all{};
  std::ranges::transform(sums, all.begin(), [](Sum sum) { return static_cast<double>(sum); });
#if defined(__x86_64__)
  static const bool wide = best_instruction_set() != InstructionSet::scalar;
  wide ? add_products_avx2(x, y, steps, all) : add_products(x, y, steps, all);
#else
  add_products(x, y, steps, all);
#endif
  std::transform(all.begin(), all.begin() + std::ssize(sums), sums.begin(),
                 [](double sum) { return static_cast<Sum>(sum); });
}

std::string_view reason_not_to_test(const LagProducts& products) {
  if (products.invalid() > 0) return "an innovation is not finite";
  if (products.pairs(0) <= products.dim()) return "not more values than components";
  if (products.pairs(1) == 0) return "no two successive values";
  return {};
}

}  // namespace

LagSeries::LagSeries(Index dim) : dim_(dim) {
  if (dim < 1) throw std::invalid_argument(fmt::format("dim = {} must be >= 1", dim));
  data_.resize(static_cast<std::size_t>((dim_ + 1) * row()));
}

void LagSeries::clear() {
  steps_ = 0;
  invalid_ = 0;
}

double* LagSeries::next() {
  if (steps_ == room_) {
    const Index rows = dim_ + 1, wide = 2 * room_ + kBefore;
    std::vector<double> wider(static_cast<std::size_t>(rows * wide), 0.0);
    for (Index j = 0; j < rows; ++j)
      std::copy_n(backwards(j), steps_, wider.data() + j * wide + 2 * room_ - steps_);
    data_ = std::move(wider);
    room_ *= 2;
  }
  return data_.data() + room_ - ++steps_;
}

void LagSeries::add(VectorRef u) {
  if (u.size() != dim_) {
    throw std::invalid_argument(fmt::format("innovation of dimension {}, expected {}", u.size(), dim_));
  }
  if (!u.allFinite()) {
    ++invalid_;
    return add_missing();
  }
  double* to = next();
  for (Index j = 0; j < dim_; ++j, to += row()) *to = u[j];
  *to = 1.0;
}

void LagSeries::add_missing() {
  double* to = next();
  for (Index j = 0; j <= dim_; ++j, to += row()) *to = 0.0;
}

LagProducts::LagProducts(Index dim, Index lags) : dim_(dim) {
  if (dim < 1 || lags < 1 || lags > kMostLags) {
    throw std::invalid_argument(
        fmt::format("dim = {} must be >= 1 and lags = {} from 1 to {}", dim, lags, kMostLags));
  }
  pairs_.assign(static_cast<std::size_t>(lags) + 1, 0);
  sums_.assign(static_cast<std::size_t>(dim * dim * (lags + 1)), 0.0);
}

LagProducts::LagProducts(const std::vector<Matrix>& products, std::vector<std::int64_t> pairs,
                         std::int64_t invalid)
    : dim_(products.empty() ? 0 : products[0].rows()), pairs_(std::move(pairs)), invalid_(invalid) {
  const bool square = std::ranges::all_of(
      products, [this](const Matrix& product) { return product.rows() == dim_ && product.cols() == dim_; });
  const bool counted = std::ranges::all_of(pairs_, [](std::int64_t count) { return count >= 0; });
  if (dim_ < 1 || products.size() < 2 || std::ssize(products) > kSums || pairs_.size() != products.size() ||
      !square || !counted || invalid < 0) {
    throw std::invalid_argument(
        fmt::format("{} lag products and {} counts do not fit together", products.size(), pairs_.size()));
  }
  for (Index row = 0; row < dim_ * dim_; ++row) {
    for (const Matrix& product : products) sums_.push_back(product(row / dim_, row % dim_));
  }
}

Matrix LagProducts::product(Index lag) const {
  Matrix product(dim_, dim_);
  for (Index row = 0; row < dim_ * dim_; ++row) {
    product(row / dim_, row % dim_) = sums_[static_cast<std::size_t>(row * (lags() + 1) + lag)];
  }
  return product;
}

void LagProducts::add_run(const LagSeries& run) {
  if (run.dim() != dim_) {
    throw std::invalid_argument(fmt::format("a run of dimension {}, expected {}", run.dim(), dim_));
  }
  const std::size_t count = pairs_.size();
  double* sums = sums_.data();
  for (Index i = 0; i < dim_; ++i) {
    for (Index j = 0; j < dim_; ++j, sums += count)
      add_lags(run.backwards(i), run.backwards(j), run.steps(), std::span(sums, count));
  }
  add_lags(run.backwards(dim_), run.backwards(dim_), run.steps(), std::span(pairs_));
  invalid_ += run.invalid();
}

void LagProducts::merge(const LagProducts& other) {
  if (other.dim_ != dim_ || other.lags() != lags()) {
    throw std::invalid_argument(fmt::format("lag products of dim {} with {} lags and dim {} with {} lags",
                                            dim_, lags(), other.dim_, other.lags()));
  }
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += other.sums_[i];
  for (std::size_t h = 0; h < pairs_.size(); ++h) pairs_[h] += other.pairs_[h];
  invalid_ += other.invalid_;
}

LagProducts LagProducts::plus(const Matrix& of_each) const {
  std::vector<Matrix> products;
  for (Index h = 0; h <= lags(); ++h)
    products.emplace_back(product(h) + static_cast<double>(pairs(h)) * of_each);
  return {products, pairs_, invalid_};
}

std::vector<Matrix> standardised_products(const LagProducts& products) {
  std::vector<Matrix> standardised;
  const Eigen::LLT<Matrix> factor(products.product(0));
  if (factor.info() != Eigen::Success) return standardised;
  for (Index h = 1; h <= products.lags() && products.pairs(h) > 0; ++h)
    standardised.push_back(standardise(products.product(h), factor));
  return standardised;
}

WhitenessTest test_whiteness(const LagProducts& products, double confidence) {
  require_confidence(confidence);
  WhitenessTest result;
  result.values = products.pairs(0);
  result.dim = products.dim();
  result.statistic = result.p_value = kNaN;
  result.reason = reason_not_to_test(products);
  if (!result.reason.empty()) return result;
  const std::vector<Matrix> standardised = standardised_products(products);
  if (standardised.empty()) {
    result.reason = "the covariance of the innovations is singular";
    return result;
  }

  const double z = normal_quantile_two_sided(confidence);
  const double values = static_cast<double>(products.pairs(0));
  const double dim = static_cast<double>(products.dim());
  double statistic = 0.0;
  // The squares of many lags of few values depend on each other.
  constexpr double kOfRoot = 0.6;
  const Index most = std::max<Index>(1, static_cast<Index>(kOfRoot * std::sqrt(values)));
  for (Index h = 1; const Matrix& correlation : standardised) {
    const double pairs = static_cast<double>(products.pairs(h));
    if (h++ <= most) {
      statistic += dim * dim * correlation.squaredNorm() / expected_norm(pairs, values, dim);
      result.dof += dim * dim;
    }
    const double per_pair = values / pairs;
    result.autocorrelation.push_back(per_pair * correlation.trace() / dim);
    result.band.push_back(z * per_pair * std::sqrt(pairs / (dim * values * (values + 2.0))));
  }
  result.statistic = statistic;
  result.p_value = chi_square_survival(statistic, result.dof);
  result.white = result.p_value > 1.0 - confidence;
  return result;
}

}  // namespace credence::internal
