#include "montecarlo/worlds/plugged/plugged_experiment.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <atomic>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/plugged/model_plug.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Constant velocity, its position measured.
FunctionModel linear_model() {
  FunctionModel model;
  model.f = [](const Vector& x) { return Vector(Eigen::Vector2d(x[0] + 0.5 * x[1], x[1])); };
  model.h = [](const Vector& x) { return Vector(x.head<1>()); };
  model.Q = Eigen::Vector2d(0.01, 0.04).asDiagonal();
  model.R = Matrix::Constant(1, 1, 0.25);
  model.mean = Eigen::Vector2d(0.0, 1.0);
  model.P0 = Eigen::Vector2d(1.0, 0.5).asDiagonal();
  return model;
}

/// The same by hand, with the same arithmetic: a state of its own, an input, and no virtual call.
struct CvState {
  double position = 0.0, velocity = 0.0;
};
Vector minus(const CvState& a, const CvState& b) {
  return Eigen::Vector2d(a.position - b.position, a.velocity - b.velocity);
}

struct CvWorld {
  Prior<CvState> prior() const { return {{0.0, 1.0}, Eigen::Vector2d(1.0, 0.5).asDiagonal()}; }
  CvState initial(NoiseDraw& noise) const {
    const Vector n = noise.normals(2);
    return {n[0], 1.0 + std::sqrt(0.5) * n[1]};
  }
  CvState step(const CvState& x, std::int64_t, NoiseDraw& noise) const {
    const Vector n = noise.normals(2);
    return {x.position + 0.5 * x.velocity + std::sqrt(0.01) * n[0], x.velocity + std::sqrt(0.04) * n[1]};
  }
  double input(const CvState&, std::int64_t, NoiseDraw&) const { return 0.5; }
  std::optional<double> measure(const CvState& x, std::int64_t k, NoiseDraw& noise) const {
    if (k == silent) return std::nullopt;
    return x.position + 0.5 * noise.normal();
  }
  std::int64_t silent = -1;
};

struct NamedWorld : CvWorld {
  RunLayout layout() const { return model_layout({"pose.x", "pose.v"}, {{"gps", 1}}); }
};

struct CvFilter {
  void reset(const CvState& mean, const Matrix& P) {
    x_ = mean;
    P_ = P;
  }
  void predict(double dt) {
    Eigen::Matrix2d F;
    F << 1.0, dt, 0.0, 1.0;
    x_.position += dt * x_.velocity;
    P_ = (F * P_ * F.transpose()).eval();
    P_(0, 0) += 0.01;
    P_(1, 1) += 0.04;
  }
  void update(double z) {
    if (throws) throw std::runtime_error("no fix");
    S_ = P_.topLeftCorner(1, 1) + Matrix::Constant(1, 1, 0.25);
    nu_ = Vector::Constant(1, z - x_.position);
    const Vector K = P_.col(0) / S_(0, 0);
    x_.position += K[0] * nu_[0];
    x_.velocity += K[1] * nu_[0];
    P_ -= K * S_ * K.transpose();
    P_ = (0.5 * (P_ + P_.transpose())).eval();
  }
  const CvState& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  std::vector<Innovation> innovations() const { return {{nu_, S_}}; }

  CvState x_{};
  Matrix P_{}, S_{};
  Vector nu_{};
  bool throws = false;
};

std::vector<TraceStep> steps_of(const Experiment& experiment, std::int64_t run) {
  std::vector<TraceStep> steps;
  experiment.visit(run, [&](const TraceStep& step) { steps.push_back(step); });
  return steps;
}

TEST(PluggedExperiment, ModelAndHandWrittenFilterAgree) {
  const FunctionModel model = linear_model();
  const PluggedExperiment of_model(FunctionWorld(model), [&] { return FunctionEkf(model); }, {.steps = 30});
  const PluggedExperiment by_hand(CvWorld(), [] { return CvFilter(); }, {.steps = 30});
  for (const std::int64_t run : {0, 17}) {
    const auto a = steps_of(of_model, run), b = steps_of(by_hand, run);
    ASSERT_EQ(a.size(), 31U);
    ASSERT_EQ(b.size(), 31U);
    for (std::size_t k = 0; k <= 30; ++k) {
      EXPECT_LT((a[k].error - b[k].error).norm(), 1e-8) << "the Jacobians of one are differences";
      EXPECT_LT((a[k].P - b[k].P).norm(), 1e-8);
      EXPECT_NEAR(a[k].nis, b[k].nis, 1e-7);
    }
  }
  EXPECT_THAT(of_model.problems(), IsEmpty());
  EXPECT_THAT(by_hand.problems(), IsEmpty());
}

