#include "analysis/laws/sample_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/require.h"
#include "analysis/laws/simulated_studies.h"

namespace credence::internal {
namespace {

constexpr double kMostRuns = 1e12;

void require_design(const VerdictDesign& design) {
  require_positive("steps", design.steps);
  require_positive("dof_per_step", design.dof_per_step);
  require_positive("effective_steps", design.effective_steps);
  require_fraction("confidence", design.confidence);
}

// An interval of χ²(dof).
struct ChiSquareInterval {
  double dof, lower, upper;

  // P(factor · χ²(dof) leaves it).
  double power(double factor) const {
    return chi_square_cdf(lower / factor, dof) + chi_square_survival(upper / factor, dof);
  }
};

// That which χ²(dof) leaves with probability `level`.
ChiSquareInterval central_interval(double dof, double level) {
  require_fraction("level", level);
  return {dof, chi_square_quantile(0.5 * level, dof), chi_square_upper_quantile(0.5 * level, dof)};
}

double least_dof(const VerdictDesign& design) {
  return design.least_dof > 0.0 ? design.least_dof : design.dof_per_step;
}

// Of the average of a run.
struct RunSpread {
  double deviation, skewness;
};

RunSpread run_spread(const VerdictDesign& design) {
  const double steps = design.white ? design.steps : std::min(design.steps, design.effective_steps);
  const double deviation = std::sqrt(2.0 / (steps * design.dof_per_step));
  return {deviation, design.run_skewness > 0.0 ? design.run_skewness : 2.0 * deviation};
}

// Of averages that vary in so many runs as they do on average.
SkewedMoments expected_moments(const VerdictDesign& design, double runs) {
  const auto [deviation, skewness] = run_spread(design);
  const double spread = std::sqrt((runs - 1.0) / runs) * deviation;
  return {.count = static_cast<std::int64_t>(runs),
          .mean = 1.0,
          .m2 = runs * spread * spread,
          .m3 = runs * skewness * spread * spread * spread};
}

// Beyond so many runs their moments hardly vary from study to study.
constexpr double kMostRunsSimulated = 200.0;

// Averages of whole runs, judged as judge_nees does. A study of averages times a factor rejects the mean 1
// where without it the mean 1/factor is rejected: so one interval a study tells for every factor.
class ComparedRuns {
 public:
  ComparedRuns(const VerdictDesign& design, std::int64_t runs) {
    const double level = 0.5 * (1.0 - design.confidence);
    for (const SkewedMoments& moments : design.studies->of_runs(runs)) {
      const MeanInterval mean = run_mean_interval(moments, 1.0 - level, least_dof(design));
      optimistic_from_.push_back(1.0 / mean.lower);
      pessimistic_to_.push_back(1.0 / mean.upper);
    }
  }

  double power(double factor) const {
    const auto up = std::ranges::count_if(optimistic_from_, [=](double least) { return factor > least; });
    const auto down = std::ranges::count_if(pessimistic_to_, [=](double most) { return factor < most; });
    return static_cast<double>(up + down) / static_cast<double>(optimistic_from_.size());
  }

 private:
  std::vector<double> optimistic_from_, pessimistic_to_;
};

ChiSquareInterval interval_of_sum(const VerdictDesign& design, double runs, double level) {
  const double step_dof = runs * design.dof_per_step;
  if (design.white) return central_interval(step_dof * design.steps, level);
  const double effective = std::min(design.steps, design.effective_steps);
  const double dof = effective * step_dof;
  if (runs >= static_cast<double>(kFewestRunsCompared)) {
    const MeanInterval mean =
        run_mean_interval(expected_moments(design, runs), 1.0 - level, least_dof(design));
    return {dof, dof / mean.upper, dof / mean.lower};
  }
  // The acceptance interval of the mean over steps is that of one step, by expected shortfall.
  const double lower = chi_square_lower_tail_mean(0.5 * level, step_dof);
  const double upper = chi_square_upper_tail_mean(0.5 * level, step_dof);
  return {dof, effective * lower, effective * upper};
}

// The power of a verdict over so many runs, for any factor.
class VerdictPower {
 public:
  VerdictPower(const VerdictDesign& design, double runs) : design_(design) {
    require_design(design);
    require_positive("runs", runs);
    const double alpha = 1.0 - design.confidence, step_dof = runs * design.dof_per_step;
    if (design.steps <= 1.0) {
      sum_ = central_interval(step_dof, alpha);
      return;
    }
    step_ = central_interval(step_dof, 0.5 * alpha / design.steps);
    const bool few = runs < static_cast<double>(kFewestRunsCompared);
    if (!design.white && !few && runs <= kMostRunsSimulated && design.studies) {
      compared_.emplace(design, static_cast<std::int64_t>(runs));
    } else {
      sum_ = interval_of_sum(design, runs, 0.5 * alpha);
    }
  }

