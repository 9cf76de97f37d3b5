#include "analysis/evidence/causes/advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/normal_quantile.h"
#include "core/append_item.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Of the mean over all steps, or of the worst step where that decided: it hardly moves the mean.
double standardised_deviation(const ConsistencyVerdict& verdict) {
  const double dof_per_step = verdict.dof / static_cast<double>(verdict.steps_tested);
  const double overall = (verdict.mean / verdict.expected - 1.0) * std::sqrt(0.5 * dof_per_step);
  if (verdict.worst_step < 0 || !verdict.decided_by_steps) return overall;
  const StepTest& worst = verdict.steps[static_cast<std::size_t>(verdict.worst_step)];
  const double at_worst = (worst.mean / worst.expected - 1.0) * std::sqrt(0.5 * worst.total_dof);
  return std::abs(overall) > std::abs(at_worst) ? overall : at_worst;
}

/// The standard error of the logarithm that an interval stands for; NaN where it has no such ends.
double relative_error(const MeanInterval& factor, double confidence) {
  if (!factor.reason.empty() || !(factor.lower > 0.0) || !std::isfinite(factor.upper)) return kNaN;
  const double z = normal_quantile_two_sided(confidence);
  return std::log(factor.upper / factor.lower) / (2.0 * z);
}

struct LeftParts {
  std::string optimistic, pessimistic;

  std::string text() const {
    std::string both = optimistic.empty() ? "" : optimistic + " optimistic";
    if (!pessimistic.empty()) append_item(both, pessimistic + " pessimistic", " and ");
    return both;
  }
};

LeftParts left_blocks(const ConsistencyVerdict& whole, std::span<const BlockVerdict> blocks) {
  const double error = relative_error(whole.factor, whole.confidence);
  std::vector<double> scores, p_values;
  for (const BlockVerdict& block : blocks) {
    const MeanInterval& factor = block.verdict.factor;
    const double spread = std::hypot(error, relative_error(factor, block.verdict.confidence));
    scores.push_back(std::log(factor.mean / whole.factor.mean) / spread);
    p_values.push_back(std::isfinite(scores.back()) ? std::erfc(std::abs(scores.back()) / std::sqrt(2.0))
                                                    : kNaN);
  }
  const std::vector<double> adjusted = holm(p_values);
  LeftParts left;
  double most = 0.0, least = 0.0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!(adjusted[i] <= 1.0 - whole.confidence)) continue;
    if (scores[i] > most) {
      most = scores[i];
      left.optimistic = blocks[i].name;
    } else if (scores[i] < least) {
      least = scores[i];
      left.pessimistic = blocks[i].name;
    }
  }
  return left;
}

LeftParts left_steps(const ConsistencyVerdict& nees) {
  StepSpan high, low;
  for (std::size_t k = 0; k < nees.steps.size(); ++k) {
    const StepTest& step = nees.steps[k];
    const auto number = static_cast<std::int64_t>(k) + 1;
    if (step.mean > nees.factor.upper * step.simultaneous_upper) high.add(number);
    if (step.mean < nees.factor.lower * step.simultaneous_lower) low.add(number);
  }
  return {nees.text_of(high), nees.text_of(low)};
}

}  // namespace

ScaleAdvice no_scale(std::string_view reason) {
  return {.factor = kNaN, .lower = kNaN, .upper = kNaN, .reason = reason};
}

ScaleAdvice scale_of_covariance(const ConsistencyVerdict& nees) {
  const MeanInterval& factor = nees.factor;
  if (!factor.reason.empty()) return no_scale(factor.reason);
  return {.factor = factor.mean, .lower = factor.lower, .upper = factor.upper, .reason = {}};
}

std::string left_by_scale(const ConsistencyVerdict& nees, std::span<const BlockVerdict> blocks) {
  const MeanInterval& factor = nees.factor;
  if (!factor.reason.empty() || !(factor.lower > 1.0 || (factor.lower > 0.0 && factor.upper < 1.0)))
    return "";
  const std::string text = left_blocks(nees, blocks).text();
  return text.empty() ? left_steps(nees).text() : text;
}

ScaleAdvice scale_of_innovation(const ConsistencyVerdict& nis, double correlation_time) {
  if (nis.steps_tested == 0 || !(nis.dof > 0.0) || !std::isfinite(nis.mean)) return no_scale("no data");
  const double sum = nis.mean * static_cast<double>(nis.count);
  const ChiSquareBounds bounds = mean_bounds(nis.dof / correlation_time, 1.0, nis.confidence);
  const double of_as_many = sum / correlation_time;
  return {.factor = sum / nis.dof,
          .lower = of_as_many / bounds.upper,
          .upper = of_as_many / bounds.lower,
          .reason = {}};
}

ScaleAdvice scale_of_measurement_noise(const ScaleAdvice& scale, double share) {
  if (!(share > 0.0 && share <= 1.0)) {
    throw std::invalid_argument(fmt::format("share of R = {} must lie in (0, 1]", share));
  }
  if (!scale.reason.empty()) return scale;
  const auto of_R = [share](double of_S) { return 1.0 + (of_S - 1.0) / share; };
  if (of_R(scale.factor) < 0.0) return no_scale("no factor on R alone makes S that small");
  return {.factor = of_R(scale.factor),
          .lower = std::max(0.0, of_R(scale.lower)),
          .upper = of_R(scale.upper),
          .reason = {}};
}

ResponsibleBlock responsible_block(const ConsistencyVerdict& whole, std::span<const BlockVerdict> blocks) {
  std::vector<double> p_values;
  for (const BlockVerdict& block : blocks) p_values.push_back(block.verdict.p_value);
  const std::vector<double> adjusted = holm(p_values);
  ResponsibleBlock result;
  double largest = 0.0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const ConsistencyVerdict& verdict = blocks[i].verdict;
    if (!(adjusted[i] <= 1.0 - verdict.confidence)) continue;
    const double deviation = std::abs(standardised_deviation(verdict));
    if (result.index < 0 || deviation > largest) {
      result.index = static_cast<std::int64_t>(i);
      largest = deviation;
    }
  }
  // A wrong scale moves the ratio mean/expected of every block alike; cross-covariances that of the whole
  // alone.
  constexpr double kMuchLess = 0.3;
  const double whole_ratio = std::abs(whole.mean / whole.expected - 1.0);
  const bool blocks_fit = std::ranges::all_of(blocks, [&](const BlockVerdict& block) {
    return std::abs(block.verdict.mean / block.verdict.expected - 1.0) < kMuchLess * whole_ratio;
  });
  result.joint_only = result.index < 0 && !blocks.empty() && is_inconsistent(whole.verdict) && blocks_fit;
  return result;
}

SettlingRuns runs_to_settle(const ConsistencyVerdict& verdict, const VerdictDesign& design, double runs,
                            double power) {
  SettlingRuns result;
  if (verdict.verdict != Verdict::consistent) {
    result.observed_factor = verdict.mean / verdict.expected;
    result.reason = is_inconsistent(verdict.verdict) ? "the verdict is settled" : "no data";
    return result;
  }
  result.observed_factor = verdict.mean / verdict.expected;
  result.detectable = detectable_factors(design, runs, power);
  constexpr double kNegligible = 1e-4;
  if (std::abs(result.observed_factor - 1.0) < kNegligible || !(result.observed_factor > 0.0)) {
    result.reason = "the deviation seen is negligible";
    return result;
  }
  result.runs = runs_to_detect(design, result.observed_factor, power).runs;
  return result;
}

}  // namespace credence::internal
