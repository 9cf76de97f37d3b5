#pragma once

#include <random>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "core/filters/estimators/slam_estimator.h"
#include "core/manifold/angle.h"
#include "core/manifold/rotation.h"
#include "tests/core/models/numerical_jacobian.h"

/// @file
/// A noisy drive among five landmarks that brings an estimator into a state where everything is correlated,
/// and the dense textbook formulas to which its next step is compared.

namespace credence::internal {

class EstimatorTour {
 public:
  using Observations = std::vector<Observation<PlanarModel>>;

  explicit EstimatorTour(LandmarkSensorKind sensor, VehicleKind vehicle = VehicleKind::unicycle,
                         unsigned seed = 1)
      : random_(seed) {
    settings.model.vehicle.kind = vehicle;
    settings.model.dt_s = 0.5;
    settings.sensor.kind = sensor;
    settings.Q << 4e-3, 1e-4, 1e-4, 2e-3;
    settings.R << 9e-3, 1e-3, 1e-3, 2e-3;
    settings.landmarks = std::ssize(landmarks);
  }

  EstimatorSettings settings;
  std::vector<Point> landmarks{{4.0, 1.0}, {-2.0, 5.0}, {6.0, -3.0}, {1.5, 7.0}, {-5.0, -2.0}};
  Pose before{0.5, -1.0, 0.3}, now = before;
  Control control{0.8, 0.15};

  PlanarTruth truth() const { return {before, now, landmarks}; }
  static Eigen::Matrix3d initial_covariance() {
    Eigen::Matrix3d P;
    P << 0.04, 0.01, 0.002, 0.01, 0.03, -0.001, 0.002, -0.001, 0.01;
    return P;
  }

  /// Moves the truth; the control as it was read.
  Control drive() {
    drive_exactly();
    return control + drawn(settings.Q);
  }

  /// Noisy observations of these landmarks, in this order.
  Observations see(std::span<const int> numbers) {
    Observations observations;
    for (const int i : numbers) {
      const Eigen::Vector2d rho =
          rotation(now[2]).transpose() * (landmarks[static_cast<std::size_t>(i)] - now.head<2>());
      observations.push_back({i, settings.sensor.measure(rho) + drawn(settings.R)});
    }
    return observations;
  }
  Observations see(std::initializer_list<int> numbers) { return see(std::vector<int>(numbers)); }

  /// Without noise.
  void drive_exactly() {
    before = now;
    now = settings.model.move(now, control).pose;
  }
  Observations see_exactly(std::initializer_list<int> numbers) const {
    Observations observations;
    for (const int i : numbers) {
      const Eigen::Vector2d rho =
          rotation(now[2]).transpose() * (landmarks[static_cast<std::size_t>(i)] - now.head<2>());
      observations.push_back({i, settings.sensor.measure(rho)});
    }
    return observations;
  }

  /// Some steps from a wrong start, after which the landmarks 3, 0, 1, 4 are in the state, in this order.
  void warm(SlamEstimator& filter) {
    const Eigen::Matrix3d P0 = initial_covariance();
    const Pose off(0.15, -0.1, 0.06);
    filter.reset(now + off, P0);
    for (const auto& numbers : {std::vector<int>{3, 0}, {0, 3, 1}, {4, 3}, {1, 0, 4}}) {
      const Control read = drive();
      filter.predict(read, truth());
      filter.update(see(numbers), truth());
    }
  }

