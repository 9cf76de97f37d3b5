#include "analysis/evidence/verdicts/judgement_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/sums/step_normaliser.h"
#include "analysis/evidence/verdicts/judgement_tests.h"
#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

/// A test of averages over the steps, as a part of the word.
ConsistencyVerdict averaged_verdict(const DirectedPValues& p_value, std::int64_t steps, std::int64_t count) {
  ConsistencyVerdict verdict;
  verdict.verdict = Verdict::consistent;
  verdict.optimistic_p_value = p_value.optimistic;
  verdict.pessimistic_p_value = p_value.pessimistic;
  verdict.steps_tested = steps;
  verdict.count = count;
  return verdict;
}

/// What is too large at several steps, all of them in the first tenth, where heavy tails alone hardly gather;
/// null: nothing is.
const ConsistencyVerdict* wrong_at_start(const Judgement& j) {
  constexpr std::int64_t kFewest = 3, kTenths = 10;
  const auto is_wrong = [](const ConsistencyVerdict& v) {
    return v.optimistic_steps.count >= kFewest && kTenths * v.optimistic_steps.last <= std::ssize(v.steps);
  };
  if (is_wrong(j.nees)) return &j.nees;
  for (const BlockVerdict& block : j.blocks) {
    if (is_wrong(block.verdict)) return &block.verdict;
  }
  return nullptr;
}

constexpr std::string_view kZeroErrors = "every error is exactly zero";
constexpr std::string_view kZeroInnovations = "every innovation is exactly zero";

bool is_zero(const ConsistencyVerdict& v) { return v.count > 0 && v.mean == 0.0 && v.expected > 0.0; }

/// Of failed runs and rejected rows, beyond which the others do not speak for the filter.
constexpr double kMostLost = 0.05;

void leave_word_open(std::string reason, Judgement& j) {
  j.word.verdict = Verdict::undecided;
  j.word.says.clear();
  j.nees.reason = std::move(reason);
}

/// What the word is made of: the verdicts of a judgement, and what its averages over the steps say.
class WordParts {
 public:
  WordParts(const Evidence& e, const Judgement& j) : j_(j), parts_(word_parts(j.nees, j.nis, j.blocks)) {
    split_sensors();
    for (const SensorJudgement& sensor : j.sensors) add_components(sensor);
    add_nees_over_time();
    for (const SensorJudgement& sensor : j.sensors) {
      add_over_time(of_sensor("NIS", sensor), sensor.over_time, sensor.nis,
                    kWordOverTime / static_cast<double>(j.sensors.size()), true);
    }
    add_directions(std::ssize(e.study.steps));
    const ClaimedSigmaTest& claimed = j.claimed_sigma;
    add_claimed(claimed.optimistic, {claimed.optimistic.p_value, kNaN});
    add_claimed(claimed.pessimistic, {kNaN, claimed.pessimistic.p_value});
  }

  std::span<const WordPart> all() const { return parts_; }

 private:
  void add(WordPart part, const ConsistencyVerdict& average) {
    averages_.push_back(average);
    part.verdict = &averages_.back();
    parts_.push_back(std::move(part));
  }

  /// Of several sensors NIS of each in place of that of all.
  void split_sensors() {
    if (j_.sensors.size() <= 1) return;
    const double each = parts_[1].weight / static_cast<double>(j_.sensors.size());
    parts_.erase(parts_.begin() + 1);
    for (const SensorJudgement& s : j_.sensors)
      parts_.push_back({"NIS of " + s.name, &s.nis, each, false, true});
  }

  /// The components of an innovation, and every two of them, have half of the share of its NIS.
  void add_components(const SensorJudgement& sensor) {
    if (!sensor.components.reason.empty()) return;
    const auto nis =
        std::ranges::find(parts_, j_.sensors.size() == 1 ? &j_.nis : &sensor.nis, &WordPart::verdict);
    nis->weight *= 0.5;
    const double half = (sensor.pairs.components.empty() ? 1.0 : 0.5) * nis->weight;
    const auto add_each = [&](const ComponentTest& test, std::string (*name)(const SensorJudgement&, Index)) {
      const double each = half / static_cast<double>(test.components.size());
      for (Index k = 0; const ComponentVariance& c : test.components) {
        add({.name = name(sensor, k++), .weight = each, .of_innovations = true, .named_last = true},
            averaged_verdict(c.p_value, c.count, c.count));
      }
    };
    add_each(sensor.components, component_name);
    add_each(sensor.pairs, pair_name);
  }