  double operator()(double factor) const {
    require_positive("factor", factor);
    if (design_.steps <= 1.0) return sum_.power(factor);
    const double sum = compared_ ? compared_->power(factor) : sum_.power(factor), one = step_.power(factor);
    return std::max(sum, design_.white ? -std::expm1(design_.steps * std::log1p(-std::min(one, 1.0))) : one);
  }

 private:
  VerdictDesign design_;
  ChiSquareInterval sum_{}, step_{};
  std::optional<ComparedRuns> compared_;
};

// Where between `below` and `above` the growing `excess` is no longer negative, from above, to `width`.
double first_enough(double below, double above, double width, const auto& excess) {
  const auto finite = [&](double x) {
    const double value = excess(x);
    if (value == 0.0) return std::numeric_limits<double>::min();  // enough, and perhaps not the first
    return value >= -1.0 ? value : -1.0;
  };
  if (finite(below) > 0.0) return below;
  std::uintmax_t evaluations = 200;
  const auto near = [=](double a, double b) { return b - a <= width; };
  return boost::math::tools::toms748_solve(finite, below, above, near, evaluations).second;
}

// From `least` on, `excess` of too few being negative; more than kMostRuns where these do not do.
double fewest_runs(double least, const auto& excess) {
  double runs = least, too_few = least - 1.0;
  while (!(excess(runs) >= 0.0)) {
    too_few = runs;
    runs *= 2.0;
    if (runs > kMostRuns) return runs;
  }
  if (runs - too_few <= 1.0) return runs;
  constexpr double kOfOneRun = 0.5;
  return std::floor(
      first_enough(too_few, runs, kOfOneRun, [&](double many) { return excess(std::floor(many)); }));
}

}  // namespace

VerdictDesign simulated(VerdictDesign design, int studies) {
  require_design(design);
  const auto [deviation, skewness] = run_spread(design);
  design.studies = std::make_shared<SimulatedStudies>(studies, deviation, skewness);
  return design;
}

double verdict_power(const VerdictDesign& design, double factor, double runs) {
  return VerdictPower(design, runs)(factor);
}

RunsNeeded runs_to_detect(const VerdictDesign& design, double factor, double power) {
  require_fraction("power", power);
  if (factor == 1.0)
    throw std::invalid_argument("factor = 1 is a consistent filter: there is nothing to detect");
  const double enough =
      fewest_runs(1.0, [&](double runs) { return verdict_power(design, factor, runs) - power; });
  if (enough > kMostRuns) {
    throw std::invalid_argument(fmt::format("factor = {} is too near 1 to be detected", factor));
  }
  return {.runs = static_cast<std::int64_t>(enough), .power = verdict_power(design, factor, enough)};
}

DetectableFactors detectable_factors(const VerdictDesign& design, double runs, double power) {
  require_fraction("power", power);
  const VerdictPower verdict(design, runs);
  const auto search = [&](double direction) {
    double near = 0.0, far = 1e-6;
    constexpr double kFarthest = 60.0, kPrecise = 1e-14;
    const auto excess = [&](double distance) { return verdict(std::exp(direction * distance)) - power; };
    while (far < kFarthest && excess(far) < 0.0) {
      near = far;
      far *= 2.0;
    }
    if (far >= kFarthest) return std::exp(direction * far);
    return std::exp(direction * first_enough(near, far, kPrecise * far, excess));
  };
  return {.below = search(-1.0), .above = search(1.0)};
}

std::int64_t runs_for_precision(const VerdictDesign& design, double precision) {
  require_design(design);
  require_positive("precision", precision);
  const auto half_width_of = [&](const SkewedMoments& moments) {
    return run_mean_interval(moments, design.confidence, least_dof(design)).half_width();
  };
  const auto half_width = [&](double runs) {
    if (runs <= kMostRunsSimulated && design.studies) {
      Moments widths;
      for (const SkewedMoments& m : design.studies->of_runs(static_cast<std::int64_t>(runs)))
        widths.add(half_width_of(m));
      return widths.mean;
    }
    return half_width_of(expected_moments(design, runs));
  };
  const double runs = fewest_runs(2.0, [&](double many) { return precision - half_width(many); });
  return static_cast<std::int64_t>(std::min(kMostRuns, runs));
}

}  // namespace credence::internal
