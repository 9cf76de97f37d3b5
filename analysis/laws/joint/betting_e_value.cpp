#include "analysis/laws/joint/betting_e_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/require.h"
#include "analysis/laws/scores/log_mean_exp.h"

namespace credence::internal {

double chi_square_excess(double dof, double strike) {
  require_positive("dof", dof);
  if (!(std::isfinite(strike) && strike >= 0.0)) {
    throw std::invalid_argument(fmt::format("strike = {} must be a finite number >= 0", strike));
  }
  return chi_square_survival(dof * strike, dof + 2.0) - strike * chi_square_survival(dof * strike, dof);
}

BettingPrices betting_prices(double least_dof) {
  BettingPrices prices;
  for (std::size_t i = 0; i < kPessimisticStrikes.size(); ++i) {
    const double strike = kPessimisticStrikes[i];
    prices.price[i] = strike - 1.0 + chi_square_excess(least_dof, strike);
  }
  return prices;
}

void RunBetting::add(double run_average, const BettingPrices& prices) {
  ++runs_;
  for (std::size_t i = 0; i < optimistic_.size(); ++i) {
    optimistic_[i] += std::log1p(kOptimisticShares[i] * (run_average - 1.0));
  }
  std::size_t bet = 0;
  for (std::size_t i = 0; i < kPessimisticStrikes.size(); ++i) {
    const double payoff = std::max(kPessimisticStrikes[i] - run_average, 0.0) / prices.price[i] - 1.0;
    for (const double share : kPessimisticShares) pessimistic_[bet++] += std::log1p(share * payoff);
  }
}

double RunBetting::log_optimistic() const { return log_mean_exp(optimistic_); }

double RunBetting::log_pessimistic() const { return log_mean_exp(pessimistic_); }

double RunBetting::log_e_value() const {
  return log_mean_exp(std::array{log_optimistic(), log_pessimistic()});
}

}  // namespace credence::internal
