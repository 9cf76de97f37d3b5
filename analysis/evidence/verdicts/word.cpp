#include "analysis/evidence/verdicts/word.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/laws/joint/joint_tests.h"
#include "core/append_item.h"

namespace credence::internal {
namespace {

/// Both directions; a verdict's p-values are two-sided.
std::array<DirectedTest, 2> directions(const ConsistencyVerdict& v) {
  return {DirectedTest{Departure::optimistic, 0.5 * v.optimistic_p_value},
          DirectedTest{Departure::pessimistic, 0.5 * v.pessimistic_p_value}};
}

/// The part that says most in one direction: of the state before NEES and NIS, since it says where.
const WordPart* foremost(std::span<const WordPart> parts, const JointTests& joint, std::size_t side,
                         double alpha) {
  const auto rank = [](const WordPart& part) { return part.named_last ? 2 : part.says_where ? 0 : 1; };
  for (const int of_rank : {0, 1, 2}) {
    const WordPart* best = nullptr;
    double smallest = alpha;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double p = joint.adjusted[i][side];
      if (rank(parts[i]) != of_rank || !(p <= smallest)) continue;
      if (best != nullptr && p == smallest) continue;
      smallest = p;
      best = &parts[i];
    }
    if (best != nullptr) return best;
  }
  return nullptr;
}

/// Whether it is all that is judged of a sensor.
bool is_sensor(const WordPart& part) { return part.of_innovations && !part.named_last; }

/// ", and of 2 more sensors": of which the first is named.
std::string further_sensors(std::span<const WordPart> parts, const JointTests& joint, std::size_t side,
                            double alpha) {
  std::int64_t rejected = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (is_sensor(parts[i]) && joint.adjusted[i][side] <= alpha) ++rejected;
  }
  if (rejected < 2) return "";
  return fmt::format(", and of {} more sensor{}", rejected - 1, rejected == 2 ? "" : "s");
}

/// "NEES at others" where "NEES at some times" is named before it, which it is without that.
std::string name_after(std::span<const std::string> named, const std::string& name) {
  constexpr std::string_view kOthers = kAtOthers;
  if (!name.ends_with(kOthers)) return name;
  const std::string at_some_times = name.substr(0, name.size() - kOthers.size()) + kAtSomeTimes;
  return std::ranges::find(named, at_some_times) == named.end() ? at_some_times : name;
}

void say(std::span<const WordPart> parts, const JointTests& joint, double alpha, Word& word) {
  const std::array sides{Verdict::optimistic, Verdict::pessimistic};
  for (std::size_t side = 0; side < 2; ++side) {
    const WordPart* const part = foremost(parts, joint, side, alpha);
    if (part == nullptr) continue;
    const std::string when = when_text(*part->verdict, sides[side]);
    const bool other_name = sides[side] == Verdict::pessimistic && !part->pessimistic_name.empty();
    const std::string name = name_after(word.named, other_name ? part->pessimistic_name : part->name);
    append_item(word.says,
                fmt::format("{} in {}{}{}{}", to_string(sides[side]), name, when.empty() ? "" : " ", when,
                            is_sensor(*part) ? further_sensors(parts, joint, side, alpha) : ""),
                "; ");
    word.named.push_back(name);
  }
}

}  // namespace

std::string when_text(const ConsistencyVerdict& v, Verdict direction) {
  const StepSpan& span = direction == Verdict::optimistic ? v.optimistic_steps : v.pessimistic_steps;
  const StepSpan& other = direction == Verdict::optimistic ? v.pessimistic_steps : v.optimistic_steps;
  if (v.steps_tested == 1) return "";
  // Where the mean decides, few steps far from each other are those in which it happens to show.
  constexpr std::int64_t kFew = 10;  // of so many steps one
  const bool apart = span.count == 1 || 2 * span.count < span.last - span.first + 1;
  const bool by_mean = !v.decided_by_steps && apart && kFew * span.count < v.steps_tested;
  if (span.count == 0 || by_mean) return v.steps_tested > 1 ? "on average over the steps" : "";
  if (span.count == 1) return "at " + v.text_of(span);
  const auto steps = std::ssize(v.steps);
  const bool lasts = span.last == steps || (!v.decided_by_steps && other.count == 0);
  if (span.first == 1 && lasts) return "throughout";
  if (lasts) {
    return fmt::format("from step {} on{}", v.step_of(span.first), v.time_text(span.first, span.first));
  }
  return "in " + v.text_of(span);
}

std::vector<WordPart> word_parts(const ConsistencyVerdict& nees, const ConsistencyVerdict& nis,
                                 std::span<const BlockVerdict> blocks) {
  std::vector<WordPart> parts = {{"NEES", &nees, kWordNees}, {"NIS", &nis, kWordNis, false, true}};
  for (const BlockVerdict& block : blocks) {
    parts.push_back({block.name, &block.verdict, kWordBlocks / static_cast<double>(blocks.size()), true});
  }
  return parts;
}

Word join_verdicts(std::span<const WordPart> parts, double confidence) {
  std::vector<std::array<DirectedTest, 2>> tests;
  tests.reserve(parts.size());
  std::vector<TestFamily> families;
  for (const WordPart& part : parts) {
    tests.push_back(directions(*part.verdict));
    families.push_back({.weight = part.weight, .tests = tests.back()});
  }
  const JointTests joint = join_tests(families);
  const double alpha = 1.0 - confidence;
  const Verdict verdict = direction_of(joint.optimistic(alpha), joint.pessimistic(alpha));
  Word word{.verdict = verdict,
            .p_value = joint.p_value,
            .says = {},
            .no_factor = false,
            .of_S_alone = is_inconsistent(verdict),
            .joined = {}};
  say(parts, joint, alpha, word);
  bool undecided = std::isnan(joint.p_value);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double up = joint.adjusted[i][0], down = joint.adjusted[i][1];
    const ConsistencyVerdict& v = *parts[i].verdict;
    if (!parts[i].of_innovations && (up <= alpha || down <= alpha)) word.of_S_alone = false;
    const bool no_data = std::isnan(up) && std::isnan(down);
    const bool open = v.verdict == Verdict::undecided;
    undecided = undecided || (open && v.count > 0 && !parts[i].says_where);
    word.joined.push_back({parts[i].name,
                           no_data || open ? Verdict::undecided : direction_of(up <= alpha, down <= alpha),
                           std::fmin(up, down)});
  }
  if (word.verdict == Verdict::consistent && undecided) word.verdict = Verdict::undecided;
  return word;
}

}  // namespace credence::internal
