// What `credence run` costs in the plane, all evidence included, and a careful plain Eigen program that
// simulates the same world and takes the same ten quantities a step, but makes no further tests.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/evidence/sums/evidence_collect.h"
#include "core/linear_algebra/cholesky.h"
#include "core/manifold/angle.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "montecarlo/worlds/planar/planar_simulation.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

constexpr Index kRunSteps = 100;

/// The scenario planar_loop with another map, and inflation of the map or none.
Scenario planar_loop(Index landmarks, bool inflated, std::int64_t runs) {
  Scenario scenario = starting_scenario("planar");
  scenario.world.sensor_range = 12.0;
  scenario.world.landmarks = landmarks;
  scenario.study.steps = kRunSteps;
  scenario.study.runs = runs;
  if (inflated) scenario.filter.inflation = FilterInflation::map;
  return scenario;
}

/// EKF-SLAM as one writes it who minds the cost: pose blocks of fixed size, a map of any, the update
/// P − K S Kᵀ of all landmarks at once (with K S = P Hᵀ), NEES by a Cholesky factor, and all matrices
/// allocated once.
class CarefulProgram {
 public:
  explicit CarefulProgram(const Scenario& scenario)
      : world_(make_planar_world(scenario)),
        noise_(PlanarNoise::of(scenario)),
        Q_(noise_.control_std.cwiseAbs2().asDiagonal()),
        R_(noise_.measurement_std.cwiseAbs2().asDiagonal()),
        most_(3 + 2 * world_.states()),
        x_(most_),
        error_(most_),
        nu_(most_),
        P_(most_, most_),
        root_(most_, most_),
        PHt_(most_, most_),
        S_(most_, most_),
        Kt_(most_, most_),
        sums_(world_.controls.size()) {}

  void run() {
    truth_ = world_.start;
    n_ = 3;
    place_.assign(world_.landmarks.size(), -1);
    order_.clear();
    x_.head<3>() = truth_ + noise_.initial_std.cwiseProduct(Pose(normal(), normal(), normal()));
    P_.topLeftCorner<3, 3>() = noise_.initial_covariance();
    for (std::size_t k = 0; k < world_.controls.size(); ++k) step(k);
  }

  double anees() const { return sums_.back()[0].mean / static_cast<double>(n_); }

 private:
  struct Moments {
    double count = 0.0, mean = 0.0, squares = 0.0;
    void add(double x) {
      const double delta = x - mean;
      mean += delta / ++count;
      squares += delta * (x - mean);
    }
  };
  struct Seen {
    std::size_t landmark;
    RangeBearing z;
  };

  double normal() { return normal_(generator_); }

  void predict(const Control& u) {
    const double dt = world_.dt_s, c = std::cos(x_[2]), s = std::sin(x_[2]);
    x_.head<3>() += dt * Pose(u[0] * c, u[0] * s, u[1]);
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    F(0, 2) = -dt * u[0] * s;
    F(1, 2) = dt * u[0] * c;
    Eigen::Matrix<double, 3, 2> G;
    G << dt * c, 0.0, dt * s, 0.0, 0.0, dt;
    P_.topLeftCorner<3, 3>() = (F * P_.topLeftCorner<3, 3>() * F.transpose() + G * Q_ * G.transpose()).eval();
    for (Index j = 3; j < n_; ++j) {
      const Eigen::Vector3d column = F * P_.col(j).head<3>();
      P_.col(j).head<3>() = column;
      P_.row(j).head<3>() = column.transpose();
    }
  }

  void observe(const Control& u) {
    const Control noisy = u + noise_.control_std.cwiseProduct(Control(normal(), normal()));
    truth_ += world_.dt_s * Pose(noisy[0] * std::cos(truth_[2]), noisy[0] * std::sin(truth_[2]), noisy[1]);
    seen_.clear();
    for (std::size_t i = 0; i < world_.landmarks.size(); ++i) {
      const Point d = world_.landmarks[i] - truth_.head<2>();
      const double range = d.norm();
      if (range > world_.sensor_range_m) continue;
      const double bearing = std::atan2(d[1], d[0]) - truth_[2];
      seen_.push_back({i, RangeBearing(range + noise_.measurement_std[0] * normal(),
                                       wrap_angle(bearing + noise_.measurement_std[1] * normal()))});
    }
  }

