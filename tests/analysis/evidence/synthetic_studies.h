#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "montecarlo/engine/moments.h"

namespace credence::internal::test {

/// A scalar random walk seen in noise, x⁺ = x + v, z = x + w, with its Kalman filter in steady state: for a
/// small Q/R the error, and so the NEES, is correlated over many steps.
///
/// The filter may assume process and measurement variances that are wrong by a factor.
class ScalarFilter {
 public:
  ScalarFilter(double q, double r, double assumed_q_scale = 1.0, double assumed_r_scale = 1.0)
      : q_(q), r_(r), assumed_q_(q * assumed_q_scale), assumed_r_(r * assumed_r_scale) {
    // P⁻ solves P⁻ = P⁻ R / (P⁻ + R) + Q.
    prior_ = 0.5 * (assumed_q_ + std::sqrt(assumed_q_ * assumed_q_ + 4.0 * assumed_q_ * assumed_r_));
    gain_ = prior_ / (prior_ + assumed_r_);
    posterior_ = (1.0 - gain_) * prior_;
    // The true error variance with this gain: Σ = (1−K)² (Σ + Q) + K² R.
    const double a = (1.0 - gain_) * (1.0 - gain_);
    true_posterior_ = (a * q_ + gain_ * gain_ * r_) / (1.0 - a);
  }

  /// Adds `runs` runs to the moments of every step; nees and nis have one entry for each step.
  template <typename Generator>
  void simulate(int runs, Generator& generator, std::vector<Moments>& nees, std::vector<Moments>& nis) const {
    std::normal_distribution<double> normal;
    for (int run = 0; run < runs; ++run) {
      double error = std::sqrt(true_posterior_) * normal(generator);
      for (std::size_t k = 0; k < nees.size(); ++k) {
        const double prior_error = error + std::sqrt(q_) * normal(generator);
        const double innovation = std::sqrt(r_) * normal(generator) - prior_error;
        error = prior_error + gain_ * innovation;
        nees[k].add(error * error / posterior_);
        nis[k].add(innovation * innovation / (prior_ + assumed_r_));
      }
    }
  }

 private:
  double q_, r_, assumed_q_, assumed_r_;
  double prior_, gain_, posterior_, true_posterior_;
};

/// Standard errors of a rate measured in `studies` trials, for a nominal rate.
inline double binomial_standard_error(double rate, int studies) {
  return std::sqrt(rate * (1.0 - rate) / studies);
}

}  // namespace credence::internal::test