 private:
  Eigen::Vector2d drawn(const Eigen::Matrix2d& covariance) {
    const Eigen::Vector2d white(normal_(random_), normal_(random_));
    return covariance.llt().matrixL() * white;
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

inline Matrix whole_covariance(const SlamEstimator& filter) {
  return filter.covariance().selfadjointView<Eigen::Lower>();
}

/// z of the landmarks that start at these states, of a pose and a map, one after the other.
inline Vector textbook_measurement(const EstimatorSettings& settings, const Vector& x,
                                   std::span<const Index> offsets) {
  Vector z(2 * std::ssize(offsets));
  for (Index i = 0; 2 * i < z.size(); ++i) {
    const Index l = offsets[static_cast<std::size_t>(i)];
    z.segment<2>(2 * i) =
        settings.sensor.measure(rotation(x[2]).transpose() * (x.segment<2>(l) - x.head<2>()));
  }
  return z;
}

/// z − z_predicted of such a stack.
inline Vector textbook_innovation(const EstimatorSettings& settings, const Vector& z,
                                  const Vector& predicted) {
  Vector nu(z.size());
  for (Index i = 0; i < z.size(); i += 2) {
    nu.segment<2>(i) = settings.sensor.innovation(Eigen::Vector2d(z.segment<2>(i)),
                                                  Eigen::Vector2d(predicted.segment<2>(i)));
  }
  return nu;
}

/// ∂h/∂x there by differences.
inline Matrix textbook_jacobian(const EstimatorSettings& settings, const Vector& x,
                                std::span<const Index> offsets) {
  const Vector here = textbook_measurement(settings, x, offsets);
  return numerical_jacobian(
      [&](const Vector& at) {
        return textbook_innovation(settings, textbook_measurement(settings, at, offsets), here);
      },
      x);
}

/// Covariance of a stack of measurements.
inline Matrix textbook_noise(const EstimatorSettings& settings, Index m) {
  Matrix R = Matrix::Zero(m, m);
  for (Index i = 0; i < m; i += 2) R.block<2, 2>(i, i) = settings.R;
  return R;
}

inline std::vector<Index> offsets_of(const SlamEstimator& filter,
                                     const EstimatorTour::Observations& observations) {
  std::vector<Index> offsets;
  for (const auto& observation : observations) offsets.push_back(filter.offset_of(observation.landmark));
  return offsets;
}

/// The observations of landmarks that a filter has, and the others.
inline std::pair<EstimatorTour::Observations, EstimatorTour::Observations> known_and_fresh(
    const SlamEstimator& filter, const EstimatorTour::Observations& observations) {
  std::pair<EstimatorTour::Observations, EstimatorTour::Observations> parts;
  for (const auto& observation : observations) {
    (filter.offset_of(observation.landmark) >= 0 ? parts.first : parts.second).push_back(observation);
  }
  return parts;
}

inline Vector stacked(const EstimatorTour::Observations& observations) {
  Vector z(2 * std::ssize(observations));
  for (Index i = 0; 2 * i < z.size(); ++i) z.segment<2>(2 * i) = observations[static_cast<std::size_t>(i)].z;
  return z;
}

/// Kalman's correction, δ = K ν and Joseph's form.
struct TextbookCorrection {
  Matrix S, K, P;
  Vector delta;
  double nis;

  TextbookCorrection(const Matrix& prior, const Matrix& H, const Vector& nu, const Matrix& R)
      : S(H * prior * H.transpose() + R), K(S.llt().solve(H * prior).transpose()), delta(K * nu) {
    const Matrix T = Matrix::Identity(prior.rows(), prior.rows()) - K * H;
    P = T * prior * T.transpose() + K * R * K.transpose();
    nis = nu.dot(S.llt().solve(nu));
  }
};

/// A warm filter after a motion, and the observations that come next.
struct BeforeUpdate {
  Vector x;
  Matrix P;
  EstimatorTour::Observations observations;
  std::vector<Index> offsets;  ///< −1 of landmarks that the filter has not

  BeforeUpdate(EstimatorTour& tour, SlamEstimator& filter, std::initializer_list<int> numbers) {
    tour.warm(filter);
    filter.predict(tour.drive(), tour.truth());
    x = filter.state();
    P = whole_covariance(filter);
    observations = tour.see(numbers);
    offsets = offsets_of(filter, observations);
  }

  Vector innovation(const EstimatorSettings& settings) const {
    return textbook_innovation(settings, stacked(observations), textbook_measurement(settings, x, offsets));
  }
};

/// Corrects x and P by observations of landmarks that are there, with the Jacobian at another point.
inline void textbook_correct(const EstimatorSettings& settings,
                             const EstimatorTour::Observations& observations, std::span<const Index> offsets,
                             const Vector& point, Vector& x, Matrix& P) {
  const Vector nu =
      textbook_innovation(settings, stacked(observations), textbook_measurement(settings, x, offsets));
  const TextbookCorrection corrected(P, textbook_jacobian(settings, point, offsets), nu,
                                     textbook_noise(settings, nu.size()));
  x += corrected.delta;
  P = corrected.P;
}

/// diag(F, I) P diag(F, I)ᵀ + diag(Q_r, 0).
inline Matrix textbook_prediction(const Matrix& P, const Matrix& F, const Matrix& Q_r) {
  Matrix whole = Matrix::Identity(P.rows(), P.rows());
  whole.topLeftCorner(3, 3) = F;
  Matrix moved = whole * P * whole.transpose();
  moved.topLeftCorner(3, 3) += Q_r;
  return moved;
}

/// Of a motion by `u` from a pose: ∂f/∂x and ∂f/∂u by differences, with the heading not wrapped.
inline Matrix textbook_motion_jacobian(const PlanarModel& model, const Pose& pose, const Control& u) {
  const Pose here = model.move(pose, u).pose;
  return numerical_jacobian(
      [&](const Vector& at) {
        Pose moved = model.move(Pose(at), u).pose - here;
        moved[2] = wrap_angle(moved[2]);
        return moved;
      },
      pose);
}

inline Matrix textbook_control_jacobian(const PlanarModel& model, const Pose& pose, const Control& u) {
  const Pose here = model.move(pose, u).pose;
  return numerical_jacobian(
      [&](const Vector& at) {
        Pose moved = model.move(pose, Control(at)).pose - here;
        moved[2] = wrap_angle(moved[2]);
        return moved;
      },
      u);
}

/// Where an observation at z from a pose places a landmark.
inline Vector textbook_place(const EstimatorSettings& settings, const Vector& pose, const Vector& z) {
  return pose.head<2>() + rotation(pose[2]) * settings.sensor.locate(Eigen::Vector2d(z));
}

/// P with a landmark placed by δl = J_r δx_r + J_z w.
inline Matrix textbook_augmented(const Matrix& P, const Matrix& J_r, const Matrix& J_z,
                                 const Eigen::Matrix2d& R) {
  const Index n = P.rows();
  Matrix T = Matrix::Zero(n + 2, n);
  T.topRows(n).setIdentity();
  T.bottomLeftCorner(2, 3) = J_r;
  Matrix augmented = T * P * T.transpose();
  augmented.bottomRightCorner<2, 2>() += J_z * R * J_z.transpose();
  return augmented;
}

/// Adds the landmark of an observation to x and P, its Jacobian that of a turn about another point; where it
/// stands.
inline Point textbook_start(const EstimatorSettings& settings, const Eigen::Vector2d& seen, const Point& turn,
                            Vector& x, Matrix& P) {
  const Vector pose = x.head<3>(), z = seen;
  const Point l = textbook_place(settings, pose, z);
  Matrix J_r = Matrix::Identity(2, 3);
  J_r.col(2) = quarter_turn(l - turn);
  const Matrix J_z =
      numerical_jacobian([&](const Vector& at) { return textbook_place(settings, pose, at); }, z);
  P = textbook_augmented(P, J_r, J_z, settings.R);
  x.conservativeResize(x.size() + 2);
  x.tail<2>() = l;
  return l;
}

}  // namespace credence::internal
