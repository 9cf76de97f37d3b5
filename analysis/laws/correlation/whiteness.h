#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/types.h"

/// @file
/// Whiteness of the normalised innovation u_k = L⁻¹ ν_k, S_k = L Lᵀ (theory, section 7).
///
/// For a consistent filter the u_k are independent N(0, I). The test looks at the products u_k u_{k−h}ᵀ,
/// summed over steps and runs, after standardising them by the measured covariance of u: so it sees
/// correlation in time and not a wrong scale, which is the business of the NIS verdict. The mean is known to
/// be zero and is not subtracted: a biased innovation is not white either (zero_mean.h names
/// that cause).

namespace credence::internal {

/// The values of one run at successive steps, some of which may be missing.
class LagSeries {
 public:
  /// Throws std::invalid_argument unless dim ≥ 1.
  explicit LagSeries(Index dim);

  /// The next run: no steps.
  void clear();
  /// The value of the next step; throws std::invalid_argument for another dimension. One that is not finite
  /// is missing, and counted as such.
  void add(VectorRef u);
  /// A step without a value.
  void add_missing();

  Index dim() const { return dim_; }
  Index steps() const { return steps_; }
  std::int64_t invalid() const { return invalid_; }
  /// Component j at step k, 0 where it is missing; j = dim(): 1 where there is a value, else 0.
  double at(Index j, Index k) const { return backwards(j)[steps_ - 1 - k]; }

 private:
  friend class LagProducts;
  static constexpr Index kBefore = 24;  ///< zeros, of steps before the first

  /// Of a component, or of whether there is a value, that of the last step, the one before it, and so on to
  /// the first and to kBefore zeros.
  const double* backwards(Index j) const { return data_.data() + j * row() + room_ - steps_; }
  /// Where those of the next step go, row() numbers apart.
  double* next();
  Index row() const { return room_ + kBefore; }

  Index dim_, steps_ = 0, room_ = 64;  ///< room: for so many steps
  std::int64_t invalid_ = 0;
  std::vector<double> data_{};
};

/// Σ u_k u_{k−h}ᵀ for the lags h = 0 … H over any number of runs: additive, so chunks merge by summing.
class LagProducts {
 public:
  static constexpr Index kMostLags = LagSeries::kBefore - 1;

  /// Throws std::invalid_argument unless dim ≥ 1 and 1 ≤ lags ≤ kMostLags.
  LagProducts(Index dim, Index lags);
  /// From stored sums, index h = 0 … H; throws for sizes that do not agree or a negative number of pairs.
  LagProducts(const std::vector<Matrix>& products, std::vector<std::int64_t> pairs, std::int64_t invalid);

  /// The products within a run; throws std::invalid_argument for another dimension.
  void add_run(const LagSeries& run);
  /// Adds the sums of `other`; throws std::invalid_argument for another dimension or number of lags.
  void merge(const LagProducts& other);

  /// The sums of the products about this mean, which all values have.
  LagProducts about(const Vector& mean) const { return plus(-mean * mean.transpose()); }
  /// Each product larger by this.
  LagProducts plus(const Matrix& of_each) const;

  Index dim() const { return dim_; }
  Index lags() const { return std::ssize(pairs_) - 1; }
  Matrix product(Index lag) const;
  std::int64_t pairs(Index lag) const { return pairs_[static_cast<std::size_t>(lag)]; }
  std::int64_t invalid() const { return invalid_; }

 private:
  Index dim_;
  std::vector<double> sums_;         // m×m rows of H + 1 lags: row i·m + j is Σ u_i u_j(k − h)
  std::vector<std::int64_t> pairs_;  // products summed at lag h
  std::int64_t invalid_ = 0;
};

/// The autocorrelation of the innovation and its portmanteau test.
struct WhitenessTest {
  std::int64_t values = 0;
  Index dim = 0;
  std::vector<double> autocorrelation;  ///< lags 1 … H, averaged over the components
  std::vector<double> band;             ///< half-width of the pointwise band around 0 at `confidence`
  double statistic = 0.0;               ///< ~ χ²(dof) when white
  double dof = 0.0;                     ///< m² for each lag that is tested
  double p_value = 0.0;
  bool white = false;            ///< p_value > 1 − confidence
  std::string_view reason = {};  ///< why there is no test (p_value NaN), else empty
};

/// The multivariate portmanteau test of [Hosking 1980], which for one component and one run is
/// [Ljung 1978], over many runs:
///
///   Q = Σ_h m² ‖C_0^{-1/2} C_h C_0^{-1/2}‖_F² / E_h ~ χ²(H m²),
///   E_h = c_h / (N (N + 2)) [m + m (m − 1) (N + 1) / (N − 1)],
///
/// with c_h products at lag h and N values. E_h is the exact mean of the norm for Gaussian white u (the
/// whitened values are uniform on the Stiefel manifold). No dof is subtracted, as no model was fitted to the
/// innovations. The sum is over lags up to 0.6 √N, as the squares of many lags of few values depend on each
/// other: at 5 % it rejects 1.8 to 5.3 % of 16,000 single runs of 16 to 400 values (m = 1, 2, 4), over all 20
/// lags 5.0 to 10.8 %. Lags without products are left out, with their dof.
WhitenessTest test_whiteness(const LagProducts& products, double confidence);

/// C_0^{-1/2} C_h C_0^{-1/2} of the sums C_h of u_k u_{k−h}ᵀ at the lags h = 1, 2, … that have products; none
/// where C_0 is singular.
std::vector<Matrix> standardised_products(const LagProducts& products);

}  // namespace credence::internal
