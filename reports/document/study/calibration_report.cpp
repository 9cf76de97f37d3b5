#include "reports/document/study/calibration_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "reports/document/shown_unit.h"

namespace credence::internal {
namespace {

std::string factor_text(const MeanInterval& factor) {
  return factor.reason.empty() ? interval_text(factor.mean, factor.lower, factor.upper)
                               : number_text(factor.mean, 3);
}

std::string conformal_sentence(const ConformalFactor& c) {
  if (std::isnan(c.factor)) {
    return c.runs < 2 ? ""
                      : fmt::format(
                            "A factor that covers further runs whatever their law takes 19 runs, and there "
                            "are {}; 95 % of those at hand need P times {}.",
                            c.runs, number_text(c.least, 3));
  }
  return fmt::format(
      "Without assuming Gaussian errors: with P times {}, a further run has at least 95 % of its rows within "
      "the 95 % ellipsoid with a probability of at least 95 % (conformal over {} runs, which must be "
      "exchangeable; the probability is that over all such sets of runs, and of this one may be less).",
      number_text(c.factor, 3), c.runs);
}

std::string protection_sentence(const ProtectionLevel& shown, const ProtectionLevel& last) {
  return fmt::format(
      "Position errors beyond the protection level of {:g} (k = {}): {} of {} rows, worth at least {} "
      "independent ones: the risk is at most {} at 95 % (Clopper-Pearson). To show {} takes {} independent "
      "rows with none beyond.",
      shown.risk, number_text(shown.k, 3), shown.beyond, shown.rows, number_text(shown.effective_rows, 3),
      number_text(shown.upper_limit, 2), number_text(last.risk, 1),
      static_cast<std::int64_t>(std::ceil(last.needed_rows)));
}

/// Where the factor on the variance of a state is clearly not 1, if that depends on the σ that is claimed.
std::string claimed_sigma_sentence(const ClaimedSigmaTest& test, double level) {
  std::string text;
  for (const ClaimedSigmaTest::Side* const side : {&test.optimistic, &test.pessimistic}) {
    if (!(side->p_value <= level)) continue;
    append_item(text, fmt::format("{} in {} ({})", factor_text(side->factor), side->in,
                                  p_value_statement(side->p_value)));
  }
  return text.empty() ? text : fmt::format("By the σ that is claimed, the factor on σ² is {}.", text);
}

/// "NEES over n by distance travelled: 0 to 64 m 1.02 (0.98 … 1.07), …": four places along the way.
std::string distance_sentence(const Calibration& c) {
  constexpr std::size_t kShown = 4;
  if (c.distance.empty()) return "";
  const std::size_t shown = std::min(kShown, c.distance.size());
  std::string text = "By distance travelled, NEES over n";
  const bool position = c.distance.front().sigma_m > 0.0;
  if (position) text += " and the position's error over its σ";
  if (shown < c.distance.size()) text += fmt::format(", of {} of {} lengths", shown, c.distance.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const DistanceBin& bin = c.distance[shown == 1 ? 0 : i * (c.distance.size() - 1) / (shown - 1)];
    text +=
        fmt::format("{} {:g} to {:g} m {}", i == 0 ? ":" : ";", bin.from_m, bin.to_m, factor_text(bin.nees));
    if (position) text += fmt::format(", {}", number_text(bin.error_m / bin.sigma_m, 3));
  }
  const auto least = std::ranges::min_element(c.distance, {}, [](const DistanceBin& bin) {
    return std::isnan(bin.adjusted) ? HUGE_VAL : bin.adjusted;
  });
  if (std::isnan(least->adjusted)) return text + ". There is no test with fewer than five runs.";
  return text +
         fmt::format(". The clearest sign that it is not 1: {}, {:g} to {:g} m (Holm over {} lengths).",
                     p_value_statement(least->adjusted), least->from_m, least->to_m, c.distance.size());
}

Json interval_json(const MeanInterval& interval) {
  return with_reason(json_interval(interval), interval.reason);
}

Json distance_json(std::span<const DistanceBin> bins) {
  return json_list(bins, [](const DistanceBin& bin) -> Json {
    return {{"from_m", bin.from_m},
            {"to_m", bin.to_m},
            {"rows", bin.rows},
            {"nees_over_dof", interval_json(bin.nees)},
            {"p_value", bin.p_value},
            {"adjusted_p_value", bin.adjusted},
            {"position_error_m", bin.error_m},
            {"position_sigma_m", bin.sigma_m}};
  });
}

bool has_bars(const MeanInterval& factor) {
  return std::isfinite(factor.lower) && std::isfinite(factor.upper);
}

/// A logarithmic axis where values span decades, as of runs that diverge: a linear one would show the largest
/// alone. Bars that reach to zero or below end at the frame.
void span_decades(Panel& panel) {
  constexpr double kDecades = 50.0, kRoom = 1.5;
  double least = HUGE_VAL, most = 0.0, lowest = HUGE_VAL, highest = 0.0;
  const auto add = [](double value, double& low, double& high) {
    if (!(value > 0.0) || !std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  };
  for (const Series& series : panel.series) {
    for (const double y : series.y) add(y, least, most);
    for (const FigureData* values : {&series.y, &series.lower, &series.upper}) {
      for (const double y : *values) add(y, lowest, highest);
    }
  }
  if (!(most > kDecades * least)) return;
  panel.log_y = true;
  panel.y_range = AxisRange{std::max(lowest, least / kDecades) / kRoom, highest * kRoom};
  for (Series& series : panel.series) {
    for (double& lower : series.lower) {
      if (lower <= 0.0) lower = panel.y_range->low;
    }
  }
}

/// Claimed σ and the σ that the errors have, of the bins of one state: the claimed one by the root of the
/// factor, whose interval the bars are (the RMSE is the mean of another quantity, and may lie outside).
Panel sigma_panel(std::span<const SigmaBin> bins, const std::string& title, const std::string& unit) {
  FigureData claimed, measured, lower, upper;
  for (const SigmaBin& bin : bins) {
    const bool interval = has_bars(bin.factor);
    const auto scaled = [&](double factor) { return bin.claimed * std::sqrt(factor); };
    claimed.push_back(bin.claimed);
    measured.push_back(std::isfinite(bin.factor.mean) ? scaled(bin.factor.mean) : bin.rmse);
    lower.push_back(interval ? scaled(bin.factor.lower) : measured.back());
    upper.push_back(interval ? scaled(bin.factor.upper) : measured.back());
  }
  const std::string in_unit = unit_in_brackets(unit);
  Panel panel{.title = title, .x_label = "claimed σ" + in_unit, .y_label = "σ of the errors" + in_unit};
  panel.log_x = panel.log_y = true;
  constexpr double kRoom = 1.3;  // no point on the frame
  panel.x_range = AxisRange{claimed.front() / kRoom, claimed.back() * kRoom};
  panel.series.push_back(line_series("equal", ColourRole::exact, claimed, claimed));
  panel.series.push_back(error_bar_series("measured", ColourRole::first, claimed, measured, lower, upper));
  return panel;
}

}  // namespace

std::vector<std::string> calibration_sentences(const Calibration& c) {
  std::vector<std::string> sentences;
  if (c.unit_count > 0 && c.whole.factor.reason.empty()) {
    std::string text = fmt::format("The factor on P is {}", factor_text(c.whole.factor));
    for (const PartFactor& part : c.parts) {
      text += fmt::format("{} in {} {}", &part == c.parts.data() ? ":" : ",", part.name,
                          factor_text(part.factor));
    }
    if (std::isfinite(c.with_factor.mean)) {
      text += fmt::format(". On {} left out, scaled by what the others give, mean NEES is {} times n",
                          c.units, factor_text(c.with_factor));
      const bool by_parts = !c.parts.empty() && std::isfinite(c.with_part_factors.mean);
      if (by_parts) text += fmt::format("; scaled part by part {}", factor_text(c.with_part_factors));
    }
    sentences.push_back(text + ".");
  }
  if (std::string text = claimed_sigma_sentence(c.claimed_sigma, 1.0 - c.confidence); !text.empty())
    sentences.push_back(std::move(text));
  if (std::string text = conformal_sentence(c.conformal); !text.empty()) sentences.push_back(std::move(text));
  constexpr double kFewestRows = 20.0;  // of fewer next to nothing is shown
  if (c.protection.front().rows > 0 && c.protection[1].effective_rows >= kFewestRows)
    sentences.push_back(protection_sentence(c.protection[1], c.protection.back()));
  if (std::string text = distance_sentence(c); !text.empty()) sentences.push_back(std::move(text));
  return sentences;
}

ReportTable sigma_table(const Calibration& c, const RunLayout& layout) {
  using enum ColumnAlign;
  ReportTable table{
      .title = "Errors where the filter claims a small σ, and where it claims a large one",
      .columns = {{"state", words},
                  {"claimed σ", words},
                  {"claimed (rms)"},
                  {"RMSE"},
                  {"factor on σ²", words},
                  {"p", words},
                  {"p, adjusted", words},
                  {"rows"}},
      .notes = {"Of every range of the claimed σ, a quarter of a decade wide: the factor between true and "
                "claimed variance with its interval over runs, or stretches of a run, and the test that it "
                "is 1; adjusted by Holm over all rows of this table. Units are those of the states."}};
  for (const SigmaBin& bin : c.bins) {
    const bool tested = !std::isnan(bin.p_value);
    table.add({state_name(layout.states, bin.state) + unit_in_brackets(unit_of_states(layout, {bin.state})),
               fmt::format("{} … {}", number_text(bin.lower, 3), number_text(bin.upper, 3)), bin.claimed,
               bin.rmse, factor_text(bin.factor), tested ? p_value_text(bin.p_value) : "–",
               tested ? p_value_text(bin.adjusted) : "–", bin.rows});
  }
  return table;
}

Figure sigma_figure(const std::string& name, const Calibration& c, const RunLayout& layout) {
  constexpr std::size_t kPanels = 6;
  constexpr std::int64_t kFewestRows = 10;  // of fewer the scatter is larger than what is to be seen
  std::vector<SigmaBin> bins;
  std::ranges::copy_if(c.bins, std::back_inserter(bins),
                       [](const SigmaBin& bin) { return bin.rows >= kFewestRows; });
  Figure figure{
      .name = name + "-sigma",
      .caption =
          "The σ that the errors have, which is the claimed one times √(mean e²/σ²), against the σ "
          "that the filter claims, in ranges of it, in the unit of the state (angles in rad): points "
          "above the line are optimistic, points below it pessimistic"};
  for (std::size_t i = 0; i < bins.size() && figure.panels.size() < kPanels;) {
    std::size_t end = i;
    while (end < bins.size() && bins[end].state == bins[i].state) ++end;
    if (end - i > 1)
      figure.panels.push_back(sigma_panel(std::span(bins).subspan(i, end - i),
                                          state_name(layout.states, bins[i].state),
                                          unit_of_states(layout, {bins[i].state})));
    i = end;
  }
  const auto has_interval = [](const SigmaBin& bin) { return has_bars(bin.factor); };
  figure.caption += std::ranges::any_of(bins, has_interval) ? "; bars are intervals." : ".";
  if (bins.size() < c.bins.size())
    figure.caption += fmt::format(" Ranges of fewer than {} rows are left out.", kFewestRows);
  arrange(figure);
  return figure;
}

Figure distance_figure(const std::string& name, const Calibration& c) {
  Figure figure{.name = name + "-distance",
                .caption =
                    "Over the distance that the truth has travelled: NEES over n, whose mean is 1 for a "
                    "consistent filter (bars: intervals over runs), and position errors beside what is "
                    "claimed, root mean squares.",
                .cols = 2};
  if (c.distance.size() < 2) return figure;
  const auto nees = [&](double MeanInterval::*number) {
    return figure_data(c.distance, [number](const DistanceBin& bin) {
      return bin.nees.reason.empty() ? bin.nees.*number : bin.nees.mean;
    });
  };
  const FigureData middle =
      figure_data(c.distance, [](const DistanceBin& bin) { return 0.5 * (bin.from_m + bin.to_m); });
  Panel ratio{.title = "NEES over n", .x_label = "distance travelled (m)", .y_label = "mean NEES / n"};
  ratio.series = {level_series("consistent", ColourRole::exact, 1.0),
                  error_bar_series("measured", ColourRole::first, middle, nees(&MeanInterval::mean),
                                   nees(&MeanInterval::lower), nees(&MeanInterval::upper))};
  span_decades(ratio);
  figure.panels.push_back(std::move(ratio));
  if (c.distance.front().sigma_m > 0.0) {
    Panel position{
        .title = "Position", .x_label = "distance travelled (m)", .y_label = "root mean square (m)"};
    position.series = {
        line_series("claimed σ", ColourRole::bound, middle, figure_data(c.distance, &DistanceBin::sigma_m)),
        line_series("error", ColourRole::estimate, middle, figure_data(c.distance, &DistanceBin::error_m))};
    span_decades(position);
    figure.panels.push_back(std::move(position));
  }
  figure.cols = static_cast<int>(figure.panels.size());
  return figure;
}

Figure stanford_figure(const std::string& name, const Calibration& c) {
  Figure figure{.name = name + "-stanford", .caption = {}};
  const ProtectionLevel& level = c.protection[1];
  if (level.rows == 0 || c.stanford.empty()) return figure;
  figure.caption = fmt::format(
      "Stanford diagram: rows by position error and protection level, k = {} standard deviations along the "
      "widest axis of P, which an error exceeds with a risk of at most {:g} where P is right. Below the line "
      "the error is beyond the level: {} of {} rows.",
      number_text(level.k, 3), level.risk, level.beyond, level.rows);
  constexpr double kCell = 0.125;  // decades
  double least_error = HUGE_VAL, most_error = 0.0, least_level = HUGE_VAL, most_level = 0.0;
  for (const StanfordCell& cell : c.stanford) {
    least_error = std::min(least_error, cell.error);
    most_error = std::max(most_error, cell.error);
    least_level = std::min(least_level, level.k * cell.sigma);
    most_level = std::max(most_level, level.k * cell.sigma);
  }
  // Centres of cells one of which is at `at`, over a range.
  const auto centres = [](double at, const AxisRange& range) {
    const auto index = [at](double value) { return std::log10(value / at) / kCell; };
    FigureData all;
    const auto first = static_cast<Index>(std::floor(index(range.low))),
               end = static_cast<Index>(std::ceil(index(range.high) + 1.0));
    for (Index i = first; i < end; ++i) all.push_back(at * std::pow(10.0, kCell * static_cast<double>(i)));
    return all;
  };
  const auto place = [](double value, const FigureData& all) {
    const auto i = static_cast<Index>(std::llround(std::log10(value / all.front()) / kCell));
    return std::clamp<Index>(i, 0, std::ssize(all) - 1);
  };
  // Of levels much alike more are shown around them, so that the line is seen to rise.
  constexpr double kAlike = 3.0, kAround = 1.8;
  const double around = most_level < kAlike * least_level ? kAround : 1.0;
  FigureData y = centres(most_level, {least_level / around, most_level * around});
  // Errors as far as the levels, all of which the line then crosses. Below these and a hundredth of the
  // largest error nothing is to be seen: such rows are in the first column.
  FigureData x = centres(most_error, {std::min(y.front(), std::max(least_error, 0.01 * most_error)),
                                      std::max(y.back(), most_error)});
  Matrix cells = Matrix::Constant(std::ssize(y), std::ssize(x), kNaN);
  for (const StanfordCell& cell : c.stanford) {
    double& rows = cells(place(level.k * cell.sigma, y), place(cell.error, x));
    rows = (std::isnan(rows) ? 0.0 : rows) + static_cast<double>(cell.rows);
  }
  const double room = std::pow(10.0, 0.5 * kCell);
  Panel panel{.title = "Position errors against their protection level",
              .x_label = "position error (m)",
              .y_label = "protection level (m)"};
  panel.x_range = AxisRange{x.front() / room, x.back() * room};
  panel.y_range = AxisRange{y.front() / room, y.back() * room};
  panel.log_x = panel.log_y = panel.log_colour = true;
  panel.ticks_at_centres = false;
  panel.colour_label = "rows";
  panel.colour_range = AxisRange{1.0, std::max(2.0, cells.array().isNaN().select(0.0, cells).maxCoeff())};
  panel.series.push_back(heat_series(std::move(x), std::move(y), std::move(cells)));
  const AxisRange line = *panel.y_range;
  panel.series.push_back(
      line_series("error = level", ColourRole::exact, {line.low, line.high}, {line.low, line.high}));
  figure.panels.push_back(std::move(panel));
  return figure;
}

Json calibration_json(const Calibration& c, const UnitFactors& units, std::span<const std::string> states) {
  Json bins = json_list(c.bins, [&](const SigmaBin& bin) -> Json {
    return {{"state", state_name(states, bin.state)},
            {"sigma_from", bin.lower},
            {"sigma_to", bin.upper},
            {"claimed_rms", bin.claimed},
            {"rmse", bin.rmse},
            {"rows", bin.rows},
            {"factor", interval_json(bin.factor)},
            {"p_value", bin.p_value},
            {"adjusted_p_value", bin.adjusted}};
  });
  Json parts = Json::object();
  for (const PartFactor& part : c.parts) parts[part.name] = interval_json(part.factor);
  Json protection = Json::array();
  for (const ProtectionLevel& level : c.protection) {
    if (level.rows == 0) continue;
    protection.push_back({{"risk", level.risk},
                          {"k_sigma", level.k},
                          {"rows", level.rows},
                          {"beyond", level.beyond},
                          {"effective_rows", level.effective_rows},
                          {"risk_upper_limit", level.upper_limit},
                          {"effective_rows_needed", level.needed_rows}});
  }
  Json factors = Json::object();
  for (std::size_t a = 0; a < units.parts.size(); ++a) factors[units.parts[a]] = units.factors[a];
  return {{"units", text_or_null(c.units)},
          {"factor", interval_json(c.whole.factor)},
          {"part_factors", std::move(parts)},
          {"held_out_nees_over_dof",
           {{"with_factor", interval_json(c.with_factor)},
            {"with_part_factors", c.parts.empty() ? Json(nullptr) : interval_json(c.with_part_factors)}}},
          {"conformal", {{"factor", c.conformal.factor}, {"runs", c.conformal.runs}}},
          {"protection_levels", std::move(protection)},
          {"by_sigma", std::move(bins)},
          {"by_distance", distance_json(c.distance)},
          {"unit_names", units.names},
          {"unit_factors", std::move(factors)}};
}

UnitFactors unit_factors_of(const Json& calibration) {
  UnitFactors units;
  if (!calibration.is_object() || !calibration.contains("units") || !calibration["units"].is_string())
    return units;
  units.units = calibration["units"].get<std::string>();
  units.names = calibration.value("unit_names", std::vector<std::string>());
  const Json factors = calibration.value("unit_factors", Json::object());
  for (const auto& [part, values] : factors.items()) {
    std::vector<double> numbers;
    numbers.reserve(values.size());
    for (const Json& value : values) numbers.push_back(value.is_number() ? value.get<double>() : kNaN);
    if (numbers.size() != units.names.size()) continue;
    units.parts.push_back(part);
    units.factors.push_back(std::move(numbers));
  }
  return units;
}

}  // namespace credence::internal
