#include "reports/document/logs/compare_means.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// The factor on P or S that the mean of a part asks for, its interval that of the factors with which the
/// mean lies within its bounds.
struct MeanOfPart {
  std::string name;
  std::string_view on;
  double factor = 0.0, lower = 0.0, upper = 0.0;
  double quantile = 0.0;  ///< standard deviations of a Gaussian at the level of the bounds
};

void add_part(MeanOfPart part, double mean, double expected, const ChiSquareBounds& bounds, double confidence,
              bool single_test, std::vector<MeanOfPart>& parts) {
  part.factor = mean / expected;
  part.lower = mean / bounds.upper;
  part.upper = mean / bounds.lower;
  if (!(part.lower > 0.0 && part.upper < HUGE_VAL && part.factor > 0.0)) return;
  const double alpha = 1.0 - confidence;
  part.quantile = std::sqrt(chi_square_upper_quantile(single_test ? alpha : 0.5 * alpha, 1.0));
  parts.push_back(std::move(part));
}

std::string sensor_part(const std::string& name) { return name.empty() ? "NIS" : "NIS of " + name; }

std::vector<MeanOfPart> means_of(const Judgement& j) {
  std::vector<MeanOfPart> parts;
  const auto add = [&](std::string name, std::string_view on, const ConsistencyVerdict& v) {
    add_part({.name = std::move(name), .on = on}, v.mean, v.expected, v.bounds, v.confidence, v.tests == 1,
             parts);
  };
  add("NEES", "P", j.nees);
  for (const BlockVerdict& block : j.blocks) add(block.name, "P", block.verdict);
  for (const SensorJudgement& sensor : j.sensors) add(sensor_part(sensor.name), "S", sensor.nis);
  return parts;
}

/// Of a document of `check`; parts without bounds are left out.
std::vector<MeanOfPart> means_of(const Json& document) {
  std::vector<MeanOfPart> parts;
  const auto add = [&](std::string name, std::string_view on, const Json& verdict) {
    const auto number = [](const Json& in, const char* key) {
      return in.contains(key) && in[key].is_number() ? in[key].get<double>() : kNaN;
    };
    const Json overall = verdict.value("overall", Json::object());
    const double confidence = number(verdict, "confidence");
    if (!(confidence > 0.0 && confidence < 1.0)) return;
    add_part({.name = std::move(name), .on = on}, number(verdict, "mean"), number(verdict, "expected"),
             {number(overall, "lower"), number(overall, "upper")}, confidence,
             number(verdict, "tests") == 1.0, parts);
  };
  add("NEES", "P", document["nees"]);
  const Json blocks = document.value("blocks", Json::object());
  for (const auto& [name, verdict] : blocks.items()) add(name, "P", verdict);
  const Json sensors = document.value("sensors", Json::array());
  for (const Json& sensor : sensors)
    add(sensor_part(sensor.value("name", "")), "S", sensor.value("nis", Json::object()));
  return parts;
}

/// The ratio of two factors from their intervals [Zou 2008]; the logs may have met the same noise, which
/// makes it wider than it need be.
FactorChange change_of(const MeanOfPart& second, const MeanOfPart& first, double confidence) {
  const double step = std::log(second.factor / first.factor);
  const auto deviation = [](double ratio, const MeanOfPart& part) { return std::log(ratio) / part.quantile; };
  const double down = std::hypot(deviation(second.factor / second.lower, second),
                                 deviation(first.upper / first.factor, first)),
               up = std::hypot(deviation(second.upper / second.factor, second),
                               deviation(first.factor / first.lower, first));
  const double z = std::sqrt(chi_square_upper_quantile(1.0 - confidence, 1.0));
  const double score = step / (step > 0.0 ? down : up);
  return {
      .part = second.name,
      .on = second.on,
      .ratio = {.mean = std::exp(step), .lower = std::exp(step - z * down), .upper = std::exp(step + z * up)},
      .before = first.factor,
      .after = second.factor,
      .p_value = std::isnan(score) ? 1.0 : std::erfc(std::abs(score) / std::sqrt(2.0))};
}

std::string names_of(const std::vector<MeanOfPart>& parts) {
  constexpr std::size_t kMost = 5;
  if (parts.empty()) return "of nothing";
  std::vector<std::string> names;
  names.reserve(parts.size());
  for (const MeanOfPart& part : parts) names.push_back(part.name);
  if (names.size() > kMost) {
    names.resize(kMost);
    names.emplace_back("…");
  }
  return fmt::format("of {}", fmt::join(names, ", "));
}

}  // namespace

void compare_means(const Judgement& now, const Json& before, LogGate& gate) {
  const std::vector<MeanOfPart> second = means_of(now), first = means_of(before);
  std::vector<double> p_values;
  for (const MeanOfPart& part : second) {
    const auto same = std::ranges::find(first, part.name, &MeanOfPart::name);
    if (same == first.end() || same->on != part.on) continue;
    gate.changes.push_back(change_of(part, *same, now.confidence));
    p_values.push_back(gate.changes.back().p_value);
  }
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < adjusted.size(); ++i) gate.changes[i].adjusted = adjusted[i];
  gate.by_means = !gate.changes.empty();
  if (gate.by_means) return;
  gate.why_not = fmt::format(
      "as it has means with bounds {} (`nees`, `blocks` and `sensors` with `mean` and `overall`) and these "
      "logs {}; write it anew with `credence check --format json` of logs with the same states and "
      "innovations",
      names_of(first), names_of(second));
}

}  // namespace credence::internal
