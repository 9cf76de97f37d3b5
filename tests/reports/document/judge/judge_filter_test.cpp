#include "reports/document/judge/judge_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "analysis/evidence/causes/advice_cause.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A target on a line, seen in range and bearing from beside it.
FunctionModel radar() {
  FunctionModel model;
  model.f = [](const Vector& x) { return Vector(Eigen::Vector2d(x[0] + x[1], x[1])); };
  model.h = [](const Vector& x) {
    return Vector(Eigen::Vector2d(std::hypot(x[0], 50.0), std::atan2(50.0, x[0])));
  };
  model.Q = Eigen::Vector2d(1e-3, 1e-2).asDiagonal();
  model.R = Eigen::Vector2d(0.04, 1e-6).asDiagonal();
  model.mean = Eigen::Vector2d(-20.0, 1.0);
  model.P0 = Eigen::Vector2d(0.25, 0.04).asDiagonal();
  model.states = {"position", "velocity"};
  model.measured_angles = {false, true};
  return model;
}

nlohmann::json accuracy(const JudgedFilter& judged) {
  return nlohmann::json::parse(judged.json())["battery"]["accuracy"];
}

const JudgeOptions kOptions{.name = "radar", .runs = 300, .steps = 30, .seed = 7};

TEST(JudgeFilter, TrustsTheRightModelAndNamesTheWrongOne) {
  const JudgedFilter right = judge_model(radar(), radar(), kOptions);
  EXPECT_EQ(right.verdict(), Verdict::consistent) << right.text();
  EXPECT_THAT(right.says(), HasSubstr("no evidence against the covariance"));

  FunctionModel believed = radar();
  believed.Q *= 0.1;
  const JudgedFilter wrong = judge_model(radar(), believed, kOptions);
  EXPECT_EQ(wrong.verdict(), Verdict::optimistic);
  ASSERT_FALSE(wrong.causes().empty());
  EXPECT_EQ(wrong.causes().front().name, to_string(Cause::process_noise_too_small));
  EXPECT_LT(right.factor().upper, wrong.factor().lower);
  EXPECT_LT(wrong.factor().value, wrong.factor().upper);
  EXPECT_LT(wrong.p_value(), 1e-6);
}

/// A target on a line whose place is measured.
FunctionModel cart() {
  FunctionModel model;
  model.f = [](const Vector& x) { return Vector(Eigen::Vector2d(x[0] + x[1], x[1])); };
  model.h = [](const Vector& x) { return Vector(x.head<1>()); };
  model.Q = Eigen::Vector2d(1e-3, 1e-2).asDiagonal();
  model.R = Matrix::Constant(1, 1, 0.09);
  model.mean = Vector::Zero(2);
  model.P0 = Matrix::Identity(2, 2);
  return model;
}

/// The right filter, with standard deviations, and roots of covariances, for P.
struct Deviations : FunctionEkf {
  using FunctionEkf::FunctionEkf;
  Matrix covariance() const {
    return P_.unaryExpr([](double p) { return std::copysign(std::sqrt(std::abs(p)), p); });
  }
};

// As of logs of the same numbers.
TEST(JudgeFilter, TellsAMistakeOfTheNumbersAndNoCauseThatItMakes) {
  JudgeOptions options = kOptions;
  options.check_plug = false;  // such a P need not be positive definite
  const FunctionModel model = cart();
  const JudgedFilter wrong = judge_filter(
      FunctionWorld(model), [&] { return Deviations(model); }, options);
  EXPECT_NE(wrong.verdict(), Verdict::consistent);
  EXPECT_THAT(wrong.json(), HasSubstr("P holds standard deviations, not variances"));
  ASSERT_EQ(wrong.mistakes().size(), 1U);
  EXPECT_THAT(wrong.mistakes().front(), HasSubstr("P holds standard deviations, not variances"));
  for (const NamedCause& cause : wrong.causes()) {
    EXPECT_NE(cause.name, to_string(Cause::covariance_scale));
    EXPECT_NE(cause.name, to_string(Cause::process_or_measurement_noise));
  }
  const JudgedFilter right = judge_filter(
      FunctionWorld(model), [&] { return FunctionEkf(model); }, options);
  EXPECT_EQ(right.verdict(), Verdict::consistent) << right.text();
  EXPECT_THAT(right.json(), Not(HasSubstr("It would fit if")));
}