  /// That it goes up and down is one fault, of the side that is farther from what it should be, and of the
  /// other one where that is beyond two standard errors too.
  void add_over_time(const std::string& of, const Modulation& over_time, const ConsistencyVerdict& v,
                     double weight, bool of_S) {
    constexpr double kClearly = 2.0;
    const double p = over_time.p_value, mean = v.mean / v.expected;
    if (std::isnan(p)) return;
    const double above = mean * over_time.high.mean - 1.0, below = 1.0 - mean * over_time.low.mean;
    const bool too_large = above > below || above > kClearly * mean * over_time.high.error;
    const bool too_small = below > above || below > kClearly * mean * over_time.low.error;
    const auto add_when = [&](const char* when, const DirectedPValues& p_value) {
      add({.name = of + when, .weight = 0.5 * weight, .of_innovations = of_S, .named_last = true},
          averaged_verdict(p_value, 1, v.count));
    };
    add_when(kAtSomeTimes, {too_large ? p : 1.0, kNaN});
    add_when(kAtOthers, {kNaN, too_small ? p : 1.0});
  }

  void add_nees_over_time() {
    for (const NeesOverTime& nees : j_.nees_over_time) {
      const auto block = std::ranges::find(j_.blocks, nees.of, &BlockVerdict::name);
      const ConsistencyVerdict& v = block == j_.blocks.end() ? j_.nees : block->verdict;
      const double parts_of_it = static_cast<double>(j_.nees_over_time.size() - 1);
      const double share = parts_of_it == 0.0 ? 1.0 : nees.of.empty() ? 0.5 : 0.5 / parts_of_it;
      add_over_time(nees.part(), nees, v, share * kWordOverTime, false);
    }
  }

  void add_directions(std::int64_t steps) {
    const SecondMomentJudgement& second = j_.law.second_moments;
    if (!second.test.reason.empty()) return;
    add({.name = "the direction of " + second.most_optimistic,
         .weight = kWordDirections,
         .says_where = true,
         .pessimistic_name = "the direction of " + second.most_pessimistic},
        averaged_verdict(second.test.p_value, steps, second.test.runs));
  }

  void add_claimed(const ClaimedSigmaTest::Side& side, const DirectedPValues& p_value) {
    if (std::isnan(side.p_value)) return;
    add({.name = side.in, .weight = 0.5 * kWordClaimedSigma, .says_where = true},
        averaged_verdict(p_value, 1, j_.claimed_sigma.units));
  }

  const Judgement& j_;
  std::vector<WordPart> parts_;
  std::deque<ConsistencyVerdict> averages_;  ///< whose places stay
};

/// A word that is said of all runs where a few alone are wrong.
void name_lost_runs(const Judgement& j, Word& word) {
  word.no_factor = true;
  const bool alone = word.verdict == Verdict::optimistic && j.lost.others_are_right();
  const std::string runs = names_of(j.lost);
  word.says = alone ? fmt::format("optimistic in {} alone", runs)
                    : fmt::format("{}; above all in {}", word.says, runs);
  if (j.lost.runs.size() == 1)
    word.says += fmt::format(", from {} on", place_of(j.lost.runs.front(), j.lost.by_step, j.nees));
}

void say_not_gaussian(const Judgement& j, Word& word) {
  word.verdict = Verdict::not_gaussian;
  const ConsistencyVerdict* const start = wrong_at_start(j);
  word.says = start == nullptr
                  ? "the covariance is right, the errors are not Gaussian (heavy tails)"
                  : fmt::format(
                        "the covariance is right but perhaps in {}, where it is too small or the tails "
                        "are heavier; the errors are not Gaussian (heavy tails)",
                        start->text_of(start->optimistic_steps));
}

}  // namespace

