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
#include "analysis/laws/mean/ratio_of_factors.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// The factor on P or S that the mean of a part asks for, its interval that of the factors with which the
/// mean lies within its bounds.
struct MeanOfPart {
  std::string name;
  std::string_view on;
  FactorInterval interval{};
};

void add_part(MeanOfPart part, double mean, double expected, const ChiSquareBounds& bounds, double confidence,
              bool single_test, std::vector<MeanOfPart>& parts) {
  const double alpha = 1.0 - confidence;
  part.interval = {.factor = mean / expected,
                   .lower = mean / bounds.upper,
                   .upper = mean / bounds.lower,
                   .quantile = std::sqrt(chi_square_upper_quantile(single_test ? alpha : 0.5 * alpha, 1.0))};
  if (!part.interval.is_known()) return;
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

FactorChange change_of(const MeanOfPart& second, const MeanOfPart& first, double confidence) {
  const RatioOfFactors r = ratio_of_factors(second.interval, first.interval, confidence);
  return {.part = second.name,
          .on = second.on,
          .ratio = r.ratio,
          .before = first.interval.factor,
          .after = second.interval.factor,
          .p_value = r.p_value,
          .p_middle = p_value_of_middle(second.interval, first.interval)};
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
  for (const MeanOfPart& part : second) {
    const auto same = std::ranges::find(first, part.name, &MeanOfPart::name);
    if (same == first.end() || same->on != part.on) continue;
    gate.changes.push_back(change_of(part, *same, now.confidence));
  }
  adjust_by_holm(gate.changes);
  gate.by_means = !gate.changes.empty();
  if (gate.by_means) return;
  gate.why_not = fmt::format(
      "as it has means with bounds {} (`nees`, `blocks` and `sensors` with `mean` and `overall`) and these "
      "logs {}; write it anew with `credence check --format json` of logs with the same states and "
      "innovations",
      names_of(first), names_of(second));
}

}  // namespace credence::internal
