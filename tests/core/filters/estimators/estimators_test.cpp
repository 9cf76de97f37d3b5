#include "core/filters/estimators/estimators.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "core/manifold/angle.h"
#include "core/manifold/rotation.h"

namespace credence {
namespace {

using Seen = std::vector<Observation<PlanarModel>>;

/// A vehicle that drives a circle among landmarks, its odometry and sensor noisy; made of fixed numbers.
class Drive {
 public:
  explicit Drive(LandmarkSensorKind kind, double turn_rate, double turn_std, double position_std = 0.1) {
    settings_.model.dt_s = 1.0;
    settings_.sensor.kind = kind;
    control_std_ << 0.02, turn_std;
    settings_.Q = control_std_.cwiseAbs2().asDiagonal();
    std_ << 0.1, kind == LandmarkSensorKind::relative_position ? 0.1 : 0.02;
    settings_.R = std_.cwiseAbs2().asDiagonal();
    settings_.landmarks = 6;
    initial_std_ << position_std, position_std, turn_std;
    control_ << 0.3, turn_rate;
    for (int i = 0; i < 6; ++i)
      landmarks_.emplace_back(4.0 * std::cos(1.1 * i), 1.0 + 3.5 * std::sin(1.1 * i));
  }

  EstimatorSettings& settings() { return settings_; }
  const std::vector<Point>& landmarks() const { return landmarks_; }
  PlanarTruth truth() const { return {before_, now_, landmarks_}; }

  /// The same noise at every call with the same seed.
  Pose start(unsigned seed) {
    random_.seed(seed);
    before_ = now_ = Pose(0.5, -1.0, 0.3);
    Pose estimate = now_ + initial_std_.cwiseProduct(Pose(normal(), normal(), normal()));
    return estimate;
  }
  Eigen::Matrix3d initial_covariance() const { return initial_std_.cwiseAbs2().asDiagonal(); }

  Control move() {
    before_ = now_;
    now_ = settings_.model.move(now_, control_).pose;
    return control_ + control_std_.cwiseProduct(Control(normal(), normal()));
  }

  Seen see() {
    Seen seen;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector2d noise(normal(), normal());
      const Point& l = landmarks_[static_cast<std::size_t>(i)];
      if ((l - now_.head<2>()).norm() > 4.5) continue;
      Eigen::Vector2d z = settings_.sensor.measure(rotation(now_[2]).transpose() * (l - now_.head<2>()));
      seen.push_back({i, z + std_.cwiseProduct(noise)});
    }
    return seen;
  }

 private:
  double normal() {  // Box-Muller of a generator that is the same everywhere
    const double u = (static_cast<double>(random_()) + 0.5) / 4294967296.0;
    const double v = (static_cast<double>(random_()) + 0.5) / 4294967296.0;
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * v);
  }

  EstimatorSettings settings_;
  Control control_std_, control_;
  Eigen::Vector2d std_;
  Pose initial_std_, before_, now_;
  std::vector<Point> landmarks_;
  std::mt19937 random_;
};

/// Steps of one filter; takes what is there after each.
template <class Take>
void follow(SlamEstimator& filter, Drive& drive, unsigned seed, int steps, Take take) {
  filter.reset(drive.start(seed), drive.initial_covariance());
  for (int k = 1; k <= steps; ++k) {
    const Control u = drive.move();
    filter.predict(u, drive.truth());
    const UpdateResult result = filter.update(drive.see(), drive.truth());
    ASSERT_TRUE(result.ok) << k;
    take(k, result);
  }
}

Matrix full(const MatrixRef& P) { return P.selfadjointView<Eigen::Lower>(); }