Word word_of(const Evidence& e, const Judgement& j) {
  Word word = join_verdicts(WordParts(e, j).all(), j.confidence);
  if (!is_inconsistent(word.verdict)) return word;
  if (!j.lost.runs.empty()) {
    name_lost_runs(j, word);
  } else if (j.law.gaussianity.right_but_heavy_tailed(1.0 - j.confidence)) {
    say_not_gaussian(j, word);
  }
  return word;
}

void follow_word(const Word& word, std::span<const BlockVerdict> blocks, ResponsibleBlock& responsible) {
  for (const std::string& name : word.named) {
    const auto block = std::ranges::find(blocks, name, &BlockVerdict::name);
    if (block == blocks.end()) continue;
    responsible = {.index = block - blocks.begin()};
    return;
  }
}

void judge_fitted(TruthFit fit, Judgement& j) {
  const double alpha = 1.0 - j.confidence;
  double p = j.nees.overall_p_value;
  if (j.single && !std::isnan(j.single->time_average.p_value)) {
    const double stretches = j.single->time_average.p_value;
    p = std::isnan(p) ? stretches : std::min(1.0, 2.0 * std::min(p, stretches));
  }
  const bool optimistic = fit == TruthFit::least_nees && j.nees.mean > j.nees.expected && p <= alpha;
  const std::string open =
      fit == TruthFit::least_nees
          ? "the truth was fitted to these errors, which may be what makes them deviate"
          : "where the truth belongs is not known, which may be what makes errors deviate";
  const auto leave = [&](ConsistencyVerdict& v) {
    if (!is_inconsistent(v.verdict)) return;
    v.verdict = Verdict::undecided;
    v.reason = open;
  };
  for (BlockVerdict& block : j.blocks) leave(block.verdict);
  if (j.vehicle_nees) leave(*j.vehicle_nees);
  if (optimistic) {
    j.nees.verdict = j.word.verdict = Verdict::optimistic;
    j.nees.decided_by_steps = false;
    j.word.says = "optimistic in the mean NEES, wherever the truth lies";
  } else {
    leave(j.nees);
    if (j.word.verdict != Verdict::consistent) j.word.verdict = Verdict::undecided;
    j.word.says.clear();
    if (j.word.verdict == Verdict::undecided && j.nees.reason.empty()) j.nees.reason = open;
  }
  j.word.p_value = j.nees.mean > j.nees.expected ? p : 1.0;
  j.word.joined.clear();
}

namespace {

/// A part of the word that is made of steps, and what its worst step was made of.
struct PartOfSteps {
  const ConsistencyVerdict* verdict = nullptr;  ///< null: it is made of averages
  Moments worst{};                              ///< over the runs
  bool white = false;  ///< innovations: rows one after another have nothing in common
};

PartOfSteps part_of_steps(const Evidence& e, const Judgement& j, std::string_view name) {
  const auto part = [&](const ConsistencyVerdict& v, const std::vector<Moments>& steps, bool white) {
    const auto worst = static_cast<std::size_t>(std::max<std::int64_t>(0, v.worst_step));
    return PartOfSteps{&v, worst < steps.size() ? steps[worst] : Moments{}, white};
  };
  if (name == "NEES") return part(j.nees, e.study.series(Quantity::nees), false);
  if (name == "NIS") return part(j.nis, e.study.series(Quantity::nis), true);
  const std::size_t steps = e.study.steps.size();
  for (std::size_t i = 0; i < j.blocks.size(); ++i) {
    if (j.blocks[i].name == name)
      return part(j.blocks[i].verdict, series_of(e.blocks[i].nees, steps).moments, false);
  }
  for (std::size_t i = 0; i < j.sensors.size(); ++i) {
    if (of_sensor("NIS", j.sensors[i]) == name)
      return part(j.sensors[i].nis, series_of(e.sensors[i].nis, steps).moments, true);
  }
  return {};
}

/// Whether heavy tails may be what is too large at steps: no mean is, at the worst step one run and not
/// several, and of innovations, which are white, no steps that are close together.
bool may_be_of_tails(const PartOfSteps& part, double alpha) {
  constexpr double kOneRun = 1.5;  // standard errors: of one value that is much larger than the others, 1
  constexpr std::int64_t kBurst = 3, kApart = 5;
  const ConsistencyVerdict& v = *part.verdict;
  if (v.overall_p_value <= alpha || v.worst_step < 0) return false;
  const Moments& at = part.worst;
  const double expected = v.steps[static_cast<std::size_t>(v.worst_step)].expected;
  if (at.count > 1 && at.mean - expected > kOneRun * std::sqrt(at.variance() / static_cast<double>(at.count)))
    return false;
  const StepSpan& steps = v.optimistic_steps;
  return !part.white || steps.count < kBurst || steps.last - steps.first + 1 >= kApart * steps.count;
}

}  // namespace

