#include "analysis/evidence/sequential/sequential.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/require.h"
#include "analysis/laws/scores/log_mean_exp.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

void require_rule(const StopRule& rule) {
  require_confidence(rule.confidence);
  if (!(rule.consistent_within >= 0.0) || !(rule.precision >= 0.0)) {
    throw std::invalid_argument(fmt::format("consistent_within = {} and precision = {} must be >= 0",
                                            rule.consistent_within, rule.precision));
  }
}

double log_mean(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? kNaN : log_mean_exp(std::array{a, b});
}

// The direction of the strongest evidence among the steps and their sum.
Verdict direction(std::span<const Moments> per_step, std::span<const double> dofs) {
  double sum = 0.0;
  double expected = 0.0;
  double strongest = -1.0;
  double excess = 0.0;
  const auto consider = [&](double value, double dof) {
    const double evidence = log_e_value(value, dof);
    if (evidence > strongest) {
      strongest = evidence;
      excess = value - dof;
    }
  };
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (per_step[k].count == 0 || dofs[k] == 0.0) continue;
    const double at_step = static_cast<double>(per_step[k].count) * per_step[k].mean;
    consider(at_step, dofs[k]);
    sum += at_step;
    expected += dofs[k];
  }
  consider(sum, expected);
  return excess > 0.0 ? Verdict::optimistic : Verdict::pessimistic;
}

struct LastLook {
  Verdict verdict = Verdict::undecided;
  double p_value = kNaN;  ///< of NEES and NIS together
};

/// By the fixed-sample tests, NEES and NIS sharing `alpha`.
LastLook last_look(const StudyPrefix& prefix, double alpha) {
  const double share = prefix.nis.empty() ? 1.0 : 0.5;
  const ConsistencyVerdict nees = judge_nees(prefix.nees, prefix.nees_dof, 1.0 - share * alpha, prefix.runs);
  if (prefix.nis.empty()) return {nees.verdict, nees.p_value};
  const ConsistencyVerdict nis = judge_nis(prefix.nis, prefix.nis_dof, 1.0 - share * alpha);
  const bool of_nees = is_inconsistent(nees.verdict) || nis.verdict == Verdict::undecided;
  return {of_nees ? nees.verdict : nis.verdict, std::fmin(nees.p_value, nis.p_value) / share};
}

void stop(StopDecision& decision, std::string_view reason, Verdict verdict) {
  decision.stop = true;
  decision.reason = reason;
  decision.verdict = verdict;
}

bool scale_is_within(const ChiSquareBounds& scale, double tolerance) {
  return scale.lower >= 1.0 / (1.0 + tolerance) && scale.upper <= 1.0 + tolerance;
}

/// Of the bets that NEES is too small, which are of the law of χ².
double log_pessimistic(const StudyPrefix& prefix) {
  return discounted(prefix.betting->log_pessimistic(), share_of_law(prefix.nees, prefix.nees_dof));
}

double log_e_of_bets(const StudyPrefix& prefix) {
  return log_mean(prefix.betting->log_optimistic(), log_pessimistic(prefix));
}

/// ln of the e-value of NEES: of its steps, and half and half of the bets on whole runs where there are such.
double log_e_of_nees(const StudyPrefix& prefix) {
  const double steps = log_e_nees(prefix.nees, prefix.nees_dof);
  return prefix.betting == nullptr ? steps : log_mean(steps, log_e_of_bets(prefix));
}

/// What NEES speaks for: the bets where they say more than the steps.
Verdict direction_of_nees(const StudyPrefix& prefix) {
  const bool bets =
      prefix.betting != nullptr && log_e_of_bets(prefix) > log_e_nees(prefix.nees, prefix.nees_dof);
  if (!bets) return direction(prefix.nees, prefix.nees_dof);
  return prefix.betting->log_optimistic() > log_pessimistic(prefix) ? Verdict::optimistic
                                                                    : Verdict::pessimistic;
}

/// The interval of the mean NEES over the runs.
MeanInterval mean_nees_of(const StudyPrefix& prefix, double confidence) {
  MeanInterval interval;
  interval.mean = interval.lower = interval.upper = interval.standard_error = kNaN;
  interval.reason = "the averages of whole runs are not known";
  if (prefix.runs == nullptr) return interval;
  double dof = 0.0, values = 0.0;
  for (std::size_t k = 0; k < prefix.nees_dof.size(); ++k) {
    dof += prefix.nees_dof[k];
    values += static_cast<double>(prefix.nees[k].count);
  }
  if (values == 0.0 || prefix.runs->moments.count == 0) return interval;
  interval = run_mean_interval(prefix.runs->moments, confidence, static_cast<double>(prefix.runs->least_dof));
  for (double* number : {&interval.mean, &interval.lower, &interval.upper, &interval.standard_error}) {
    *number *= dof / values;
  }
  return interval;
}

bool precise(const StopRule& rule, const MeanInterval& interval) {
  constexpr std::int64_t kFewestForPrecision = 30;
  return rule.precision > 0.0 && interval.count >= kFewestForPrecision && interval.reason.empty() &&
         interval.half_width() <= rule.precision * interval.mean;
}

}  // namespace

StopDecision look(const StopRule& rule, const StudyPrefix& prefix) {
  require_rule(rule);
  const double alpha = 1.0 - rule.confidence;
  const double log_nees = log_e_of_nees(prefix);
  const double log_nis = prefix.nis.empty() ? log_nees : log_e_nis(prefix.nis, prefix.nis_dof);

  StopDecision decision;
  decision.log_e_value = log_mean(log_nees, log_nis);
  // Half of α at any look, half at the last.
  const auto of_half = [](double p_value) {
    return std::isnan(p_value) ? p_value : std::min(1.0, 2.0 * p_value);
  };
  decision.p_value = of_half(std::exp(-decision.log_e_value));
  decision.mean_nees = mean_nees_of(prefix, rule.confidence);
  const bool by_scale = rule.consistent_within > 0.0;
  const auto scale = [&] { return scale_confidence_sequence(prefix.nees, prefix.nees_dof, rule.confidence); };
  if (by_scale) decision.scale = scale();

  const bool proved_wrong = decision.p_value <= alpha;
  const auto proved = [&] {
    return log_nees >= log_nis ? direction_of_nees(prefix) : direction(prefix.nis, prefix.nis_dof);
  };
  if (rule.on_verdict && proved_wrong) {
    stop(decision, "verdict", proved());
  } else if (by_scale && scale_is_within(decision.scale, rule.consistent_within)) {
    stop(decision, "verdict", Verdict::consistent);
  } else if (prefix.last) {
    const LastLook last = last_look(prefix, 0.5 * alpha);
    stop(decision, "max_runs", last.verdict);
    decision.p_value = std::fmin(decision.p_value, of_half(last.p_value));
  } else if (precise(rule, decision.mean_nees)) {
    stop(decision, "precision", proved_wrong ? proved() : Verdict::undecided);
  }
  if (decision.stop && !by_scale) decision.scale = scale();
  return decision;
}

}  // namespace credence::internal