// A known heading makes motion and relative position linear; the Kalman filter with its dense textbook
// formulas is then what every estimator must be.
TEST(Estimators, AllAreTheKalmanFilterWhereTheWorldIsLinear) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    for (const double alpha : {1e-3, 1.0}) {
      if (kind.name != "ukf" && alpha < 1.0) continue;
      Drive drive(LandmarkSensorKind::relative_position, 0.0, 0.0);
      drive.settings().sigma_spread = alpha;
      const auto filter = kind.make(drive.settings());
      Drive same(LandmarkSensorKind::relative_position, 0.0, 0.0);
      Vector x = same.start(3).head<2>();
      Matrix P = same.initial_covariance().topLeftCorner<2, 2>();
      std::vector<int> order;
      const Eigen::Matrix2d R = rotation(0.3), Rt = R.transpose();
      // The innovations of a sigma filter with a spread of 1e-3 lose six digits.
      const double tolerance = alpha < 1.0 ? 1e-8 : 1e-10;
      follow(*filter, drive, 3, 60, [&](int k, const UpdateResult& result) {
        const Control u = same.move();
        x.head<2>() += u[0] * R.col(0);
        P.topLeftCorner<2, 2>() += drive.settings().Q(0, 0) * R.col(0) * R.col(0).transpose();
        const Seen seen = same.see();
        Seen known, fresh;
        for (const auto& o : seen) {
          (std::ranges::find(order, o.landmark) != order.end() ? known : fresh).push_back(o);
        }
        const Index m = 2 * std::ssize(known), n = x.size();
        Matrix H = Matrix::Zero(m, n);
        Vector nu(m);
        for (Index i = 0; 2 * i < m; ++i) {
          const auto& o = known[static_cast<std::size_t>(i)];
          const Index l = 2 + 2 * (std::ranges::find(order, o.landmark) - order.begin());
          H.block<2, 2>(2 * i, 0) = -Rt;
          H.block<2, 2>(2 * i, l) = Rt;
          nu.segment<2>(2 * i) = o.z - Rt * (x.segment<2>(l) - x.head<2>());
        }
        if (m > 0) {
          const Matrix S = H * P * H.transpose() + 0.01 * Matrix::Identity(m, m);
          const Matrix K = P * H.transpose() * S.inverse();
          EXPECT_NEAR(result.nis, nu.dot(S.inverse() * nu), 1e-7) << kind.name;
          x += K * nu;
          P = ((Matrix::Identity(n, n) - K * H) * P).eval();
        }
        for (const auto& o : fresh) {
          const Index at = x.size();
          Matrix T = Matrix::Zero(at + 2, at);
          T.topRows(at).setIdentity();
          T.block<2, 2>(at, 0).setIdentity();
          x = (T * x).eval();
          x.tail<2>() += R * o.z;
          P = (T * P * T.transpose()).eval();
          P.bottomRightCorner<2, 2>() += 0.01 * Eigen::Matrix2d::Identity();
          order.push_back(o.landmark);
        }
        const Index now = x.size();
        ASSERT_EQ(filter->size(), now + 1) << kind.name;
        const Matrix P_filter = full(filter->covariance());
        const Vector x_filter = filter->state();
        EXPECT_LT((x_filter.head<2>() - x.head<2>()).cwiseAbs().maxCoeff(), tolerance) << kind.name << k;
        EXPECT_LT((x_filter.tail(now - 2) - x.tail(now - 2)).cwiseAbs().maxCoeff(), tolerance)
            << kind.name << k;
        EXPECT_DOUBLE_EQ(x_filter[2], 0.3) << kind.name;
        EXPECT_LT((P_filter.topLeftCorner<2, 2>() - P.topLeftCorner<2, 2>()).norm(), tolerance)
            << kind.name << k;
        EXPECT_LT(
            (P_filter.bottomRightCorner(now - 2, now - 2) - P.bottomRightCorner(now - 2, now - 2)).norm(),
            tolerance)
            << kind.name << k;
        EXPECT_LT((P_filter.block(3, 0, now - 2, 2) - P.block(2, 0, now - 2, 2)).norm(), tolerance)
            << kind.name << k;
        EXPECT_LT(P_filter.row(2).norm() + P_filter.col(2).norm(), 1e-15) << kind.name;
      });
    }
  }
}

