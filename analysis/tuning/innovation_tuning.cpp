#include "analysis/tuning/innovation_tuning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/normal_quantile.h"
#include "core/enum_words.h"
#include "core/number_text.h"
#include "core/record/unwrapped_angles.h"

namespace credence::internal {
namespace {

constexpr std::size_t kFewestRunsLeftOut = 3;  // that are left out one by one
constexpr std::size_t kStretchesOfRun = 5;     // of fewer runs

struct NisPart {
  double sum = 0.0, count = 0.0;
};

std::vector<NisPart> parts_of(const SensorRecord& record) {
  std::vector<NisPart> parts;
  const std::size_t stretches = record.runs.size() < kFewestRunsLeftOut ? kStretchesOfRun : 1;
  for (const RecordedInnovations& run : record.runs) {
    for (std::size_t i = 0; i < stretches; ++i) {
      const std::size_t first = i * run.nis.size() / stretches, last = (i + 1) * run.nis.size() / stretches;
      if (last == first) continue;
      const auto begin = run.nis.begin();
      parts.push_back({std::accumulate(begin + static_cast<std::ptrdiff_t>(first),
                                       begin + static_cast<std::ptrdiff_t>(last), 0.0),
                       static_cast<double>(last - first)});
    }
  }
  return parts;
}

/// Two-sided, of the ratio of two independent means of χ².
double ratio_p_value(double ratio, double dof, double other_dof) {
  return std::min(1.0,
                  2.0 * std::min(f_survival(ratio, dof, other_dof), f_survival(1.0 / ratio, other_dof, dof)));
}

/// The variance of NIS over that of the χ² law, at least 1: of heavy tails means of it are worth so many
/// fewer.
double spread_of_nis(const SensorRecord& record, double dof) {
  Moments nis;
  for (const RecordedInnovations& run : record.runs)
    for (const double x : run.nis) nis.add(x);
  if (nis.count < 2 || !(nis.mean > 0.0)) return 1.0;
  return std::max(1.0, 0.5 * dof * nis.variance() / (nis.mean * nis.mean));
}

LeftOut leave_out(const SensorRecord& record, double dof, bool white, double spread, double confidence) {
  const std::vector<NisPart> parts = parts_of(record);
  LeftOut result;
  result.of_runs = record.runs.size() >= kFewestRunsLeftOut;
  result.parts = std::ssize(parts);
  if (parts.size() < 2) return result;
  NisPart all;
  double most = 0.0;
  for (const NisPart& part : parts) {
    all.sum += part.sum;
    all.count += part.count;
    most = std::max(most, part.sum);
  }
  if (!(most < all.sum)) return result;  // all but one of them, or all, are zero
  std::vector<double> p_values;
  std::vector<bool> above;
  double mean = 0.0;
  for (const NisPart& part : parts) {
    const double scale = (all.sum - part.sum) / (dof * (all.count - part.count));
    const double expected = dof * part.count;
    if (white)
      p_values.push_back(ratio_p_value(part.sum / (scale * expected), expected / spread,
                                       (dof * all.count - expected) / spread));
    above.push_back(part.sum / scale > expected);
    mean += part.sum / scale;
  }
  result.mean_nis = mean / all.count;
  if (!white) return result;
  result.tested = true;
  const std::vector<double> adjusted = holm(p_values);
  bool optimistic = false, pessimistic = false;
  for (std::size_t i = 0; i < adjusted.size(); ++i) {
    if (adjusted[i] > 1.0 - confidence) continue;
    ++result.rejected;
    (above[i] ? optimistic : pessimistic) = true;
  }
  result.verdict = direction_of(optimistic, pessimistic);
  return result;
}

GainError gain_error(const WhitenessTest& whiteness) {
  if (whiteness.white || std::isnan(whiteness.p_value)) return GainError::none_seen;
  const double lag_one = whiteness.autocorrelation.front();
  if (std::abs(lag_one) <= whiteness.band.front()) return GainError::other;
  return lag_one > 0.0 ? GainError::too_small : GainError::too_large;
}

std::string what_comes_first(const SensorRecord& record, const InnovationTests& tests, double confidence) {
  constexpr std::size_t kMean = 3;  // of InnovationTests::adjusted_p_value
  if (record.unwrapped > 0) return unwrapped_text(record.unwrapped);
  if (tests.nis.mean == 0.0)
    return "every innovation is exactly zero: a sensor that is off is not to be logged";
  std::string turned = turns_text(record.name, record.turns);
  if (!turned.empty()) return turned;
  if (!(tests.adjusted_p_value[kMean] <= 1.0 - confidence)) return "";
  return fmt::format("the innovations have mean {} standard deviations ({})",
                     number_text(tests.mean.cwiseAbs().maxCoeff(), 2), p_value_statement(tests.mean_p_value));
}

std::string gain_note(GainError gain) {
  switch (gain) {
    case GainError::none_seen:
      return "The innovations look white: the gain is not seen to be wrong, and the scale is one of P0, Q "
             "and R together.";
    case GainError::too_small:
      return "The innovations are positively correlated: the gain is too small, Q over R should be larger. A "
             "scale alone mends the mean of NIS and not this.";
    case GainError::too_large:
      return "The innovations alternate: the gain is too large, Q over R should be smaller. A scale alone "
             "mends the mean of NIS and not this.";
    case GainError::other: break;
  }
  return "The innovations are correlated, but not from one to the next: neither Q nor R explains that.";
}

void add_notes(InnovationTuning& t) {
  auto& notes = t.notes;
  notes.emplace_back(
      "A log of innovations and S does not hold F and H: Q and R cannot be separated. What can be told is "
      "the scale of S and on which side the gain is wrong. The factor on each noise takes the filter itself: "
      "credence.tune_filter in Python, FilterScore in C++.");
  if (t.comes_first.empty()) {
    notes.push_back(gain_note(t.gain));
  } else {
    notes.push_back(fmt::format(
        "{}{}. No noise mends that; before it is mended neither the scale of S nor the side of the gain "
        "is to be trusted.",
        kComesFirst, t.comes_first));
  }
  if (t.gain != GainError::none_seen) {
    notes.emplace_back(
        "The likelihood ratio and the test of parts that are left out need white innovations, and are not "
        "made here.");
  }
  if (!t.scale.reason.empty()) notes.push_back(fmt::format("The scale has no interval: {}.", t.scale.reason));
  if (t.left_out > 0) notes.push_back(fmt::format("{} innovations could not be used.", t.left_out));
}

}  // namespace

std::string_view to_string(GainError error) {
  return word_of(error, {"none seen", "too small", "too large", "other"});
}

InnovationTuning tune_innovations(const SensorRecord& record, double confidence, std::int64_t sensors) {
  InnovationTuning t;
  t.name = record.name;
  t.left_out = record.left_out;
  double sum = 0.0;
  for (const RecordedInnovations& run : record.runs) {
    t.dof = run.dof;
    t.values += std::ssize(run.nis);
    sum = std::accumulate(run.nis.begin(), run.nis.end(), sum);
  }
  if (t.values == 0) throw std::invalid_argument("there are no innovations with a covariance");
  const InnovationTests tests = test_recorded_innovations(record.runs, confidence, sensors);
  const double of_tests = confidence_of_each(confidence, sensors);
  t.scale = tests.noise_scale;
  if (t.scale.lower > 0.0) {
    const double z = normal_quantile_two_sided(confidence);
    const double relative = std::log(t.scale.upper / t.scale.lower) / (2.0 * z);
    t.steps_for_10_percent = static_cast<double>(t.values) * relative * relative / 0.01;
  }
  t.whiteness_p_value = tests.whiteness.p_value;
  if (!tests.whiteness.autocorrelation.empty()) {
    t.lag_one = tests.whiteness.autocorrelation.front();
    t.band = tests.whiteness.band.front();
  }
  t.gain = gain_error(tests.whiteness);
  t.comes_first = what_comes_first(record, tests, of_tests);
  const auto count = static_cast<double>(t.values);
  const double constant = t.dof * std::log(2.0 * std::numbers::pi) + record.log_determinant / count;
  const double mean = sum / count, scale = mean / t.dof, spread = spread_of_nis(record, t.dof);
  t.score_before = -0.5 * (constant + mean);
  if (scale > 0.0) t.score_after = -0.5 * (constant + t.dof * std::log(scale) + t.dof);
  if (scale > 0.0 && t.gain == GainError::none_seen) {
    t.likelihood_ratio_p_value =
        chi_square_survival(2.0 * count * std::max(0.0, t.score_after - t.score_before) / spread, 1.0);
  }
  t.left_out_parts = leave_out(record, t.dof, t.gain == GainError::none_seen, spread, of_tests);
  add_notes(t);
  return t;
}

}  // namespace credence::internal