TEST(PluggedExperiment, GivesTheSameBitsWithAnyThreads) {
  const PluggedExperiment experiment(CvWorld(), [] { return CvFilter(); }, {.steps = 20, .seed = 4});
  const StudyTask task{.id = "", .experiment = &experiment, .runs = 200};
  const StudyStatistics one = run_studies({&task, 1}, {.threads = 1}).front().statistics;
  const StudyStatistics three = run_studies({&task, 1}, {.threads = 3}).front().statistics;
  EXPECT_EQ(one, three);
  // E[NEES] = 2, standard error 2/√200 of each of 20 correlated steps: 6 of them.
  for (const StepStatistics& step : one.steps) {
    EXPECT_NEAR(step[Quantity::nees].mean, 2.0, 6.0 * 2.0 / std::sqrt(200.0));
    EXPECT_EQ(step.nis_dof, 200);
  }
}

/// The monobot of a scenario, as someone would write it who knows nothing of ours.
struct Monobot {
  Prior<Vector> prior() const { return {Vector::Zero(3), Matrix::Identity(3, 3)}; }
  Vector initial(NoiseDraw& noise) const { return noise.normals(3); }
  Vector step(Vector x, std::int64_t, NoiseDraw& noise) const {
    x[0] += std::sqrt(0.1) * noise.normal();
    return x;
  }
  Vector measure(const Vector& x, std::int64_t, NoiseDraw& noise) const {
    return Vector(x.tail<2>().array() - x[0]) + std::sqrt(0.1) * noise.normals(2);
  }
};

struct MonobotFilter {
  void reset(const Vector& mean, const Matrix& P) {
    x = mean;
    covariance_ = P;
  }
  void predict() { covariance_(0, 0) += believed_process; }
  void update(const Vector& z) {
    Matrix H(2, 3);
    H << -1.0, 1.0, 0.0, -1.0, 0.0, 1.0;
    nu = z - H * x;
    S = H * covariance_ * H.transpose() + 0.1 * Matrix::Identity(2, 2);
    const Matrix K = covariance_ * H.transpose() * S.inverse();
    x += K * nu;
    covariance_ = (covariance_ - K * S * K.transpose()).eval();
    covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  }
  const Vector& state() const { return x; }
  const Matrix& covariance() const { return covariance_; }
  const Vector& innovation() const { return nu; }
  const Matrix& innovation_covariance() const { return S; }

  double believed_process = 0.1;
  Vector x{}, nu{};
  Matrix covariance_{}, S{};
};

TEST(PluggedExperiment, IsTheBuiltInExperimentOfTheSameWorld) {
  for (const double scale : {1.0, 0.3}) {
    const Scenario scenario = load_scenario_text(
        fmt::format("[world]\nmodel = \"monobot\"\nlandmarks = 2\n[study]\nruns = 128\nsteps = 50\nseed = "
                    "9\n[filter]\nprocess_scale = {:f}\n",
                    scale),
        "scenario");
    const auto built_in = make_experiment(scenario);
    const PluggedExperiment plugged(Monobot(),
                                    [scale] { return MonobotFilter{.believed_process = 0.1 * scale}; },
                                    {.steps = 50, .seed = 9, .noise_group = noise_group(scenario)});
    const StudyStatistics wanted = built_in->run_chunk(64, 64), got = plugged.run_chunk(64, 64);
    for (std::size_t k = 0; k < 50; ++k) {
      const StepStatistics &a = wanted.steps[k], &b = got.steps[k];
      EXPECT_NEAR(b[Quantity::nees].mean / a[Quantity::nees].mean, 1.0, 1e-9) << k;
      EXPECT_NEAR(b[Quantity::nis].mean / a[Quantity::nis].mean, 1.0, 1e-9) << k;
      EXPECT_EQ(b.nees_dof, a.nees_dof);
    }
  }
}