// With range and bearing the plain EKF is the one that the planar world has had all along.
TEST(Estimators, EkfIsEkfSlam) {
  Drive drive(LandmarkSensorKind::range_bearing, 0.05, 0.03);
  Drive same(LandmarkSensorKind::range_bearing, 0.05, 0.03);
  const auto filter = make_estimator("ekf", drive.settings());
  EkfSlam<PlanarModel> ekf(drive.settings().model, drive.settings().Q, drive.settings().R);
  ekf.reset(same.start(5), same.initial_covariance());
  follow(*filter, drive, 5, 80, [&](int k, const UpdateResult& result) {
    ekf.predict(same.move());
    const UpdateResult expected = ekf.update(same.see());
    ASSERT_EQ(result.dof, expected.dof);
    EXPECT_EQ(result.initialised, expected.initialised);
    EXPECT_NEAR(result.nis, expected.nis, 1e-9);
    EXPECT_NEAR(result.trace_prior, expected.trace_prior, 1e-12);
    EXPECT_LT((filter->state() - ekf.state()).norm(), 1e-11) << k;
    EXPECT_LT((full(filter->covariance()) - ekf.covariance()).norm(), 1e-12) << k;
    if (result.dof == 0) return;
    const Matrix K = filter->gain();
    EXPECT_LT((K - Matrix(ekf.gain()).topRows(K.rows())).norm(), 1e-10) << k;
  });
}

// Small noise: all linearise at nearly the same points, and in the chart x̂ − x they agree to first order.
TEST(Estimators, AgreeWhereTheNoiseIsSmall) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    for (const LandmarkSensorKind sensor :
         {LandmarkSensorKind::relative_position, LandmarkSensorKind::range_bearing}) {
      Drive drive(sensor, 0.05, 1e-6, 1e-6);
      for (Eigen::Matrix2d* M : {&drive.settings().Q, &drive.settings().R}) *M *= 1e-10;
      Drive same = drive;
      const auto filter = kind.make(drive.settings());
      const auto ideal = make_estimator("ideal", drive.settings());
      // Noise as drawn is 1e5 times too large for these covariances: take the exact readings instead.
      const auto go = [](SlamEstimator& f, Drive& d) {
        f.reset(d.start(1), d.initial_covariance());
        f.reset(d.truth().now, d.initial_covariance());
        for (int k = 0; k < 30; ++k) {
          d.move();
          f.predict(Control(0.3, 0.05), d.truth());
          Seen seen = d.see();
          for (auto& o : seen) {
            const Point l = d.landmarks()[static_cast<std::size_t>(o.landmark)];
            o.z = d.settings().sensor.measure(rotation(d.truth().now[2]).transpose() *
                                              (l - d.truth().now.head<2>()));
          }
          ASSERT_TRUE(f.update(seen, d.truth()).ok);
        }
      };
      go(*filter, drive);
      go(*ideal, same);
      EXPECT_LT((filter->state() - ideal->state()).norm(), 1e-8) << kind.name;
      const Eigen::Matrix3d P = filter->plane_pose_covariance(), expected = ideal->plane_pose_covariance();
      EXPECT_LT((P - expected).norm(), 1e-6 * expected.norm()) << kind.name;
    }
  }
}