TEST(JudgeFilter, TellsTimesOfAWorldThatHasThemOrOfTheOptions) {
  FunctionModel believed = radar();
  believed.Q *= 0.1;
  JudgeOptions options = kOptions;
  EXPECT_THAT(judge_model(radar(), believed, options).text(), Not(HasSubstr("(t = ")));
  options.dt = 0.5;
  const JudgedFilter judged = judge_model(radar(), believed, options);
  const auto steps = nlohmann::json::parse(judged.json())["nees"]["optimistic_steps"];
  EXPECT_EQ(steps["first_time_s"], 0.5 * steps["first"].get<double>());
  struct Clock {
    double dt() const { return 0.1; }
  };
  EXPECT_EQ(accepted(kOptions, Clock()).dt, 0.1);
  EXPECT_EQ(accepted(options, Clock()).dt, 0.5);
}

TEST(JudgeFilter, SetsTheBoundBesideTheErrorsOfAModel) {
  FunctionModel believed = radar();
  believed.R *= 25.0;
  const JudgedFilter right = judge_model(radar(), radar(), kOptions);
  const JudgedFilter wrong = judge_model(radar(), believed, kOptions);
  const auto of_right = accuracy(right), of_wrong = accuracy(wrong);
  ASSERT_EQ(of_right.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const double good = of_right[i]["efficiency"]["value"], poor = of_wrong[i]["efficiency"]["value"];
    EXPECT_EQ(of_right[i]["bound"], of_wrong[i]["bound"]);
    EXPECT_GT(double{of_right[i]["efficiency"]["upper"]}, 0.9);
    EXPECT_LT(poor, good);
  }
  EXPECT_THAT(right.text(), HasSubstr("posterior Cramér-Rao bound: position"));
  const TemporaryFolder folder;
  right.write_report(folder / "out");
  EXPECT_THAT(folder.read("out/index.html"), HasSubstr("averaged over 64 runs"));
  JudgeOptions late = kOptions;
  late.measurement_delay = 1;
  EXPECT_TRUE(accuracy(judge_model(radar(), radar(), late))[0]["bound"].is_null());
}

TEST(JudgeFilter, TellsItAsTextJsonAndPage) {
  const JudgedFilter judged = judge_model(radar(), radar(), kOptions);
  EXPECT_THAT(judged.text(),
              HasSubstr("Can this covariance be trusted? Yes, nothing speaks against it: consistent"));
  EXPECT_THAT(judged.text(), HasSubstr("9000 rows of 300 runs (simulated, 30 steps, seed 7)"));
  EXPECT_THAT(judged.text(), Not(HasSubstr("further runs")))
      << "only of logs it is known what covers further runs";
  EXPECT_EQ(nlohmann::json::parse(judged.json())["verdict"], "consistent");
  const TemporaryFolder folder;
  judged.write_report(folder / "out");
  EXPECT_THAT(folder.read("out/index.html"), HasSubstr("radar"));
}

TEST(JudgeFilter, TellsHowFarItIsAndIsStoppedOnTheWay) {
  std::atomic<bool> stop{false};
  std::vector<std::int64_t> told;
  JudgeOptions options = kOptions;
  options.threads = 1;
  options.stop = &stop;
  options.progress = [&](std::int64_t done, std::int64_t total) {
    EXPECT_EQ(total, 300);
    told.push_back(done);
  };
  EXPECT_TRUE(judge_model(radar(), radar(), options).complete());
  EXPECT_EQ(told, (std::vector<std::int64_t>{64, 128, 192, 256, 300}));

  options.progress = [&](std::int64_t done, std::int64_t) { stop = done >= 128; };
  const JudgedFilter part = judge_model(radar(), radar(), options);
  EXPECT_FALSE(part.complete());
  options.runs = 128;
  options.progress = {};
  stop = false;
  const auto of_part = nlohmann::json::parse(part.json());
  const auto whole = nlohmann::json::parse(judge_model(radar(), radar(), options).json());
  EXPECT_EQ(of_part["runs"], 128);
  EXPECT_EQ(of_part["nees"], whole["nees"]) << "what was played is judged as if no more had been asked for";
  stop = true;
  EXPECT_THROW(judge_model(radar(), radar(), options), std::runtime_error);
}

