#include "core/filters/estimators/intersection_estimator.h"

#include "core/linear_algebra/cholesky.h"
#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

using PoseMatrix = Eigen::Matrix3d;

/// One observation of one landmark with the bound that ω gives.
struct Intersection {
  PoseMatrix dependent, independent;
  Eigen::Matrix2d P_l, R;
  Eigen::Matrix<double, 2, 3> H_r;
  Eigen::Matrix2d H_l;

  PoseMatrix vehicle(double omega) const { return dependent / omega + independent; }
  Eigen::Matrix2d landmark(double omega) const { return P_l / (1.0 - omega); }
  Eigen::Matrix2d innovation_covariance(double omega) const {
    return H_r * vehicle(omega) * H_r.transpose() + H_l * landmark(omega) * H_l.transpose() + R;
  }
};

/// B − B Hᵀ S⁻¹ H B.
template <class Square, class Rows>
Square corrected(const Square& B, const Rows& H, const Eigen::Matrix2d& S) {
  const Rows HB = H * B;
  const Square P = B - HB.transpose() * S.llt().solve(HB);
  return 0.5 * (P + P.transpose());
}

/// Σ of the variances of A over those of B, where B has any.
template <class Square>
double relative_trace(const Square& A, const Square& B) {
  double sum = 0.0;
  for (Index i = 0; i < B.rows(); ++i) sum += B(i, i) > 0.0 ? A(i, i) / B(i, i) : 0.0;
  return sum;
}

/// Whether the best ω makes the variances of B smaller; where none does, ω = 1 or 0 leaves them as they are.
template <class Square>
bool improves(const Square& A, const Square& B) {
  return relative_trace(A, B) < relative_trace(B, B);
}

/// The ω in (0, 1) where a convex cost is least, to 1e-3, by golden sections.
template <class Cost>
double least(Cost cost) {
  constexpr double kRatio = 0.6180339887498949;
  double lower = 1e-6, upper = 1.0 - 1e-6;
  double a = upper - kRatio * (upper - lower), b = lower + kRatio * (upper - lower);
  double cost_a = cost(a), cost_b = cost(b);
  while (upper - lower > 1e-3) {
    if (cost_a < cost_b) {
      upper = b;
      b = a;
      cost_b = cost_a;
      a = upper - kRatio * (upper - lower);
      cost_a = cost(a);
    } else {
      lower = a;
      a = b;
      cost_a = cost_b;
      b = lower + kRatio * (upper - lower);
      cost_b = cost(b);
    }
  }
  return 0.5 * (lower + upper);
}

}  // namespace

void IntersectionEstimator::propagate(const Pose& before, const Motion& motion, const Control& u,
                                      const PlanarTruth& truth) {
  EkfEstimator::propagate(before, motion, u, truth);
  const PoseMatrix& F = motion_jacobian();
  independent_ = (F * independent_ * F.transpose() + motion.G * settings().Q * motion.G.transpose()).eval();
}

bool IntersectionEstimator::correct(UpdateResult& result) {
  auto [S, L, W] = start_correction(2 * std::ssize(seen_z()));
  Intersection observation;
  observation.R = settings().R;
  if (settings().R.llt().info() != Eigen::Success) return false;  // else every S is positive definite
  Pose x_r = pose();
  PoseMatrix P_r = pose_covariance(), independent = independent_;
  moved_.clear();
  for (std::size_t i = 0; i < seen_z().size(); ++i) {
    const auto row = static_cast<Index>(2 * i);
    const Index offset = seen()[3 + 2 * i];
    plane_jacobian(x_r, landmark(offset), observation.H_r, observation.H_l);
    const Eigen::Vector2d innovation = innovation_of(i, x_r, landmark(offset));
    set_rows(row / 2, innovation, observation.H_r, observation.H_l);
    const Eigen::Matrix2d P_l = P().block<2, 2>(offset, offset).selfadjointView<Eigen::Lower>();
    observation.independent = independent;
    observation.dependent = P_r - independent;
    observation.P_l = P_l;
    const double omega = least([&](double w) {
      return relative_trace(
          corrected(observation.vehicle(w), observation.H_r, observation.innovation_covariance(w)), P_r);
    });
    const double omega_l = least([&](double w) {
      return relative_trace(
          corrected(observation.landmark(w), observation.H_l, observation.innovation_covariance(w)), P_l);
    });
    const Eigen::Matrix2d S_r = observation.innovation_covariance(omega),
                          S_l = observation.innovation_covariance(omega_l);
    const Eigen::LLT<Eigen::Matrix2d> llt(S_r), llt_l(S_l);
    if (llt.info() != Eigen::Success || llt_l.info() != Eigen::Success || !S_r.allFinite()) return false;
    const PoseMatrix B_r = observation.vehicle(omega);
    const Eigen::Matrix2d B_l = observation.landmark(omega_l);
    Eigen::Matrix<double, 3, 2> K_r = llt.solve(observation.H_r * B_r).transpose();
    Eigen::Matrix2d K_l = llt_l.solve(observation.H_l * B_l).transpose();
    PoseMatrix P_r_after = corrected(B_r, observation.H_r, S_r);
    Eigen::Matrix2d P_l_after = corrected(B_l, observation.H_l, S_l);
    if (!improves(P_r_after, P_r)) {
      K_r.setZero();
      P_r_after = P_r;
    }
    if (!improves(P_l_after, P_l)) {
      K_l.setZero();
      P_l_after = P_l;
    }
    x_r += K_r * innovation;
    x_r[2] = wrap_angle(x_r[2]);
    P_r = P_r_after;
    moved_.push_back({offset, K_l * innovation, P_l_after});
    independent.setZero();

    const Eigen::Matrix2d root = llt.matrixL();
    S.block<2, 2>(row, row) = S_r;
    L.block<2, 2>(row, row) = root;
    W.block<3, 2>(0, row) = K_r * root;
    W.block<2, 2>(offset, row) = K_l * root;
    result.nis += llt.matrixL().solve(innovation).squaredNorm();
  }
  x().head<3>() = x_r;
  P().topLeftCorner<3, 3>() = P_r;
  independent_ = independent;
  for (const Moved& moved : moved_) {
    x().segment<2>(moved.offset) += moved.delta;
    P().block<2, 2>(moved.offset, moved.offset) = moved.P;
  }
  return true;
}

bool IntersectionEstimator::refine(Batch, const PlanarTruth&) {
  if (placements().empty()) return true;
  const Index fresh = size() - 2 * std::ssize(placements());
  for (Index i = fresh; i < size(); i += 2) P().block(i, 0, 2, i).setZero();
  independent_.setZero();
  return true;
}

}  // namespace credence::internal
