#include "montecarlo/worlds/plugged/model_plug.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/psd_root.h"
#include "core/linear_algebra/symmetry.h"
#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

void require_dimensions(const char* name, const Matrix& M, Index rows, Index columns) {
  if (M.rows() == rows && M.cols() == columns) return;
  throw std::invalid_argument(
      fmt::format("{} is {}x{}: expected {}x{}", name, M.rows(), M.cols(), rows, columns));
}

void require_size(const char* name, Index size, Index n) {
  if (size != n) throw std::invalid_argument(fmt::format("{} has {} entries: expected {}", name, size, n));
}

/// A covariance that noise can be drawn with.
void require_covariance(const char* name, const Matrix& M, Index n) {
  require_dimensions(name, M, n, n);
  if (!M.allFinite()) throw std::invalid_argument(fmt::format("{} is not finite", name));
  if (!is_symmetric(M, kMostAsymmetry)) throw std::invalid_argument(fmt::format("{} is not symmetric", name));
  if (is_psd(M, kMostAsymmetry)) return;
  throw std::invalid_argument(fmt::format("{} is not positive semidefinite", name));
}

RunLayout layout_of(const FunctionModel& model) {
  std::vector<std::string> states = model.states;
  for (Index i = std::ssize(states); i < model.mean.size() && model.states.empty(); ++i) {
    states.push_back(fmt::format("x{}", i + 1));
  }
  RunLayout layout = model_layout(states, {{"", model.R.rows()}});
  if (!model.units.empty()) layout.units = model.units;
  layout.sensors.front().angles = model.measured_angles;
  layout.nonlinear = true;
  return layout;
}

const FunctionModel& checked(const FunctionModel& model) {
  const Index n = model.mean.size(), m = model.R.rows();
  if (!model.f) throw std::invalid_argument("f is missing");
  if (!model.h) throw std::invalid_argument("h is missing");
  if (n == 0) throw std::invalid_argument("mean is empty");
  if (m == 0) throw std::invalid_argument("R is empty");
  require_covariance("Q", model.Q, n);
  require_covariance("P0", model.P0, n);
  require_covariance("R", model.R, m);
  require_size("f(mean)", model.f(model.mean).size(), n);
  require_size("h(mean)", model.h(model.mean).size(), m);
  if (model.F) require_dimensions("F(mean)", model.F(model.mean), n, n);
  if (model.H) require_dimensions("H(mean)", model.H(model.mean), m, n);
  if (!model.states.empty()) require_size("states", std::ssize(model.states), n);
  if (!model.units.empty()) require_size("units", std::ssize(model.units), n);
  if (!model.measured_angles.empty()) require_size("measured_angles", std::ssize(model.measured_angles), m);
  return model;
}

/// Where two Jacobians differ by more than differences err.
std::optional<std::string> difference(const char* name, const Matrix& given, const Matrix& differences) {
  constexpr double kTolerance = 1e-5;
  if (given.rows() != differences.rows() || given.cols() != differences.cols()) {
    return fmt::format("{} is {}x{}: expected {}x{}", name, given.rows(), given.cols(), differences.rows(),
                       differences.cols());
  }
  Index i = 0, j = 0;
  const double largest = (given - differences).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&i, &j);
  if (largest <= kTolerance * std::max(1.0, differences.cwiseAbs().maxCoeff())) return std::nullopt;
  return fmt::format("{} is not the Jacobian of its function: entry ({}, {}) is {}, by differences {}", name,
                     i, j, given(i, j), differences(i, j));
}

}  // namespace

void wrap_angles(Vector& v, const std::vector<bool>& angles) {
  for (std::size_t i = 0; i < angles.size(); ++i) {
    if (angles[i]) v[static_cast<Index>(i)] = wrap_angle(v[static_cast<Index>(i)]);
  }
}

Matrix difference_jacobian(const std::function<Vector(const Vector&)>& function, const Vector& x,
                           const std::vector<bool>& angles) {
  Matrix J;
  for (Index i = 0; i < x.size(); ++i) {
    Vector ahead = x, behind = x;
    const double step = kDifferenceStep * std::max(1.0, std::abs(x[i]));
    ahead[i] += step;
    behind[i] -= step;
    Vector change = function(ahead) - function(behind);
    wrap_angles(change, angles);
    if (i == 0) J.resize(change.size(), x.size());
    J.col(i) = change / (ahead[i] - behind[i]);
  }
  return J;
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

FunctionWorld::FunctionWorld(const FunctionModel& model)
    : model_(checked(model)),
      layout_(layout_of(model_)),
      root_Q_(psd_root(model_.Q)),
      root_R_(psd_root(model_.R)),
      root_P0_(psd_root(model_.P0)) {}

Vector FunctionWorld::initial(NoiseDraw& noise) const {
  return model_.mean + root_P0_ * noise.normals(model_.mean.size());
}

Vector FunctionWorld::step(const Vector& x, std::int64_t, NoiseDraw& noise) const {
  return model_.f(x) + root_Q_ * noise.normals(x.size());
}

Vector FunctionWorld::measure(const Vector& x, std::int64_t, NoiseDraw& noise) const {
  Vector z = model_.h(x) + root_R_ * noise.normals(model_.R.rows());
  wrap_angles(z, model_.measured_angles);
  return z;
}

Vector FunctionWorld::minus(const Vector& a, const Vector& b) const {
  Vector difference = a - b;
  wrap_angles(difference, layout_.angles);
  return difference;
}

FunctionFilter::FunctionFilter(const FunctionModel& model)
    : model_(checked(model)), state_angles_(layout_of(model_).angles) {}

void FunctionFilter::reset(const Vector& mean, const Matrix& P) {
  require_size("the prior of the world", mean.size(), model_.mean.size());
  x_ = mean;
  P_ = P;
}

Matrix FunctionEkf::jacobian_of_f(const Vector& x) const {
  return model_.F ? model_.F(x) : difference_jacobian(model_.f, x, state_angles_);
}

Matrix FunctionEkf::jacobian_of_h(const Vector& x) const {
  return model_.H ? model_.H(x) : difference_jacobian(model_.h, x, model_.measured_angles);
}

void FunctionEkf::predict() {
  const Matrix F = jacobian_of_f(x_);
  x_ = model_.f(x_);
  P_ = (F * P_ * F.transpose() + model_.Q).eval();
}

bool FunctionEkf::update(const Vector& z) {
  require_size("the measurement", z.size(), model_.R.rows());
  const Matrix H = jacobian_of_h(x_);
  nu_ = z - model_.h(x_);
  wrap_angles(nu_, model_.measured_angles);
  const Matrix HP = H * P_;
  S_ = HP * H.transpose() + model_.R;
  const Eigen::LLT<Matrix> factor(S_);
  if (factor.info() != Eigen::Success) return false;
  const Matrix K = factor.solve(HP).transpose();
  x_ += K * nu_;
  wrap_angles(x_, state_angles_);
  const Matrix T = Matrix::Identity(x_.size(), x_.size()) - K * H;
  const Vector before = P_.diagonal();
  P_ = (T * P_ * T.transpose() + K * model_.R * K.transpose()).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  clear_rounded_variances(P_, before);
  return true;
}

std::optional<std::string> FunctionEkf::jacobian_problem() const {
  if (model_.F) {
    auto problem = difference("F", model_.F(x_), difference_jacobian(model_.f, x_, state_angles_));
    if (problem) return problem;
  }
  if (!model_.H) return std::nullopt;
  return difference("H", model_.H(x_), difference_jacobian(model_.h, x_, model_.measured_angles));
}

}  // namespace credence
