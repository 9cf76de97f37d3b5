#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <vector>

#include "analysis/evidence/causes/cause_rules.h"
#include "analysis/evidence/causes/cause_signature.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "core/append_item.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

// Where a mean is too large at once, and from which step on it lies within its bounds again.
struct Rise {
  std::size_t place = 0, end = 0;
};

// NEES of a Gaussian error of any covariance varies by no more than its mean times χ²(1): a mean over runs is
// larger than another one beyond what F of as many dof as runs leaves to chance.
bool rises(const StepTest& from, const StepTest& to, double level) {
  const auto runs_from = static_cast<double>(from.count), runs_to = static_cast<double>(to.count);
  return f_survival((1.0 + excess_of(to)) / (1.0 + excess_of(from)), runs_to, runs_from) <= level;
}

// The same of innovations, which are white, against all before: at that step, or at the next, which is the
// first that shows an error of a state that is not measured.
bool innovations_rise(const ConsistencyVerdict& nis, std::size_t place, double level) {
  const std::size_t known = std::min(place, nis.steps.size());
  const double dof = dof_of_steps(nis, 0, known), before = 1.0 + excess_of_steps(nis, 0, known);
  if (!(dof > 0.0) || !(before > 0.0)) return false;
  for (std::size_t k = place; k < std::min(place + 2, nis.steps.size()); ++k) {
    const StepTest& step = nis.steps[k];
    if (step.has_data() && f_survival((1.0 + excess_of(step)) / before, step.total_dof, dof) <= 0.5 * level)
      return true;
  }
  return false;
}

// Whether more than the start can be wrong at a step: of a nonlinear filter the first few innovations are, or
// errors, where no innovation is known.
bool is_past_the_start(const ConsistencyVerdict& verdict, std::size_t place, const Findings& findings) {
  const bool by_innovations = findings.nonlinear && first_step(findings.nis) != nullptr;
  const std::vector<StepTest>& steps = by_innovations ? findings.nis.steps : verdict.steps;
  const auto end = steps.begin() + static_cast<std::ptrdiff_t>(std::min(place, steps.size()));
  return std::ranges::count_if(steps.begin(), end, &StepTest::has_data) >= (findings.nonlinear ? 3 : 1);
}

// Whether the excess of a step is gone soon after it: most of it on average over all later steps, and some of
// it already over those up to the last that has most of it.
bool fades(const ConsistencyVerdict& verdict, std::size_t place) {
  constexpr double kSome = 0.1;
  const std::vector<StepTest>& steps = verdict.steps;
  const double excess = excess_of(steps[place]);
  std::size_t last = steps.size() - 1;
  while (last > place && !(steps[last].has_data() && excess_of(steps[last]) >= kMost * excess)) --last;
  return excess_of_steps(verdict, place + 1, last + 1) < (1.0 - kSome) * excess &&
         excess_of_steps(verdict, place + 1, steps.size()) < kMost * excess;
}

// Whether a step exceeds each before it, of as many states, by more than chance; or by this factor, where its
// innovations exceed all before by more than chance.
bool exceeds_all_before(const ConsistencyVerdict& verdict, std::size_t place, const Findings& findings) {
  const StepTest& at = verdict.steps[place];
  const double level = cause_level(findings) / static_cast<double>(place);
  constexpr double kClearly = 3.0;
  bool exceeds = true, exceeds_clearly = true;
  for (std::size_t k = 0; k < place; ++k) {
    const StepTest& step = verdict.steps[k];
    if (!step.has_data()) continue;
    if (step.expected != at.expected) return false;
    exceeds = exceeds && rises(step, at, level);
    exceeds_clearly = exceeds_clearly && at.mean > kClearly * step.mean;
  }
  return exceeds || (exceeds_clearly && innovations_rise(findings.nis, place, level));
}

// The first step after a place that lies within its bounds; that behind the last: none.
std::size_t end_of_rise(const ConsistencyVerdict& verdict, std::size_t place) {
  std::size_t end = place + 1;
  while (end < verdict.steps.size() &&
         !(verdict.steps[end].has_data() && verdict.steps[end].mean <= verdict.steps[end].simultaneous_upper))
    ++end;
  return end;
}

// The steps after a place that rise again by more than chance, and by so much of its excess.
std::vector<std::size_t> later_rises(const ConsistencyVerdict& verdict, std::size_t place, double share,
                                     double level) {
  std::vector<std::size_t> found;
  const StepTest* last = &verdict.steps[place];
  const double excess = excess_of(*last);
  for (std::size_t k = place + 1; k < verdict.steps.size(); ++k) {
    const StepTest& step = verdict.steps[k];
    if (!step.has_data()) continue;
    const bool larger = excess_of(step) - excess_of(*last) > share * excess;
    if (larger && step.mean > step.simultaneous_upper && rises(*last, step, level)) found.push_back(k);
    last = &step;
  }
  return found;
}

// The first step above its simultaneous bounds, where none before it left them, it exceeds these, has most of
// the largest excess, and what comes after it fades without rising as much again.
std::optional<Rise> lone_rise(const ConsistencyVerdict& verdict, const Findings& findings) {
  const std::vector<StepTest>& steps = verdict.steps;
  if (!is_inconsistent(verdict.verdict) || verdict.step_stride > 1) return std::nullopt;
  const auto at = std::ranges::find_if(
      steps, [](const StepTest& step) { return step.has_data() && step.mean > step.simultaneous_upper; });
  const auto place = static_cast<std::size_t>(at - steps.begin());
  if (at == steps.end() || place + 1 == steps.size() || any_step_outside(verdict, place)) return std::nullopt;
  if (!is_past_the_start(verdict, place, findings) || !fades(verdict, place)) return std::nullopt;
  const double most = excess_of(*at) / kMost;
  const auto is_larger = [&](const StepTest& step) { return step.has_data() && excess_of(step) > most; };
  if (std::any_of(at, steps.end(), is_larger)) return std::nullopt;
  const double as_much = findings.nonlinear ? 1.0 : kMost;  // far off, its linearisation makes more
  if (!later_rises(verdict, place, as_much, cause_level(findings)).empty()) return std::nullopt;
  if (!exceeds_all_before(verdict, place, findings)) return std::nullopt;
  return Rise{place, end_of_rise(verdict, place)};
}