// The invariant filter does not know where the origin is: a turned and shifted world gives turned and shifted
// estimates, the same innovations, and the same NEES.
TEST(Estimators, InvariantFilterIsInvariant) {
  Drive drive(LandmarkSensorKind::relative_position, 0.05, 0.03);
  const auto filter = make_estimator("invariant", drive.settings());
  const auto moved = make_estimator("invariant", drive.settings());
  const double turn = 2.1;
  const Eigen::Vector2d shift(30.0, -7.0);
  const auto there = [&](Pose p) {
    p << rotation(turn) * p.head<2>() + shift, wrap_angle(p[2] + turn);
    return p;
  };
  std::vector<Point> landmarks;
  for (const Point& l : drive.landmarks()) landmarks.emplace_back(rotation(turn) * l + shift);
  Pose start = drive.start(8);
  filter->reset(start, drive.initial_covariance());
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T.topLeftCorner<2, 2>() = rotation(turn);
  moved->reset(there(start), T * drive.initial_covariance() * T.transpose());
  for (int k = 0; k < 60; ++k) {
    const Control u = drive.move();
    const PlanarTruth truth = drive.truth();
    const PlanarTruth truth_there{there(truth.before), there(truth.now), landmarks};
    const Seen seen = drive.see();
    filter->predict(u, truth);
    moved->predict(u, truth_there);
    const UpdateResult a = filter->update(seen, truth), b = moved->update(seen, truth_there);
    EXPECT_NEAR(a.nis, b.nis, 1e-9);
    EXPECT_LT((there(filter->state().head<3>()) - moved->state().head<3>()).norm(), 1e-10);
    Vector e(filter->size()), f(filter->size());
    filter->error(truth, e);
    moved->error(truth_there, f);
    EXPECT_NEAR(e.dot(full(filter->covariance()).inverse() * e),
                f.dot(full(moved->covariance()).inverse() * f), 1e-6);
  }
}

// A correction by a global turn and shift of the plane is no information: log of the error changes by Ad
// only.
TEST(Estimators, InvariantErrorIsTheLogarithm) {
  Drive drive(LandmarkSensorKind::relative_position, 0.05, 0.03);
  const auto filter = make_estimator("invariant", drive.settings());
  follow(*filter, drive, 4, 20, [](int, const UpdateResult&) {});
  const PlanarTruth truth = drive.truth();
  Vector e(filter->size());
  filter->error(truth, e);
  // exp(e) X = X̂
  const Eigen::Matrix2d R = rotation(e[2]), V = exponential_factor(e[2]);
  EXPECT_LT((R * truth.now.head<2>() + V * e.head<2>() - filter->state().head<2>()).norm(), 1e-13);
  for (Index j = 3; j < filter->size(); j += 2) {
    const int number = filter->landmarks()[static_cast<std::size_t>(j - 3) / 2];
    const Point& l = truth.landmarks[static_cast<std::size_t>(number)];
    EXPECT_LT((R * l + V * e.segment<2>(j) - filter->state().segment<2>(j)).norm(), 1e-13);
  }
}

// The Gauss-Newton minimum has no gradient: K-free check of the iterated correction.
TEST(Estimators, IteratedCorrectionIsTheMinimum) {
  Drive drive(LandmarkSensorKind::range_bearing, 0.05, 0.05);
  const auto filter = make_estimator("iterated", drive.settings());
  filter->reset(drive.start(2), drive.initial_covariance());
  for (int k = 0; k < 6; ++k) {
    const Control u = drive.move();
    filter->predict(u, drive.truth());
    filter->update(drive.see(), drive.truth());
  }
  const Control u = drive.move();
  filter->predict(u, drive.truth());
  const Vector prior = filter->state();
  const Matrix P = full(filter->covariance());
  const std::vector<int> order(filter->landmarks().begin(), filter->landmarks().end());
  Seen seen = drive.see();
  std::erase_if(seen, [&](const auto& o) { return std::ranges::find(order, o.landmark) == order.end(); });
  ASSERT_GE(seen.size(), 2U);
  filter->update(seen, drive.truth());
  const Vector x = filter->state();
  const auto cost = [&](const Vector& at) {
    const Vector d = at - prior;
    double sum = d.dot(P.inverse() * d);
    for (const auto& o : seen) {
      const Index l = 3 + 2 * (std::ranges::find(order, o.landmark) - order.begin());
      const Eigen::Vector2d rho = rotation(at[2]).transpose() * (at.segment<2>(l) - at.head<2>());
      const LandmarkSensor& sensor = drive.settings().sensor;
      const Eigen::Vector2d nu = sensor.innovation(o.z, sensor.measure(rho));
      sum += nu.dot(drive.settings().R.inverse() * nu);
    }
    return sum;
  };
  for (Index i = 0; i < x.size(); ++i) {
    const double h = 1e-5;
    const Vector step = h * Vector::Unit(x.size(), i);
    const double curvature = (cost(x + step) + cost(x - step) - 2.0 * cost(x)) / (h * h);
    EXPECT_LT(std::abs(cost(x + step) - cost(x - step)) / (2.0 * h), 2e-5 * curvature) << i;
  }
}

