#include "reports/document/verdict_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "core/append_item.h"
#include "core/number_text.h"

namespace credence::internal {

std::string word_clause(const Word& word, const ConsistencyVerdict& nees,
                        std::span<const BlockVerdict> blocks) {
  std::string clause = word.says;
  const bool one_factor = nees.factor.reason.empty() && (nees.factor.lower > 1.0 || nees.factor.upper < 1.0);
  const std::string factor = number_text(nees.factor.mean, 3);
  if (one_factor && factor != "1.00" && word.verdict != Verdict::mixed && !word.no_factor) {
    const std::string left = left_by_scale(nees, blocks);
    clause += left.empty() ? fmt::format("; scaling P by {} would make the mean NEES right", factor)
                           : fmt::format("; scaling P by {} would make the mean NEES right but leave {}",
                                         factor, left);
  }
  return clause;
}

std::string filter_text(const FilterSettings& filter) {
  std::string text(to_string(filter.inflation));
  if (filter.inflation == FilterInflation::full || filter.inflation == FilterInflation::map) {
    text += fmt::format(", {}", to_string(filter.solution));
  }
  if (filter.inflation == FilterInflation::rank) {
    text += fmt::format(" {} ({})", filter.inflation_rank, to_string(filter.inflation_range));
  }
  if (filter.process_scale != 1.0) text += ", Q × " + short_text(filter.process_scale);
  if (filter.measurement_scale != 1.0) text += ", R × " + short_text(filter.measurement_scale);
  return text;
}

std::string not_converged_sentence(std::span<const RunNotConverged> runs, std::int64_t all) {
  constexpr std::size_t kNamed = 5;
  if (runs.empty()) return {};
  std::int64_t steps = 0;
  for (const RunNotConverged& of : runs) steps += of.steps;
  std::vector<std::int64_t> named;
  for (const RunNotConverged& of : runs.first(std::min(kNamed, runs.size()))) named.push_back(of.run);
  const std::string which =
      all == 1 ? "the only run"
               : fmt::format("{} of {} runs ({} {}{})", runs.size(), all, runs.size() == 1 ? "run" : "runs",
                             fmt::join(named, ", "), runs.size() > kNamed ? ", …" : "");
  return fmt::format(
      "In {} of {} the filter's iteration stopped before it had converged; its last iterate is used there.",
      counted(steps, "step"), which);
}

TableCell verdict_cell(Verdict verdict) {
  const CellTone tone = verdict == Verdict::consistent ? CellTone::good
                        : is_unsafe(verdict)           ? CellTone::alarm
                                                       : CellTone::caution;
  return {std::string(to_string(verdict)), tone};
}

std::string word_sentence(const std::string& name, const Word& word, const ConsistencyVerdict& nees,
                          std::span<const BlockVerdict> blocks) {
  return fmt::format("{}: {}.", name, word_clause(word, nees, blocks));
}

const StepTest* deciding_step(const ConsistencyVerdict& v) {
  if (v.decided_by_sensors || !is_inconsistent(v.verdict) || !v.decided_by_steps || v.worst_step < 0)
    return nullptr;
  return &v.steps[static_cast<std::size_t>(v.worst_step)];
}

std::string trusted_text(const ConsistencyVerdict& v) {
  if (v.decided_by_sensors) return "each sensor by itself";
  const StepTest* const step = deciding_step(v);
  if (step == nullptr)
    return fmt::format("{} … {}", number_text(v.bounds.lower), number_text(v.bounds.upper));
  return fmt::format("{} … {} at step {}, has {}", number_text(step->simultaneous_lower, 4),
                     number_text(step->simultaneous_upper, 4), v.step_of(v.worst_step + 1),
                     number_text(step->mean, 4));
}

std::string against_expected(const ConsistencyVerdict& v) {
  if (v.count == 0) return "–";
  return fmt::format("{} of {}", number_text(v.mean, 4), number_text(v.expected, 4));
}

std::string verdict_sentence(const char* what, const ConsistencyVerdict& v) {
  if (v.verdict == Verdict::undecided) return fmt::format("{}: undecided, {}.", what, v.reason);
  std::string text = fmt::format("{}: {}", what, to_string(v.verdict));
  if (v.decided_by_sensors) {
    text += fmt::format(
        ". Each sensor is judged by itself, and the smallest p-value counts, times the number of sensors "
        "({}). The mean of all {} values is {}, around {}",
        p_value_statement(v.p_value), v.count, number_text(v.mean, 4), number_text(v.expected, 4));
  } else {
    text += fmt::format(
        ". The mean of {} over {} values would be accepted from {} to {}, around {} ({:g} % confidence, {}, "
        "{} tests)",
        number_text(v.mean, 4), v.count, number_text(v.bounds.lower, 4), number_text(v.bounds.upper, 4),
        number_text(v.expected, 4), 100.0 * v.confidence, p_value_statement(v.p_value), v.tests);
    if (const StepTest* const step = deciding_step(v)) {
      text += fmt::format("; what decided is {}, whose mean of {} would be accepted from {} to {}",
                          v.text_of_step(v.worst_step + 1), number_text(step->mean, 4),
                          number_text(step->simultaneous_lower, 4), number_text(step->simultaneous_upper, 4));
    }
  }
  text +=
      fmt::format("; {} % of the steps lie outside their own bounds, where {} % are expected",
                  number_text(100.0 * v.share_outside, 3), number_text(100.0 * v.expected_share_outside, 3));
  constexpr double kMany = 2.0;
  if (v.verdict == Verdict::consistent && v.share_outside > kMany * v.expected_share_outside) {
    text +=
        " on average: errors last over steps, so that of one right filter many lie outside and of another "
        "none";
  }
  return text + ".";
}

}  // namespace credence::internal