// What is not back where it was: NEES of the last quarter of the steps after the place, as if they were one,
// beyond the bounds of a step, and nearly as much as in the quarter before.
std::string lasting_text(const ConsistencyVerdict& verdict, std::size_t place) {
  constexpr double kNearly = 0.75;
  const std::size_t steps = verdict.steps.size(), quarter = (steps - place) / 4;
  if (quarter == 0) return {};
  const double last = excess_of_steps(verdict, steps - quarter, steps);
  const StepTest& at = verdict.steps[place];
  if (!((1.0 + last) * at.expected > at.simultaneous_upper) ||
      !(last >= kNearly * excess_of_steps(verdict, steps - 2 * quarter, steps - quarter)))
    return {};
  return fmt::format("; something else is wrong as well, as it stays at {} times",
                     number_text(1.0 + last, 3));
}

// NIS beside the rise, which is a sum of χ².
Causes noise_beside(const ConsistencyVerdict& nis, const Rise& rise, const Findings& findings) {
  const std::size_t steps = nis.steps.size(), place = std::min(rise.place, steps);
  const std::size_t end =
      std::min(std::max(rise.end, place < steps ? end_of_rise(nis, place) : place), steps);
  const double before = p_value_of_sum(nis, 0, place), after = p_value_of_sum(nis, end, steps);
  const double p_value = std::min(1.0, 2.0 * std::min(before, after));
  if (!(p_value <= cause_level(findings))) return {};
  return {
      {Cause::process_or_measurement_noise,
       fmt::format("apart from that, mean NIS is {} times its dof before it, and {} times once it has faded "
                   "({}); its innovations hide the lags that would tell which",
                   number_text(1.0 + excess_of_steps(nis, 0, place), 3),
                   number_text(1.0 + excess_of_steps(nis, end, steps), 3), p_value_statement(p_value))}};
}

// Of NEES, or of NIS after the first fifth where NEES is not known or not wrong.
struct WrongStep {
  const ConsistencyVerdict& verdict;
  Rise rise;
  bool of_errors = false;
};

std::optional<WrongStep> wrong_step_of(const Findings& findings) {
  const ConsistencyVerdict &nees = findings.nees, &nis = findings.nis;
  if (const auto rise = lone_rise(nees, findings)) return WrongStep{nees, *rise, true};
  if (is_inconsistent(nees.verdict)) return std::nullopt;
  const auto rise = lone_rise(nis, findings);
  if (!rise || rise->place < first_fifth(nis)) return std::nullopt;
  return WrongStep{nis, *rise, false};
}

}  // namespace

bool outliers_are_of_one_step(const Findings& findings) {
  const auto wrong = wrong_step_of(findings);
  if (!wrong) return false;
  const std::vector<std::int64_t>& gross = findings.gross_outliers.at_steps;
  const auto at = [&gross](std::size_t place) {
    return gross.begin() + static_cast<std::ptrdiff_t>(std::min(place, gross.size()));
  };
  const auto within = std::accumulate(at(wrong->rise.place), at(wrong->rise.end), std::int64_t{0});
  return within > 0 && 2 * within >= findings.gross_outliers.all;
}

Causes find_wrong_step(const Findings& findings) {
  const auto wrong = wrong_step_of(findings);
  if (!wrong) return {};
  const auto& [verdict, rise, of_errors] = *wrong;
  const StepTest& step = verdict.steps[rise.place];
  const bool ends_at_once =
      of_errors && !is_inconsistent(findings.nis.verdict) &&
      excess_of_steps(verdict, rise.place + 1, rise.place + 2) < kAllButGone * excess_of(step);
  if (ends_at_once && !findings.nonlinear) return {};  // an error of the truth, which no later one has
  const auto text_of = [&wrong](std::size_t place) {
    return wrong->verdict.text_of_step(static_cast<std::int64_t>(place) + 1);
  };
  const std::size_t steps = verdict.steps.size(), end = rise.end < steps ? rise.end : rise.place + 1;
  const std::string lasting = lasting_text(verdict, rise.place);
  std::string again;
  for (const std::size_t k : later_rises(verdict, rise.place, 0.0, cause_level(findings)))
    append_item(again, text_of(k));
  Causes found = {
      {Cause::one_step,
       fmt::format("mean {} is {} times its dof until {}, where it is {} times, and {} times {}{}{}{}",
                   of_errors ? "NEES" : "NIS", number_text(1.0 + excess_of_steps(verdict, 0, rise.place), 3),
                   text_of(rise.place), number_text(1.0 + excess_of(step), 3),
                   number_text(1.0 + excess_of_steps(verdict, end, steps), 3),
                   rise.end < steps ? "once it has faded" : "after it",
                   again.empty() ? "" : "; it rises again at " + again, lasting,
                   ends_at_once ? "; the innovations fit: a glitch of the truth looks the same" : "")}};
  Causes beside = noise_beside(findings.nis, rise, findings);
  if (beside.empty() && !lasting.empty()) beside = find_bias(findings);
  found.insert(found.end(), beside.begin(), beside.end());
  return found;
}

}  // namespace credence::internal