TEST(PluggedExperiment, CountsARunWhoseFilterThrows) {
  std::atomic<int> made = 0;
  const PluggedExperiment experiment(NamedWorld{CvWorld{.silent = 1}},
                                     [&made] { return CvFilter{.throws = made++ % 2 == 1}; }, {.steps = 5});
  const StudyStatistics statistics = experiment.run_chunk(0, 4);
  ASSERT_EQ(statistics.failures.size(), 2U);
  EXPECT_EQ(statistics.failures[0].outcome, Outcome::threw);
  EXPECT_EQ(statistics.failures[0].step, 2) << "at step 1 nothing is measured";
  const PluggedExperiment always(CvWorld(), [] { return CvFilter{.throws = true}; });
  EXPECT_EQ(always.said(3), "no fix");
  EXPECT_EQ(always.visit(0, [](const TraceStep&) {}), Outcome::threw);
}

TEST(PluggedExperiment, KnowsASilentStep) {
  const NamedWorld world{CvWorld{.silent = 3}};
  const PluggedExperiment experiment(world, [] { return CvFilter(); }, {.steps = 5});
  const auto steps = steps_of(experiment, 0);
  EXPECT_EQ(steps[3].nis_dof, 0);
  EXPECT_EQ(steps[3].innovations.front().nu.size(), 0);
  EXPECT_EQ(steps[4].nis_dof, 1);
  EXPECT_EQ(experiment.layout().blocks.front().name, "pose");
}

TEST(PlugProblems, NamesAFilterThatIsNotTheSameTwice) {
  std::atomic<int> made = 0;
  struct Drifting : CvFilter {
    double drift = 0.0;
    void predict(double dt) {
      CvFilter::predict(dt);
      x_.position += drift;
    }
  };
  const PluggedExperiment experiment(CvWorld(), [&made] {
    Drifting filter;
    filter.drift = 1e-12 * made++;
    return filter;
  });
  ASSERT_EQ(experiment.problems().size(), 1U);
  EXPECT_THAT(experiment.problems().front(), HasSubstr("run 0 is not the same twice, from step 1 on"));
}

TEST(PlugProblems, NamesAMatrixThatIsNoCovariance) {
  struct Lopsided : CvFilter {
    void update(double z) {
      CvFilter::update(z);
      P_(0, 1) += 0.01;
    }
  };
  const PluggedExperiment lopsided(CvWorld(), [] { return Lopsided(); });
  ASSERT_EQ(lopsided.problems().size(), 1U);
  EXPECT_THAT(lopsided.problems().front(), HasSubstr("P is not symmetric in run 0 at step 1"));

  struct Indefinite : CvFilter {
    void update(double z) {
      CvFilter::update(z);
      S_(0, 0) = -S_(0, 0);
    }
  };
  const PluggedExperiment indefinite(CvWorld(), [] { return Indefinite(); });
  EXPECT_THAT(indefinite.problems().front(), HasSubstr("S is not positive definite"));
}

TEST(PlugProblems, NamesDimensionsThatDoNotFit) {
  struct Wide : CvFilter {
    void update(double z) {
      CvFilter::update(z);
      P_ = Matrix::Identity(3, 3);
    }
    Matrix covariance() const { return P_; }
  };
  const PluggedExperiment wide(CvWorld(), [] { return Wide(); });
  EXPECT_EQ(wide.said(0), "an error of dimension 2 and P of 3x3 do not fit a state of 2");
}

TEST(PlugProblems, NamesDimensionsThatDoNotFitLater) {
  struct Growing : CvFilter {
    void update(double z) {
      CvFilter::update(z);
      if (++updates == 3) nu_ = Vector::Zero(2);
      if (updates == 3) S_ = Matrix::Identity(2, 2);
    }
    int updates = 0;
  };
  const PluggedExperiment growing(CvWorld(), [] { return Growing(); }, {.steps = 10});
  EXPECT_THAT(growing.problems(),
              ElementsAre("run 0 ends at step 3: an innovation of dimension 2 with S of 2x2 does not fit a "
                          "sensor of 1"));
}

