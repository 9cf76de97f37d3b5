#pragma once

#include <cstdint>
#include <span>

namespace credence {

class NoiseSource;
enum class NoisePurpose : std::uint32_t;

/// How the noise of one purpose differs from the white Gaussian noise that filters assume; each slot by
/// itself. Mean 0; the variance stays 1 but for outliers.
///
/// In this order: correlation along the steps, Student's tails, outliers.
struct NoiseShape {
  /// ρ in [0, 0.9999]: E[n_j n_k] = ρ^|j−k|, a stationary Gauss-Markov sequence.
  double correlation = 0.0;
  /// Student's t with so many degrees of freedom, at least 3, scaled to variance 1; 0: Gaussian.
  int student_dof = 0;
  /// Chance that a number is multiplied by `outlier_scale`: the variance is 1 + rate (scale² − 1).
  double outlier_rate = 0.0;
  double outlier_scale = 10.0;

  /// Whether it is white and Gaussian.
  bool is_plain() const { return keeps_covariance() && student_dof == 0; }
  /// Whether it is white and of variance 1: a linear filter then errs as much as it believes.
  bool keeps_covariance() const { return correlation == 0.0 && outlier_rate == 0.0; }

  bool operator==(const NoiseShape&) const = default;
};

}  // namespace credence

namespace credence::internal {

/// Throws std::invalid_argument naming the number that cannot be.
void check_noise_shape(const NoiseShape& shape);

/// out[k · slots + slot] = the number of slot first_slot + slot at step first_step + k, shaped out of the
/// normals of `plain`, for as many steps as `out` has room.
///
/// A pure function of its key, like any other number of a NoiseSource: the Gauss-Markov sequence is drawn by
/// bisection, in which the middle of an interval is its law given both ends, from intervals so long that
/// their ends are independent to the last bit. It so takes some log2(40/(1 − ρ)) normals a call more.
/// Student's χ² is the sum of as many squares, of purpose `tail`. Allocates.
void shaped_normals(const NoiseSource& plain, const NoiseShape& shape, std::int64_t run,
                    std::int64_t first_step, NoisePurpose purpose, std::int64_t first_slot,
                    std::int64_t slots, std::span<double> out);

}  // namespace credence::internal
