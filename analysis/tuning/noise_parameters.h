#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/tuning/score_model.h"
#include "core/models/linear_model.h"

/// @file
/// What of the noise that a linear filter believes in is free, and the coordinates in which it is sought.

namespace credence::internal {

/// A covariance of LinearModel.
enum class NoiseMatrix { Q, R, P0 };

/// "Q", "R" or "P0".
std::string_view to_string(NoiseMatrix matrix);

/// What of a covariance is free.
enum class NoiseForm {
  factor,    ///< one factor on the whole
  diagonal,  ///< every variance; the covariances stay 0
  full,      ///< every element, by the Cholesky factor, so that it stays positive definite
};

/// A covariance that is free.
struct FreeNoise {
  NoiseMatrix matrix = NoiseMatrix::Q;
  NoiseForm form = NoiseForm::factor;

  bool operator==(const FreeNoise&) const = default;
};

/// Reads "Q, R", "diag(Q), full(R)" and such. Throws std::invalid_argument for anything else, for nothing,
/// and for a matrix named twice.
std::vector<FreeNoise> parse_free_noise(std::string_view text);

/// ∂Q, ∂R and ∂P0 by one coordinate; empty where zero.
struct NoiseDerivative {
  Matrix Q, R, P0;
};

/// The free covariances of a model as a vector φ without constraints: logarithms of factors and variances,
/// and for a full covariance A = L Lᵀ the logarithms of L_jj and the L_ij, i > j, over √A_ii of the start.
/// φ = 0 in all factors and variances is the model given.
class NoiseParameters {
 public:
  /// Throws std::invalid_argument, naming the matrix: for one that is 0 (no factor of it is anything else),
  /// whose diagonal has a 0 or which is not diagonal (NoiseForm::diagonal), or which is not positive definite
  /// (NoiseForm::full).
  NoiseParameters(LinearModel start, std::vector<FreeNoise> free);

  Index size() const { return std::ssize(coordinates_); }
  const Vector& start() const { return start_; }
  const LinearModel& model() const { return model_; }
  const std::vector<FreeNoise>& free() const { return free_; }

  /// Names of the coordinates: "Q" for a factor, "Q[1,1]", and "L_Q[2,1]" for an element of the Cholesky
  /// factor.
  std::vector<std::string> names() const;

  /// The model with these covariances.
  LinearModel at(const Vector& phi) const;
  std::vector<NoiseDerivative> derivatives(const Vector& phi) const;

  /// φ with each of the free covariances multiplied by exp(t), and ∂φ/∂t at t = 0, a column for each.
  Vector scaled(const Vector& phi, const Vector& t) const;
  Matrix scale_directions(const Vector& phi) const;

  /// As many as there are coordinates: factors, variances, elements of the lower triangle.
  std::vector<NoiseValue> values(const Vector& phi) const;

 private:
  /// A factor (row < 0) or an element of a variance or of L.
  struct Coordinate {
    FreeNoise of;
    Index row = -1, column = -1;
    double scale = 1.0;  ///< of an L_ij, i > j
  };

  Matrix root(NoiseMatrix matrix, const Vector& phi) const;
  /// Where among the free ones the covariance of a coordinate stands.
  Index place_of(const Coordinate& coordinate) const;

  LinearModel model_;
  std::vector<FreeNoise> free_;
  std::vector<Coordinate> coordinates_;
  Vector start_;
};

}  // namespace credence::internal