// Each run alone is right, and the same twice; two at a time are not.
TEST(PlugProblems, NamesFiltersThatShareTheirState) {
  struct Shared {
    void reset(const CvState& mean, const Matrix& P) const { filter->reset(mean, P); }
    void predict(double dt) const { filter->predict(dt); }
    void update(double z) const { filter->update(z); }
    const CvState& state() const { return filter->state(); }
    const Matrix& covariance() const { return filter->covariance(); }
    std::shared_ptr<CvFilter> filter;
  };
  const auto one = std::make_shared<CvFilter>();
  const PluggedExperiment sharing(CvWorld(), [&] { return Shared{one}; }, {.steps = 10});
  EXPECT_THAT(sharing.problems(), ElementsAre(HasSubstr("filters share state")));
  const PluggedExperiment own(CvWorld(), [] { return Shared{std::make_shared<CvFilter>()}; }, {.steps = 10});
  EXPECT_THAT(own.problems(), IsEmpty());
}

TEST(PlugProblems, NamesAWrongJacobian) {
  FunctionModel model = linear_model();
  model.F = [](const Vector&) { return Matrix((Matrix(2, 2) << 1.0, 0.4, 0.0, 1.0).finished()); };
  model.H = [](const Vector&) { return Matrix(Eigen::RowVector2d(1.0, 0.0)); };
  const PluggedExperiment experiment(FunctionWorld(model), [&] { return FunctionEkf(model); });
  ASSERT_EQ(experiment.problems().size(), 1U);
  EXPECT_THAT(experiment.problems().front(),
              HasSubstr("F is not the Jacobian of its function: entry (0, 1) is 0.4, by differences 0.5"));
  model.F = [](const Vector&) { return Matrix((Matrix(2, 2) << 1.0, 0.5, 0.0, 1.0).finished()); };
  const PluggedExperiment right(FunctionWorld(model), [&] { return FunctionEkf(model); });
  EXPECT_THAT(right.problems(), IsEmpty());
}

/// A heading that turns by a third of a turn at each step.
FunctionModel compass() {
  FunctionModel model;
  model.f = [](const Vector& x) { return Vector(x.array() + 2.0); };
  model.h = [](const Vector& x) { return x; };
  model.Q = model.R = model.P0 = Matrix::Constant(1, 1, 0.01);
  model.mean = Vector::Zero(1);
  model.states = {"heading:angle"};
  model.measured_angles = {true};
  return model;
}

TEST(PlugProblems, NamesAnAngleThatIsNotWrapped) {
  const FunctionModel right = compass();
  const PluggedExperiment wrapped(FunctionWorld(right), [&] { return FunctionEkf(right); });
  EXPECT_THAT(wrapped.problems(), IsEmpty());

  FunctionModel wrong = right;
  wrong.measured_angles.clear();
  const PluggedExperiment not_wrapped(FunctionWorld(right), [&] { return FunctionEkf(wrong); });
  ASSERT_FALSE(not_wrapped.problems().empty());
  EXPECT_THAT(not_wrapped.problems().front(), HasSubstr("the innovation of an angle is"));
}

/// The world says how long a step is.
struct TimedWorld : CvWorld {
  double dt() const { return 0.5; }
};

struct TimedFilter : CvFilter {
  void predict(double /*input*/, double dt) {
    Eigen::Matrix2d F;
    F << 1.0, dt, 0.0, 1.0;
    x_.position += dt * x_.velocity;
    P_ = (F * P_ * F.transpose()).eval();
    const double scale = scales ? dt / 0.5 : 1.0;
    P_(0, 0) += scale * 0.01;
    P_(1, 1) += scale * 0.04;
  }
  bool scales = true;
};

TEST(PlugProblems, NamesAProcessNoiseThatDoesNotScaleWithTime) {
  const auto problems = [](bool scales) {
    const PluggedExperiment experiment(TimedWorld(), [=] {
      TimedFilter filter;
      filter.scales = scales;
      return filter;
    });
    return experiment.problems();
  };
  EXPECT_THAT(problems(true), IsEmpty());
  EXPECT_THAT(problems(false), testing::ElementsAre(HasSubstr("Q does not scale with dt")));
}