  /// Returns the NIS.
  double update() {
    Index m = 0;
    for (const Seen& seen : seen_) {
      const Index at = place_[seen.landmark];
      if (at < 0) continue;
      const Point d = x_.segment<2>(at) - x_.head<2>();
      const double q = d.squaredNorm(), r = std::sqrt(q);
      Eigen::Matrix2d H_l;
      H_l << d[0] / r, d[1] / r, -d[1] / q, d[0] / q;
      Eigen::Matrix<double, 2, 3> H_r;
      H_r << -H_l, Eigen::Vector2d(0.0, -1.0);
      nu_[m] = seen.z[0] - r;
      nu_[m + 1] = wrap_angle(seen.z[1] - std::atan2(d[1], d[0]) + x_[2]);
      PHt_.block(0, m, n_, 2).noalias() = P_.block(0, 0, n_, 3) * H_r.transpose();
      PHt_.block(0, m, n_, 2).noalias() += P_.block(0, at, n_, 2) * H_l.transpose();
      rows_.resize(std::max(rows_.size(), static_cast<std::size_t>(m / 2 + 1)));
      rows_[static_cast<std::size_t>(m / 2)] = {at, H_r, H_l};
      m += 2;
    }
    if (m == 0) return 0.0;
    for (Index i = 0; i < m; i += 2) {
      const Row& row = rows_[static_cast<std::size_t>(i / 2)];
      S_.block(i, 0, 2, m).noalias() = row.H_r * PHt_.block(0, 0, 3, m);
      S_.block(i, 0, 2, m).noalias() += row.H_l * PHt_.block(row.at, 0, 2, m);
      S_.block<2, 2>(i, i) += R_;
    }
    Eigen::Ref<Matrix> S(S_.topLeftCorner(m, m));
    const Eigen::LLT<Eigen::Ref<Matrix>> factor(S);
    auto Kt = Kt_.topLeftCorner(m, n_);
    const auto PHt = PHt_.topLeftCorner(n_, m);
    Kt = PHt.transpose();
    factor.solveInPlace(Kt);
    x_.head(n_).noalias() += Kt.transpose() * nu_.head(m);
    x_[2] = wrap_angle(x_[2]);
    P_.topLeftCorner(n_, n_).noalias() -= Kt.transpose() * PHt.transpose();
    auto whitened = nu_.head(m);
    factor.matrixL().solveInPlace(whitened);
    return whitened.squaredNorm();
  }

  void initialise() {
    for (const Seen& seen : seen_) {
      if (place_[seen.landmark] >= 0) continue;
      const double angle = x_[2] + seen.z[1], c = std::cos(angle), s = std::sin(angle), r = seen.z[0];
      Eigen::Matrix<double, 2, 3> J_r;
      J_r << 1.0, 0.0, -r * s, 0.0, 1.0, r * c;
      Eigen::Matrix2d J_z;
      J_z << c, -r * s, s, r * c;
      x_.segment<2>(n_) = x_.head<2>() + r * Point(c, s);
      P_.block(n_, 0, 2, n_).noalias() = J_r * P_.block(0, 0, 3, n_);
      P_.block(0, n_, n_, 2) = P_.block(n_, 0, 2, n_).transpose();
      P_.block<2, 2>(n_, n_) = J_r * P_.topLeftCorner<3, 3>() * J_r.transpose() + J_z * R_ * J_z.transpose();
      place_[seen.landmark] = n_;
      order_.push_back(seen.landmark);
      n_ += 2;
    }
  }