TEST(JudgeFilter, NamesTheRunThatThrew) {
  struct Fragile : FunctionEkf {
    using FunctionEkf::FunctionEkf;
    bool update(const Vector& z) {
      if (z[0] < 50.0) throw std::runtime_error("range below 50");
      return FunctionEkf::update(z);
    }
  };
  const FunctionModel model = radar();
  const JudgedFilter judged = judge_filter(
      FunctionWorld(model), [&] { return Fragile(model); }, kOptions);
  const auto& failures = judged.failures();
  ASSERT_FALSE(failures.empty());
  EXPECT_EQ(failures.front().outcome, "threw");
  EXPECT_EQ(failures.front().said, "seed 7: range below 50");
  EXPECT_THAT(judged.text(), HasSubstr("threw at step"));
  EXPECT_THAT(judged.text(), HasSubstr("seed 7: range below 50"));
  const auto json = nlohmann::json::parse(judged.json());
  EXPECT_EQ(json["outcomes"]["threw"], failures.size());
  EXPECT_EQ(json["outcomes"]["failures"][0]["says"], "seed 7: range below 50");
}

TEST(JudgeFilter, RefusesAPlugThatIsWrong) {
  FunctionModel wrong = radar();
  wrong.H = [](const Vector&) { return Matrix(Matrix::Identity(2, 2)); };
  EXPECT_THROW(judge_model(radar(), wrong, kOptions), std::invalid_argument);
  EXPECT_THROW(judge_model(radar(), radar(), {.runs = 0}), std::invalid_argument);
}

/// A robot on a line, which measures the distance of what is near: landmarks appear one after the other.
struct Corridor {
  using Seen = std::vector<std::pair<Index, double>>;

  Prior<Vector> prior() const { return {Vector::Zero(1), Matrix::Constant(1, 1, 1e-4)}; }
  Vector initial(NoiseDraw& noise) const { return Vector{{0.01 * noise.normal(), 3.0, 13.0, 8.0}}; }
  Vector step(const Vector& x, Index, NoiseDraw& noise) const {
    return x + Vector{{0.5 + 0.1 * noise.normal(), 0.0, 0.0, 0.0}};
  }
  Seen measure(const Vector& x, Index, NoiseDraw& noise) const {
    Seen seen;
    for (Index i = 1; i < x.size(); ++i) {
      const double error = 0.2 * noise.normal();
      if (std::abs(x[i] - x[0]) < 4.0) seen.emplace_back(i, x[i] - x[0] + error);
    }
    return seen;
  }
  RunLayout layout() const {
    RunLayout layout{.states = {"robot.x", "landmark1.x", "landmark2.x", "landmark3.x"},
                     .angles = std::vector<bool>(4),
                     .sensors = {{.name = "range", .dim = 3, .piece = 1}}};
    add_named_blocks(layout);
    return layout;
  }
};

/// Exact: all is linear, and a landmark starts from its first measurement.
class GrowingFilter {
 public:
  explicit GrowingFilter(double R = 0.04) : R_(R) {}
  void reset(const Vector& mean, const Matrix& P) {
    x_ = mean;
    P_ = P;
    states_ = {0};
  }
  void predict() {
    x_[0] += 0.5;
    P_(0, 0) += 0.01;
  }
  void update(const Corridor::Seen& seen) {
    for (const auto& [landmark, distance] : seen) {
      const Index n = x_.size();
      const auto at = std::ranges::find(states_, landmark);
      if (at == states_.end()) {
        Matrix grown(n + 1, n + 1);
        grown << P_, P_.col(0), P_.row(0), P_(0, 0) + R_;
        P_ = grown;
        x_.conservativeResize(n + 1);
        x_[n] = x_[0] + distance;
        states_.push_back(landmark);
        continue;
      }
      Vector H = Vector::Zero(n);
      H[0] = -1.0;
      H[at - states_.begin()] = 1.0;
      const Vector K = P_ * H / (H.dot(P_ * H) + R_);
      P_ -= K * K.transpose() * (H.dot(P_ * H) + R_);
      x_ += K * (distance - H.dot(x_));
    }
  }
  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  const std::vector<Index>& states() const { return states_; }

 private:
  double R_;
  Vector x_;
  Matrix P_;
  std::vector<Index> states_;
};

