#pragma once

#include <string>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// A number that is reported, such as an element of Q, with what it takes to give it an interval.
struct NoiseValue {
  std::string name;
  double value = 0.0;
  Vector gradient;       ///< ∂value/∂φ
  bool positive = true;  ///< a variance or factor: its interval is one of its logarithm
};

/// Log scores of stretches of data, which are the units of every interval.
struct UnitScores {
  Vector value;                   ///< ln of the density of the innovations of each unit
  Matrix gradient;                ///< ∂value/∂φ, parameters × units; empty where not asked for
  Vector nis;                     ///< Σ νᵀ S⁻¹ ν of each unit
  Vector lag_one;                 ///< Σ u_kᵀ u_{k−1} of each unit, u = L⁻¹ ν, S = L Lᵀ
  double steps = 0.0, dof = 0.0;  ///< of all units: steps with a measurement, and components of it
  /// false: some S was not positive definite or some number not finite, and the others mean nothing.
  bool ok = true;
  /// Sensors of one step are scored apart, as if independent: no likelihood where they share a prior.
  bool composite = false;

  double sum() const { return value.sum(); }
  double mean_nis() const { return nis.sum() / steps; }
  /// Lag-one correlation of the normalised innovation, averaged over its components.
  double lag_one_correlation() const { return lag_one.sum() / nis.sum(); }
};

/// What a search climbs.
class ScoreFunction {
 public:
  virtual ~ScoreFunction() = default;

  /// Whether the gradient is exact and cheap, or one of differences.
  virtual bool has_gradient() const = 0;
  /// Safe to call from one thread at a time. The bits do not depend on the threads that it may use.
  virtual UnitScores scores(const Vector& phi, bool gradient) const = 0;
};

/// The data and a filter whose noise is free, as the log score of the innovations in coordinates φ without
/// constraints: ln p(z_k | z_1 … z_{k−1}) = −½ (m ln 2π + ln det S + νᵀ S⁻¹ ν), summed. It is the likelihood
/// of the data under what the filter believes, and a proper score: no other φ scores better on average than
/// that of the true law ([Mehra 1970]; proper_scores.h).
class ScoreModel : public ScoreFunction {
 public:
  virtual Index parameters() const = 0;
  /// Of the coordinates, and what they amount to: as many numbers, each with coordinates of its own.
  virtual std::vector<std::string> names() const = 0;
  virtual std::vector<NoiseValue> values(const Vector& phi) const = 0;
  virtual Index units() const = 0;
  /// The change of φ below which differences of the score are its roughness and not its shape.
  virtual double resolution() const { return 0.0; }
  /// The information of data of this size if the filter at φ is right; empty where it is not known.
  virtual Matrix expected_information(const Vector& phi) const = 0;
  /// φ with covariance i, of those that are free, multiplied by exp(t_i), and ∂φ/∂t at t = 0, a column for
  /// each. There are none where every coordinate is a factor of its own.
  virtual Vector scaled(const Vector& phi, const Vector& /*t*/) const { return phi; }
  virtual Matrix scale_directions(const Vector& phi) const { return Matrix(phi.size(), 0); }
};

}  // namespace credence::internal