  void step(std::size_t k) {
    observe(world_.controls[k]);
    predict(world_.controls[k]);
    const double trace_prior = P_.diagonal().head(n_).sum();
    const double nis = update();
    initialise();
    error_.head<3>() = x_.head<3>() - truth_;
    error_[2] = wrap_angle(error_[2]);
    double map_error = 0.0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Index at = 3 + 2 * static_cast<Index>(i);
      error_.segment<2>(at) = x_.segment<2>(at) - world_.landmarks[order_[i]];
      map_error += error_.segment<2>(at).squaredNorm();
    }
    const double position_error = error_.head<2>().squaredNorm(), heading_error = error_[2] * error_[2];
    const double vehicle =
        Eigen::LLT<Eigen::Matrix3d>(P_.topLeftCorner<3, 3>()).matrixL().solve(error_.head<3>()).squaredNorm();
    root_.topLeftCorner(n_, n_) = P_.topLeftCorner(n_, n_);
    Eigen::Ref<Matrix> root(root_.topLeftCorner(n_, n_));
    const Eigen::LLT<Eigen::Ref<Matrix>> factor(root);
    auto whitened = error_.head(n_);
    factor.matrixL().solveInPlace(whitened);
    const double trace = P_.diagonal().head(n_).sum(), position = P_(0, 0) + P_(1, 1);
    const std::array<double, 10> values = {whitened.squaredNorm(),
                                           nis,
                                           vehicle,
                                           trace_prior,
                                           trace,
                                           position,
                                           trace - position - P_(2, 2),
                                           position_error,
                                           heading_error,
                                           map_error / std::max(1.0, static_cast<double>(order_.size()))};
    for (std::size_t i = 0; i < values.size(); ++i) sums_[k][i].add(values[i]);
  }

  struct Row {
    Index at;
    Eigen::Matrix<double, 2, 3> H_r;
    Eigen::Matrix2d H_l;
  };

  PlanarWorld world_;
  PlanarNoise noise_;
  Eigen::Matrix2d Q_, R_;
  Index most_, n_ = 3;
  Pose truth_;
  Vector x_, error_, nu_;
  Matrix P_, root_, PHt_, S_, Kt_;
  std::vector<Index> place_;
  std::vector<std::size_t> order_;
  std::vector<Seen> seen_;
  std::vector<Row> rows_;
  std::vector<std::array<Moments, 10>> sums_;
  std::mt19937_64 generator_{1};
  std::normal_distribution<double> normal_;
};

/// Argument: landmarks. Items are runs of 100 steps.
void careful_planar(benchmark::State& state) {
  CarefulProgram program(planar_loop(state.range(0), false, 1));
  for (auto _ : state) program.run();
  state.counters["anees"] = program.anees();
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(careful_planar)->Arg(10)->Arg(50)->Arg(100)->Arg(300)->Unit(benchmark::kMillisecond);

/// Arguments: landmarks, inflation of the map, runs. What `credence run` computes before it judges, with one
/// thread; items are runs of 100 steps.
void study_planar(benchmark::State& state) {
  const Scenario scenario = planar_loop(state.range(0), state.range(1) != 0, state.range(2));
  const auto experiment = make_experiment(scenario);
  const std::int64_t runs = scenario.study.runs;
  EngineOptions options;
  options.threads = 1;
  const Index n = 3 + 2 * scenario.world.landmarks;
  const std::int64_t looked_at = evidence_runs(n, kRunSteps, runs);
  for (auto _ : state) {
    EvidenceCollector evidence(*experiment, looked_at);
    StudyTask task{"", experiment.get(), runs};
    task.play = [&](std::int64_t first, std::int64_t count) { return evidence.play(first, count); };
    benchmark::DoNotOptimize(run_studies({&task, 1}, options));
    benchmark::DoNotOptimize(evidence.take(looked_at, options));
  }
  state.SetItemsProcessed(state.iterations() * runs);
}
BENCHMARK(study_planar)->ArgsProduct({{10}, {0, 1}, {200, 20000}})->Unit(benchmark::kMillisecond);
BENCHMARK(study_planar)->ArgsProduct({{50, 100, 300}, {0}, {20}})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace credence::internal
