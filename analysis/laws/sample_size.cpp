#include "analysis/laws/sample_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <stdexcept>

#include "analysis/laws/chi_square.h"
#include "analysis/laws/require.h"
#include "analysis/laws/run_mean.h"

namespace credence {
namespace {

constexpr double kMostRuns = 1e12;

void require_design(const VerdictDesign& design) {
  require_positive("steps", design.steps);
  require_positive("dof_per_step", design.dof_per_step);
  require_positive("effective_steps", design.effective_steps);
  require_fraction("confidence", design.confidence);
}

// P(factor · χ²(dof) leaves the interval).
double leaves(double factor, double dof, double lower, double upper) {
  return chi_square_cdf(lower / factor, dof) + chi_square_survival(upper / factor, dof);
}

double power_of_sum(const VerdictDesign& design, double factor, double runs, double level) {
  const double step_dof = runs * design.dof_per_step;
  if (design.white) return chi_square_power(factor, step_dof * design.steps, level);
  const double effective = std::min(design.steps, design.effective_steps);
  // Whole runs are compared: their average is a multiple of χ² with the effective dof.
  if (runs >= static_cast<double>(kFewestRunsCompared)) {
    return chi_square_power(factor, effective * step_dof, level);
  }
  // The acceptance interval of the mean over steps is that of one step, by expected shortfall.
  const double lower = chi_square_lower_tail_mean(0.5 * level, step_dof);
  const double upper = chi_square_upper_tail_mean(0.5 * level, step_dof);
  return leaves(factor, effective * step_dof, effective * lower, effective * upper);
}

double power_of_steps(const VerdictDesign& design, double factor, double runs, double level) {
  const double one = chi_square_power(factor, runs * design.dof_per_step, level / design.steps);
  return design.white ? -std::expm1(design.steps * std::log1p(-std::min(one, 1.0))) : one;
}

}  // namespace

double chi_square_power(double factor, double dof, double level) {
  require_positive("factor", factor);
  require_fraction("level", level);
  return leaves(factor, dof, chi_square_quantile(0.5 * level, dof),
                chi_square_upper_quantile(0.5 * level, dof));
}

double verdict_power(const VerdictDesign& design, double factor, double runs) {
  require_design(design);
  require_positive("factor", factor);
  require_positive("runs", runs);
  const double alpha = 1.0 - design.confidence;
  if (design.steps <= 1.0) return chi_square_power(factor, runs * design.dof_per_step, alpha);
  return std::max(power_of_sum(design, factor, runs, 0.5 * alpha),
                  power_of_steps(design, factor, runs, 0.5 * alpha));
}

RunsNeeded runs_to_detect(const VerdictDesign& design, double factor, double power) {
  require_fraction("power", power);
  if (factor == 1.0)
    throw std::invalid_argument("factor = 1 is a consistent filter: there is nothing to detect");
  double enough = 1.0;
  while (verdict_power(design, factor, enough) < power) {
    enough *= 2.0;
    if (enough > kMostRuns) {
      throw std::invalid_argument(fmt::format("factor = {} is too near 1 to be detected", factor));
    }
  }
  double too_few = std::floor(0.5 * enough);
  while (enough - too_few > 1.0) {
    const double middle = std::floor(0.5 * (enough + too_few));
    (verdict_power(design, factor, middle) < power ? too_few : enough) = middle;
  }
  return {.runs = static_cast<std::int64_t>(enough), .power = verdict_power(design, factor, enough)};
}

DetectableFactors detectable_factors(const VerdictDesign& design, double runs, double power) {
  require_fraction("power", power);
  const auto search = [&](double direction) {
    double near = 0.0;
    double far = 1e-6;
    constexpr double kFarthest = 60.0;
    while (far < kFarthest && verdict_power(design, std::exp(direction * far), runs) < power) {
      near = far;
      far *= 2.0;
    }
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (near + far);
      (verdict_power(design, std::exp(direction * middle), runs) < power ? near : far) = middle;
    }
    return std::exp(direction * far);
  };
  return {.below = search(-1.0), .above = search(1.0)};
}

std::int64_t runs_for_precision(const VerdictDesign& design, double precision) {
  require_design(design);
  require_positive("precision", precision);
  const double z = quantile(complement(boost::math::normal(), 0.5 * (1.0 - design.confidence)));
  const double steps = design.white ? design.steps : std::min(design.steps, design.effective_steps);
  const double runs = z * z * 2.0 / (design.dof_per_step * steps * precision * precision);
  return static_cast<std::int64_t>(std::max(2.0, std::min(kMostRuns, std::ceil(runs))));
}

}  // namespace credence
