#include "analysis/laws/correlation/whiteness.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "analysis/laws/chi_square/chi_square.h"
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

/// What the sums of `count` lags are made of.
struct Lags {
  const double* recent;         ///< of each component, `row` numbers apart
  const std::int64_t* present;  ///< one for each lag
  Index dim, row, count;
  double* sums;
  std::int64_t* pairs;
};

/// sums += u_i u_j(k − h), pairs += present.
template <Index kCount>
[[gnu::always_inline]] inline void add_products(const Lags& lags, const double* u) {
  const Index count = kCount > 0 ? kCount : lags.count;
  double* __restrict sums = lags.sums;
  for (Index i = 0; i < lags.dim; ++i) {
    const double factor = u[i];
    const double* recent = lags.recent;
    for (Index j = 0; j < lags.dim; ++j, sums += count, recent += lags.row) {
      for (Index h = 0; h < count; ++h) sums[h] += factor * recent[h];
    }
  }
  const std::int64_t* present = lags.present;
  std::int64_t* __restrict pairs = lags.pairs;
  for (Index h = 0; h < count; ++h) pairs[h] += present[h];
}

constexpr Index kMostUsed = 21;  // lags 0 to 20

#if defined(__x86_64__)
[[gnu::target("avx2")]] void add_products_avx2(const Lags& lags, const double* u) {
  add_products<kMostUsed>(lags, u);
}
#endif

void add_products(const Lags& lags, const double* u) {
  if (lags.count != kMostUsed) return add_products<0>(lags, u);
#if defined(__x86_64__)
  static const bool wide = best_instruction_set() != InstructionSet::scalar;
  if (wide) return add_products_avx2(lags, u);
#endif
  add_products<kMostUsed>(lags, u);
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
  pairs_.assign(static_cast<std::size_t>(lags) + 1, 0);
  sums_.assign(static_cast<std::size_t>(dim * dim * (lags + 1)), 0.0);
  begin_run();
}

LagProducts::LagProducts(const std::vector<Matrix>& products, std::vector<std::int64_t> pairs,
                         std::int64_t invalid)
    : dim_(products.empty() ? 0 : products[0].rows()), pairs_(std::move(pairs)), invalid_(invalid) {
  const bool square = std::ranges::all_of(
      products, [this](const Matrix& product) { return product.rows() == dim_ && product.cols() == dim_; });
  const bool counted = std::ranges::all_of(pairs_, [](std::int64_t count) { return count >= 0; });
  if (dim_ < 1 || products.size() < 2 || pairs_.size() != products.size() || !square || !counted ||
      invalid < 0) {
    throw std::invalid_argument(
        fmt::format("{} lag products and {} counts do not fit together", products.size(), pairs_.size()));
  }
  for (Index row = 0; row < dim_ * dim_; ++row) {
    for (const Matrix& product : products) sums_.push_back(product(row / dim_, row % dim_));
  }
  begin_run();
}

Matrix LagProducts::product(Index lag) const {
  Matrix product(dim_, dim_);
  for (Index row = 0; row < dim_ * dim_; ++row) {
    product(row / dim_, row % dim_) = sums_[static_cast<std::size_t>(row * (lags() + 1) + lag)];
  }
  return product;
}

void LagProducts::begin_run() {
  begin_ = kSteps;
  recent_.assign(static_cast<std::size_t>(dim_ * row()), 0.0);
  present_.assign(static_cast<std::size_t>(row()), 0);
}

/// The next value is one step later.
void LagProducts::advance() {
  if (--begin_ >= 0) return;
  begin_ = kSteps;
  const auto move_up = [this](auto* first) {
    std::copy_backward(first, first + lags(), first + row());
    std::fill(first, first + kSteps + 1, 0);
  };
  for (Index j = 0; j < dim_; ++j) move_up(recent_.data() + j * row());
  move_up(present_.data());
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
  for (Index j = 0; j < dim_; ++j) recent_[static_cast<std::size_t>(j * row() + begin_)] = u[j];
  present_[static_cast<std::size_t>(begin_)] = 1;
  add_products({.recent = recent_.data() + begin_,
                .present = present_.data() + begin_,
                .dim = dim_,
                .row = row(),
                .count = lags() + 1,
                .sums = sums_.data(),
                .pairs = pairs_.data()},
               u.data());
  advance();
}

void LagProducts::add_missing() { advance(); }

void LagProducts::merge(const LagProducts& other) {
  if (other.dim_ != dim_ || other.lags() != lags()) {
    throw std::invalid_argument(fmt::format("lag products of dim {} with {} lags and dim {} with {} lags",
                                            dim_, lags(), other.dim_, other.lags()));
  }
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += other.sums_[i];
  for (std::size_t h = 0; h < pairs_.size(); ++h) pairs_[h] += other.pairs_[h];
  invalid_ += other.invalid_;
}

LagProducts LagProducts::about(const Vector& mean) const {
  std::vector<Matrix> products;
  for (Index h = 0; h <= lags(); ++h)
    products.emplace_back(product(h) - static_cast<double>(pairs(h)) * mean * mean.transpose());
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

  const double z = quantile(complement(boost::math::normal(), 0.5 * (1.0 - confidence)));
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