void leave_heavy_open(const Evidence& e, Judgement& j) {
  const GaussianityJudgement& g = j.law.gaussianity;
  const double alpha = 1.0 - j.confidence;
  if (!is_inconsistent(j.word.verdict) || j.word.no_factor || !j.lost.runs.empty()) return;
  const bool law_free = !std::isnan(g.moments_p_value);
  if (!(g.tail_p_value <= alpha) || (law_free && g.moments_p_value <= alpha)) return;
  const bool on_average = j.single && j.single->time_average.p_value <= alpha;
  PartOfSteps first;
  for (const JoinedVerdict& joined : j.word.joined) {
    if (!is_inconsistent(joined.verdict)) continue;
    const PartOfSteps part = part_of_steps(e, j, joined.name);
    if (part.verdict == nullptr || joined.verdict != Verdict::optimistic || (on_average && !part.white) ||
        !may_be_of_tails(part, alpha))
      return;
    if (first.verdict == nullptr) first = part;
  }
  if (first.verdict == nullptr) return;
  leave_word_open(
      fmt::format(
          "single {} are too large ({}), but the errors have heavy tails, with which some are, and {}",
          first.white ? "innovations" : "rows", when_text(*first.verdict, Verdict::optimistic),
          law_free ? "tests that need no law find nothing wrong"
                   : "the runs are too short for tests that need no law"),
      j);
}

void leave_failed_open(const StudyStatistics& all, Judgement& j) {
  if (is_unsafe(j.word.verdict)) return;
  const auto failed = std::ssize(all.failures);
  if (static_cast<double>(failed) <= kMostLost * static_cast<double>(all.runs)) return;
  leave_word_open(
      failed_text(failed, all.runs) + (failed < all.runs ? ", and the others do not speak for them" : ""), j);
}

void leave_rejected_open(const Evidence& e, Judgement& j) {
  std::int64_t judged = e.has_truth ? j.nees.count : j.nis.count;
  for (const BlockVerdict& block : j.blocks) judged = std::max(judged, block.verdict.count);
  // The engine judges rows of its own by the states that have a variance.
  const std::int64_t rejected = e.rejected_rows(), all = std::min(rejected + judged, e.rows);
  const auto singular = e.rejected.find(std::string(kClaimedCertainty));
  if (singular != e.rejected.end() && 2 * singular->second.count > all) {
    return leave_word_open(
        fmt::format(
            "in {} of {} rows the error lies in part in a direction in which P is singular, and whether "
            "it does in the others is a matter of rounding: log errors of as few components as P has "
            "directions, as the three of an attitude and not the four of its quaternion",
            singular->second.count, all),
        j);
  }
  if (is_unsafe(j.word.verdict)) return;
  if (static_cast<double>(rejected) <= kMostLost * static_cast<double>(all)) return;
  const auto count = [](const auto& of_reason) { return of_reason.second.count; };
  leave_word_open(
      fmt::format("{} of {} rows are rejected (most of them: {}), and the others do not speak for them",
                  rejected, all, std::ranges::max_element(e.rejected, {}, count)->first),
      j);
}

