#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "analysis/laws/mean/run_mean.h"
#include "core/types.h"
#include "montecarlo/engine/skewed_moments.h"

/// @file
/// Whether Σ = P on average over a run, entry by entry, whatever the law of the errors and their dependence
/// in time.
///
/// A_i = Σ_k u_ik u_ikᵀ/T, the average over the steps of run i of the outer product of its whitened error u =
/// R^{-1/2} D⁻¹ e, P = D R D (correlation_whitening.h), is independent over the runs, with E A_i = I as soon
/// as the second moments of P are right. A state in another place or unit has the same u. Its d² directional
/// averages aᵀ A_i a, a = e_p and a = (e_p ± e_q)/√2, fix all its entries, are not negative and have mean 1,
/// so that each takes the test of run_mean.h, whose scores need no Gaussian law; they are joined by Holm.
/// Their run sample variances are those of a sandwich estimator; Hotelling's T² of the entries is not used,
/// as it does not hold its level for averages so skewed. Gaussian errors are assumed only with fewer than 20
/// runs, by the bound of run_mean.h.

namespace credence::internal {

/// e_p for sign 0 (q = p), else (e_p + sign e_q)/√2 with q < p.
struct SecondMomentDirection {
  Index p = 0, q = 0;
  int sign = 0;
  bool operator==(const SecondMomentDirection&) const = default;
};

/// The d² directions, in the order of SecondMoments.
std::vector<SecondMomentDirection> second_moment_directions(Index dim);

/// The moments over runs of the directional averages: mergeable as SkewedMoments are.
class SecondMoments {
 public:
  SecondMoments() = default;
  /// From stored sums; throws std::invalid_argument unless there are dim² of them.
  SecondMoments(Index dim, std::vector<SkewedMoments> along);

  /// The next run's A, d×d and symmetric (the lower triangle is read). Throws std::invalid_argument for
  /// another size than before, or one that is empty or not square.
  void add(MatrixRef run_average);
  /// Throws std::invalid_argument for another dimension, unless either is empty.
  void merge(const SecondMoments& other);

  Index dim() const { return dim_; }
  std::int64_t runs() const { return along_.empty() ? 0 : along_.front().count; }
  /// One for each of second_moment_directions(dim()).
  const std::vector<SkewedMoments>& along() const { return along_; }

  bool operator==(const SecondMoments&) const = default;

 private:
  Index dim_ = 0;
  std::vector<SkewedMoments> along_;
};

/// The mean of A over the runs.
Matrix mean_of(const SecondMoments& moments);

/// What the directions say together.
struct SecondMomentTest {
  std::int64_t runs = 0;
  Matrix mean;                            ///< of A over the runs
  DirectedPValues p_value;                ///< the least of all directions, adjusted for all 2 d² hypotheses
                                          ///< (Holm): each is compared with α itself
  SecondMomentDirection worst_direction;  ///< of the least p-value
  SecondMomentDirection most_optimistic, most_pessimistic;  ///< of the least of each side
  MeanInterval worst;  ///< the factor along it; holds together with those of all others
  /// All eigenvalues of E A lie here, from the simultaneous intervals of its entries (Weyl's inequality):
  /// valid, and wide, of which none is negative; 0 and infinite where an entry has no upper bound.
  double least_factor = 0.0, largest_factor = 0.0;
  std::string_view reason = {};  ///< why there is no test (numbers NaN), else empty
};

/// Tests E A = I. Level as run_mean.h at a level divided by 2 d², proved only for many runs; measured in the
/// tests. Throws std::invalid_argument unless 0 < confidence < 1.
SecondMomentTest test_second_moments(const SecondMoments& moments, double confidence);

}  // namespace credence::internal