// A turn of the plane, carried along by the filter's own F and placements, is in the null space of its H,
// where the plain EKF's tells it; no filter tells a shift.
TEST(Estimators, KeepWhatIsUnobservable) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    Drive drive(LandmarkSensorKind::range_bearing, 0.05, 0.05);
    const auto filter = kind.make(drive.settings());
    Eigen::Matrix3d pose = Eigen::Matrix3d::Identity();  // the turn about the start, and two shifts
    std::vector<Eigen::Matrix<double, 2, 3>> map;
    double turn = 0.0, shift = 0.0;
    follow(*filter, drive, 2, 40, [&](int, const UpdateResult& result) {
      pose = filter->motion_jacobian() * pose;
      if (result.dof > 0) {
        Matrix N(std::ssize(filter->seen()), 3);
        N.topRows<3>() = pose;
        for (Index j = 3; j < N.rows(); j += 2) {
          N.middleRows<2>(j) =
              map[static_cast<std::size_t>(filter->seen()[static_cast<std::size_t>(j)] - 3) / 2];
        }
        const Matrix told = filter->measurement_jacobian() * N;
        shift = std::max(shift, told.leftCols(2).cwiseAbs().maxCoeff());
        turn = std::max(turn, told.col(2).cwiseAbs().maxCoeff());
      }
      for (const auto& J_r : filter->placements()) map.emplace_back(J_r * pose);
    });
    EXPECT_LT(shift, 1e-8) << kind.name;
    const bool keeps = kind.name != "ekf" && kind.name != "iterated" && kind.name != "ukf";
    if (keeps) {
      EXPECT_LT(turn, 1e-12) << kind.name;
    } else {
      EXPECT_GT(turn, 1e-3) << kind.name;
    }
  }
}

TEST(Estimators, BadInputIsRefused) {
  Drive drive(LandmarkSensorKind::relative_position, 0.0, 0.01);
  EXPECT_THROW(make_estimator("magic", drive.settings()), std::invalid_argument);
  const auto filter = make_estimator("ekf", drive.settings());
  filter->reset(Pose::Zero(), drive.initial_covariance());
  const Seen far{{6, {1.0, 1.0}}}, negative{{-1, {1.0, 1.0}}};
  EXPECT_THROW(filter->update(far, drive.truth()), std::invalid_argument);
  EXPECT_THROW(filter->update(negative, drive.truth()), std::invalid_argument);
  drive.settings().sigma_spread = 0.0;
  EXPECT_THROW(make_estimator("ukf", drive.settings()), std::invalid_argument);
  drive.settings().sigma_spread = 1.0;
  drive.settings().landmarks = -1;
  EXPECT_THROW(make_estimator("ekf", drive.settings()), std::invalid_argument);
}

// S that is not positive definite is data: nothing changes.
TEST(Estimators, AFactorisationThatFailsIsSaid) {
  for (const EstimatorKind& kind : estimator_kinds()) {
    Drive drive(LandmarkSensorKind::relative_position, 0.05, 0.03);
    drive.settings().R *= -1.0;
    const auto filter = kind.make(drive.settings());
    filter->reset(drive.start(1), drive.initial_covariance());
    const Control u = drive.move();
    filter->predict(u, drive.truth());
    filter->update(drive.see(), drive.truth());
    const Vector before = filter->state();
    const Seen seen = drive.see();
    EXPECT_FALSE(filter->update(seen, drive.truth()).ok) << kind.name;
    EXPECT_EQ(Vector(filter->state()), before) << kind.name;
  }
}

}  // namespace
}  // namespace credence