void open_zero_rows(Judgement& j) {
  const auto open = [](ConsistencyVerdict& v, std::string_view reason) {
    if (!is_zero(v)) return;
    v.verdict = Verdict::undecided;
    v.p_value = v.optimistic_p_value = v.pessimistic_p_value = kNaN;
    v.reason = reason;
  };
  if (is_zero(j.nees)) {
    open(j.nees, kZeroErrors);
    for (BlockVerdict& block : j.blocks) open(block.verdict, kZeroErrors);
  }
  open(j.nis, kZeroInnovations);
  for (SensorJudgement& sensor : j.sensors) {
    if (!is_zero(sensor.nis)) continue;
    open(sensor.nis, kZeroInnovations);
    sensor.components = sensor.pairs = {.reason = kZeroInnovations};
    sensor.over_time = {};
  }
}

void leave_zeros_open(Judgement& j) {
  if (is_zero(j.nis)) j.scale_innovation = no_scale(kZeroInnovations);
  const std::string_view reason = is_zero(j.nees)                       ? kZeroErrors
                                  : j.nees.count == 0 && is_zero(j.nis) ? kZeroInnovations
                                                                        : "";
  if (!reason.empty()) {
    leave_word_open(std::string(reason), j);
    return refuse_factor(reason, j);
  }
  const auto off = std::ranges::find_if(j.sensors, [](const SensorJudgement& s) { return is_zero(s.nis); });
  if (off == j.sensors.end() || j.word.verdict != Verdict::undecided || !j.nees.reason.empty()) return;
  j.nees.reason = j.sensors.size() == 1 ? std::string(kZeroInnovations)
                                        : fmt::format("every innovation of {} is exactly zero", off->name);
}

bool are_of_one_size(const Moments& nees) {
  constexpr std::int64_t kFewRows = 20;
  constexpr double kRounding = 1e-12;
  if (nees.count < kFewRows || !(nees.mean > 0.0)) return false;
  return std::sqrt(nees.m2 / static_cast<double>(nees.count)) <= kRounding * nees.mean;
}

void leave_one_size_open(const Evidence& e, Judgement& j) {
  const Moments& nees = e.whole_runs.nees_values;
  if (j.word.verdict != Verdict::consistent || !are_of_one_size(nees)) return;
  leave_word_open(
      fmt::format("every NEES is {}, and errors of one size are no sample", number_text(nees.mean, 4)), j);
}

void leave_certain_open(const Evidence& e, Judgement& j) {
  const bool judged = j.nees.count > 0 || j.nis.count > 0;
  if (is_unsafe(j.word.verdict) || (judged && j.word.verdict == Verdict::undecided)) return;
  std::vector<std::string> states;
  for (const auto& [state, rows] : e.wrongly_certain) {
    if (static_cast<double>(rows.count) > kMostLost * static_cast<double>(e.rows)) states.push_back(state);
  }
  if (states.empty()) return;
  leave_word_open(
      fmt::format("{} {} of {} rows where P claims certainty (variance 0){}",
                  first_items(states, 6) + (states.size() == 1 ? " errs in" : " err in up to"),
                  e.wrongly_certain_rows(), e.rows,
                  judged ? fmt::format("; what else is judged is {}", to_string(j.word.verdict)) : ""),
      j);
}

void leave_coloured_open(Judgement& j) {
  if (j.word.verdict != Verdict::consistent && j.word.verdict != Verdict::not_gaussian) return;
  const auto coloured = std::ranges::find_if(
      j.sensors, [&](const SensorJudgement& s) { return speaks(j, of_sensor(kWhiteness, s)); });
  if (coloured == j.sensors.end()) return;
  leave_word_open(
      fmt::format(
          "the mean NIS is right, but the innovations{} are not white ({}): the gain is not the best one, "
          "so that P need not be right",
          coloured->name.empty() ? "" : " of " + coloured->name,
          p_value_statement(coloured->whiteness.p_value)),
      j);
}

void refuse_factor(std::string_view reason, Judgement& j) {
  j.scale_covariance = no_scale(reason);
  j.word.no_factor = true;
}

}  // namespace credence::internal
