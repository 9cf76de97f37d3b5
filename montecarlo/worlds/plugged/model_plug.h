#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/types.h"
#include "montecarlo/worlds/plugged/plugged_concepts.h"

/// @file
/// The smallest way to be judged: two functions and two matrices, of which both a world and an extended
/// Kalman filter are made.

namespace credence {

/// x_k = f(x_{k−1}) + w, w ~ N(0, Q);  z_k = h(x_k) + v, v ~ N(0, R);  x_0 ~ N(mean, P0).
struct FunctionModel {
  std::function<Vector(const Vector&)> f, h;
  Matrix Q, R;                             ///< n×n, m×m; psd, R positive definite
  Vector mean;                             ///< n
  Matrix P0;                               ///< n×n, psd
  std::vector<std::string> states = {};    ///< names; "heading:angle" is an angle in rad; empty: x1, x2, …
  std::vector<std::string> units = {};     ///< of the states, "m", "m/s"; empty: not known
  std::vector<bool> measured_angles = {};  ///< which measurements are angles in rad; empty: none
  /// The Jacobians of f and h; by central differences where they are not given.
  std::function<Matrix(const Vector&)> F = {}, H = {};
};

/// The world of a model.
class FunctionWorld {
 public:
  /// Throws std::invalid_argument naming the part for a function that is not there, for sizes that do not
  /// fit, and for a Q, R or P0 that is no covariance.
  explicit FunctionWorld(const FunctionModel& model);

  Prior<Vector> prior() const { return {model_.mean, model_.P0}; }
  Vector initial(NoiseDraw& noise) const;
  Vector step(const Vector& x, std::int64_t k, NoiseDraw& noise) const;
  Vector measure(const Vector& x, std::int64_t k, NoiseDraw& noise) const;
  Vector minus(const Vector& a, const Vector& b) const;
  const RunLayout& layout() const { return layout_; }

 private:
  FunctionModel model_;
  RunLayout layout_;
  Matrix root_Q_, root_R_, root_P0_;
};

/// What a filter of a model starts from and shows.
class FunctionFilter {
 public:
  /// Throws as FunctionWorld does.
  explicit FunctionFilter(const FunctionModel& model);

  void reset(const Vector& mean, const Matrix& P);
  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  const Vector& innovation() const { return nu_; }
  const Matrix& innovation_covariance() const { return S_; }

 protected:
  FunctionModel model_;
  std::vector<bool> state_angles_;
  Vector x_, nu_;
  Matrix P_, S_;
};

/// The extended Kalman filter of a model ([Bar-Shalom 2001], section 10.3), Joseph form.
class FunctionEkf : public FunctionFilter {
 public:
  using FunctionFilter::FunctionFilter;

  void predict();
  /// False where S is not positive definite.
  bool update(const Vector& z);

  /// Where a Jacobian that was given differs from differences of its function at the state.
  std::optional<std::string> jacobian_problem() const;

 private:
  Matrix jacobian_of_f(const Vector& x) const;
  Matrix jacobian_of_h(const Vector& x) const;
};

}  // namespace credence

namespace credence::internal {

/// Wraps those components that are angles in rad; empty: none.
void wrap_angles(Vector& v, const std::vector<bool>& angles);

/// ε^(1/3): the step of differences, of a component of x that is larger than 1 times it.
inline constexpr double kDifferenceStep = 6.055454452393343e-06;

/// The Jacobian of `function` at x by central differences; where `angles` says so a component is an angle,
/// whose differences are wrapped.
Matrix difference_jacobian(const std::function<Vector(const Vector&)>& function, const Vector& x,
                           const std::vector<bool>& angles = {});

}  // namespace credence::internal
