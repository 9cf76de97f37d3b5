#pragma once

#include <array>
#include <cstdint>

/// @file
/// Evidence against E X = 1 along the runs, proved for every dependence in time, every number of runs, and at
/// every look: betting on the averages X_i of the runs (run_mean.h).
///
/// A capital of 1 is bet run by run, a fixed share λ of it each time, and the two directions bet on
///
///   W⁺ = mean over λ of Π_i (1 + λ (X_i − 1)),
///   W⁻ = mean over (λ, b) of Π_i (1 − λ + λ (b − X_i)⁺ / π_b),  π_b = b − 1 + δ_b,  δ_b = E(χ²_n/n − b)⁺.
///
/// Each factor is non-negative with mean at most 1 under consistency: for W⁺ because X ≥ 0 and E X = 1, no
/// Gaussian law is needed; for W⁻ because X is an average of variables χ²_n/n, hence below χ²_n/n in convex
/// order, and (b − x)⁺ is convex with mean π_b under that law (docs/statistics.md has the proof). So both
/// are non-negative supermartingales along independent runs, and P(W⁺ ever ≥ 1/α) ≤ α, the same for W⁻ and
/// for ½ (W⁺ + W⁻) ([Ville 1939]; Waudby-Smith and Ramdas, "Estimating means of bounded random variables by
/// betting", J. R. Stat. Soc. B 2024). Unequal dofs in a run: π_b of the least.
///
/// A share of almost one serves averages that vary little, small ones those that vary much;
/// docs/statistics.md has the power measured.

namespace credence::internal {

/// The stakes: shares λ of W⁺, and strikes b each with shares λ for W⁻.
inline constexpr std::array kOptimisticShares{0.1, 0.25, 0.5, 0.99};
inline constexpr std::array kPessimisticStrikes{1.5, 2.0, 4.0};
inline constexpr std::array kPessimisticShares{0.3, 0.9};

/// E(χ²(dof)/dof − strike)⁺ = P(χ²(dof + 2) > dof · strike) − strike · P(χ²(dof) > dof · strike). Throws
/// std::invalid_argument unless dof > 0 and strike ≥ 0 are finite.
double chi_square_excess(double dof, double strike);

/// The prices π_b that the bets of a run need.
struct BettingPrices {
  std::array<double, kPessimisticStrikes.size()> price{};
};

/// The dearest prices of a run whose steps have at least this dof, those of steps that all have it. Throws
/// std::invalid_argument unless it is finite and positive.
BettingPrices betting_prices(double least_dof);

/// The capital of all bets over the runs seen so far, in logarithms.
class RunBetting {
 public:
  /// The next run: its average, NaN counts as infinite evidence of nothing and makes the e-values NaN. The
  /// dofs must not depend on the errors. Costs ten logarithms.
  void add(double run_average, const BettingPrices& prices);

  std::int64_t runs() const { return runs_; }
  double log_optimistic() const;   ///< ln W⁺; 0 before the first run
  double log_pessimistic() const;  ///< ln W⁻
  double log_e_value() const;      ///< ln of ½ (W⁺ + W⁻)

  bool operator==(const RunBetting&) const = default;

 private:
  std::int64_t runs_ = 0;
  std::array<double, kOptimisticShares.size()> optimistic_{};
  std::array<double, kPessimisticStrikes.size() * kPessimisticShares.size()> pessimistic_{};
};

}  // namespace credence::internal