// [q dt³/3, q dt²/2; q dt²/2, q dt] is white noise in continuous time: two halves are the whole.
TEST(PlugProblems, AcceptTheExactNoiseOfAConstantVelocity) {
  const auto after = [](int parts) {
    Eigen::Matrix2d P = Eigen::Matrix2d::Zero(), F, Q;
    const double t = 1.0 / parts;
    F << 1.0, t, 0.0, 1.0;
    Q << t * t * t / 3.0, t * t / 2.0, t * t / 2.0, t;
    for (int i = 0; i < parts; ++i) P = (F * P * F.transpose() + Q).eval();
    return Vector(P.diagonal());
  };
  EXPECT_LT((after(1) - after(2)).norm(), 1e-15);
  std::vector<std::string> problems;
  report_time_step(after(1), after(2), problems);
  EXPECT_THAT(problems, IsEmpty());
}

// The first run that does not fail tells them, and what is no std::exception is a failure too.
TEST(PluggedExperiment, KnowsItsSensorsThoughTheFirstRunFailsAtOnce) {
  struct Picky : CvFilter {
    void update(double z) {
      CvFilter::update(z);
      if (nu_[0] * sign > 0.0) throw 7;
    }
    double sign = 1.0;
  };
  int first_failed = 0;
  for (const double sign : {1.0, -1.0}) {
    const PluggedExperiment experiment(CvWorld(),
                                       [sign] {
                                         Picky filter;
                                         filter.sign = sign;
                                         return filter;
                                       },
                                       {.steps = 1, .seed = 2});
    ASSERT_EQ(experiment.layout().sensors.size(), 1U);
    EXPECT_EQ(experiment.layout().sensors[0].dim, 1);
    first_failed += experiment.visit(0, [](const TraceStep&) {}) == Outcome::threw ? 1 : 0;
    EXPECT_THAT(experiment.problems(), IsEmpty());
  }
  EXPECT_EQ(first_failed, 1);
}

TEST(PluggedExperiment, AFilterThatShowsNoInnovationAtItsFirstStepNeedsALayout) {
  struct Shy : CvFilter {
    std::vector<Innovation> innovations() const { return {{Vector(), Matrix()}}; }
  };
  const auto make = [] { return PluggedExperiment(CvWorld(), [] { return Shy(); }); };
  EXPECT_THROW(make(), std::invalid_argument);
  EXPECT_NO_THROW(PluggedExperiment(NamedWorld(), [] { return Shy(); }));
}

// At the identity, where a group often starts, the charts agree.
TEST(PlugProblems, PlusIsLookedAtWhereTheTruthGoes) {
  struct Scaled : CvWorld {
    CvState plus(const CvState& x, const Vector& d) const {
      return {x.position + (1.0 + x.position) * d[0], x.velocity + d[1]};
    }
  };
  const PluggedExperiment experiment(Scaled(), [] { return CvFilter(); });
  ASSERT_EQ(experiment.problems().size(), 1U);
  EXPECT_THAT(experiment.problems().front(), HasSubstr("minus(plus(x, d), x) is not d"));
}

TEST(PlugProblems, AWorldThatThrowsIsAProblemThoughItHasAPlus) {
  struct Broken : CvWorld {
    CvState step(const CvState&, std::int64_t, NoiseDraw&) const { throw std::runtime_error("no road"); }
    CvState plus(const CvState& x, const Vector& d) const { return {x.position + d[0], x.velocity + d[1]}; }
  };
  const PluggedExperiment experiment(Broken(), [] { return CvFilter(); });
  ASSERT_EQ(experiment.problems().size(), 1U);
  EXPECT_THAT(experiment.problems().front(), HasSubstr("no road"));
}

TEST(PlugProblems, NamesAPlusThatIsNotTheInverse) {
  struct Turned : CvWorld {
    CvState plus(const CvState& x, const Vector& d) const { return {x.position + d[1], x.velocity + d[0]}; }
  };
  const PluggedExperiment experiment(Turned(), [] { return CvFilter(); });
  ASSERT_EQ(experiment.problems().size(), 1U);
  EXPECT_THAT(experiment.problems().front(), HasSubstr("minus(plus(x, d), x) is not d"));
  EXPECT_THROW(require_sound(experiment.problems()), std::invalid_argument);
  EXPECT_NO_THROW(require_sound({}));
}

}  // namespace
}  // namespace credence::internal