TEST(JudgeFilter, StatesMayAppear) {
  const JudgeOptions options{.runs = 400, .steps = 30, .seed = 3};
  const JudgedFilter right = judge_filter(
      Corridor(), [] { return GrowingFilter(); }, options);
  EXPECT_EQ(right.verdict(), Verdict::consistent) << right.text();
  EXPECT_THAT(right.text(), HasSubstr("NEES of landmark3"));
  const auto json = nlohmann::json::parse(right.json());
  EXPECT_LT(double{json["nees"]["dof"]}, 0.8 * 400 * 30 * 4) << "of each landmark since it has been seen";
  const JudgedFilter wrong = judge_filter(
      Corridor(), [] { return GrowingFilter(0.02); }, options);
  EXPECT_EQ(wrong.verdict(), Verdict::optimistic) << wrong.text();
}

TEST(JudgeFilter, AnEstimateOfOtherStatesThanItSaysIsRefused) {
  struct Silent : GrowingFilter {
    const std::vector<Index>& states() const = delete;
  };
  struct Wrong : GrowingFilter {
    std::vector<Index> states() const { return {7}; }
  };
  const auto said = [](const auto& make_filter) {
    try {
      judge_filter(Corridor(), make_filter, {.runs = 10, .steps = 5});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_THAT(said([] { return Silent(); }),
              HasSubstr("run 0 ends at step 1: an estimate of 1 states where 4 are"));
  EXPECT_THAT(said([] { return Wrong(); }), HasSubstr("states(): 7 is none of the 4 states"));
}

std::string refusal(const FunctionModel& model, const JudgeOptions& options) {
  try {
    judge_model(model, model, options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "not refused";
}

TEST(JudgeFilter, RefusesAModelOfOtherDimensionsThanTheWorld) {
  const auto said = [](const FunctionModel& believed) {
    try {
      judge_model(radar(), believed, kOptions);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_EQ(said(cart()), "R of the filter has 1 rows: expected 2, as in the world");
  FunctionModel longer = cart();
  longer.f = [](const Vector& x) { return x; };
  longer.mean = Vector::Zero(3);
  longer.Q = longer.P0 = Matrix::Identity(3, 3);
  EXPECT_EQ(said(longer), "mean of the filter has 3 rows: expected 2, as in the world");
  FunctionModel wrong = radar();
  wrong.F = [](const Vector&) { return Matrix(Matrix::Ones(1, 2)); };
  EXPECT_EQ(said(wrong), "F(mean) is 1x2: expected 2x2");
  // Of a world of one's own the filter tells it itself.
  EXPECT_THROW(judge_filter(
                   FunctionWorld(radar()), [&] { return FunctionEkf(longer); }, kOptions),
               std::invalid_argument);
}

TEST(JudgeFilter, RefusesOptionsBeforeAnythingIsPlayed) {
  struct Untouched : FunctionWorld {
    using FunctionWorld::FunctionWorld;
    Prior<Vector> prior() const {
      ADD_FAILURE() << "played";
      return FunctionWorld::prior();
    }
  };
  const FunctionModel model = radar();
  const auto said = [&](const JudgeOptions& options) {
    try {
      judge_filter(
          Untouched(model), [&] { return FunctionEkf(model); }, options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_EQ(said({.confidence = 95.0}), "confidence = 95: expected a number from 0.5 to 0.999999");
  EXPECT_EQ(said({.dt = -1.0}), "dt = -1: expected a finite number from 0 on");
  EXPECT_EQ(said({.measurement_delay = -5}), "measurement_delay = -5: expected a number from 0 on");
  EXPECT_EQ(said({.steps = 10'000'001}),
            "1000 runs of 10000001 steps: expected 1 to 1000000000 runs of 1 to 10000000 steps");
}

TEST(JudgeFilter, RefusesNamesThatAreNoneAndThreadsThatCannotBe) {
  FunctionModel model = radar();
  model.states = {"x", "x:angle"};
  EXPECT_EQ(refusal(model, {}), "states: 'x' is there twice; accepted are names that differ");
  model.states = {"x", ""};
  EXPECT_EQ(refusal(model, {}), "states: a name is empty");
  EXPECT_EQ(refusal(radar(), {.runs = 4, .steps = 3, .threads = -3}),
            "threads = -3: accepted are 0 (one for each processor) to 4096");
}

}  // namespace
}  // namespace credence::internal
