#include "reports/figures/tune_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/tuning/score_shape.h"
#include "core/append_item.h"

namespace credence::internal {
namespace {

/// What a coordinate is on an axis: that of its own parameter if it is the logarithm of one, else itself.
struct TuneAxis {
  std::string label;
  double unit = 1.0;
  bool logarithm = false;

  double operator()(double phi) const { return logarithm ? unit * std::exp(phi) : phi; }
};

TuneAxis axis_of(const ScoreModel& model, const Tuning& tuning, const KeyOfParameter& key_of,
                 Index coordinate) {
  const std::string name = model.names()[static_cast<std::size_t>(coordinate)];
  const ScenarioScore::Key key = key_of(name);
  for (const NoiseValue& value : model.values(tuning.phi)) {
    if (value.name != name || !value.positive) continue;
    return {key.name, key.unit * value.value * std::exp(-tuning.phi[coordinate]), true};
  }
  return {key.name + " (log or scaled)"};
}

KeyOfParameter keys_of(const ScenarioTuning& t) {
  return [&t](const std::string& parameter) { return t.score->key(parameter); };
}

/// By how much the variance of an estimate exceeds that of a right filter: the likelihood ratio is so many
/// times a χ² of one dof [Kent 1982].
double variance_ratio(const Tuning& tuning, Index coordinate) {
  if (!tuning.by_sandwich) return 1.0;
  const auto& free = tuning.estimate.free;
  const Index at = std::ranges::find(free, coordinate) - free.begin();
  return tuning.estimate.sandwich()(at, at) / tuning.estimate.covariance(at, at);
}

Panel profile_panel(const ScoreModel& model, const Tuning& tuning, const TuneAxis& axis, Index coordinate) {
  constexpr double kDeviations = 3.5;
  const double ratio = variance_ratio(tuning, coordinate);
  // A black box plays its runs again for every point.
  const ScoreProfile profile = score_profile(model, tuning, coordinate, model.has_gradient() ? 17 : 9,
                                             kDeviations * std::sqrt(std::max(ratio, 1.0)));
  const double level = 0.5 * ratio * chi_square_quantile(tuning.confidence, 1.0);
  const FigureData score = figure_data(profile.drop, std::negate());
  const FigureData x = figure_data(profile.phi, axis);
  Panel panel{.x_label = axis.label, .y_label = "log likelihood"};
  panel.series = {
      line_series("profile", ColourRole::estimate, x, score),
      level_series(fmt::format("{:g} % interval", 100.0 * tuning.confidence), ColourRole::bound, -level),
      upright_series("tuned", ColourRole::exact, axis(tuning.phi[coordinate]))};
  const double present = axis(tuning.start[coordinate]);
  if (present >= x.front() && present <= x.back()) {
    panel.series.push_back(upright_series("present", ColourRole::neutral, present));
  }
  return panel;
}

}  // namespace

Figure tune_profile_figure(const ScoreModel& model, const Tuning& tuning, const KeyOfParameter& key_of) {
  const auto& free = tuning.estimate.free;
  Figure figure{.name = "profiles",
                .caption =
                    "The log likelihood of the innovations over each parameter, the others sought "
                    "again at every point. Where it lies above the line the data accept the value."};
  const std::size_t shown = std::min(free.size(), kMostPanels);  // each takes its time
  if (shown < free.size())
    figure.caption += fmt::format(" Of {} parameters the first {} are shown.", free.size(), shown);
  for (const Index coordinate : std::span(free).first(shown)) {
    figure.panels.push_back(
        profile_panel(model, tuning, axis_of(model, tuning, key_of, coordinate), coordinate));
  }
  arrange(figure, 2);
  return figure;
}

Figure tune_surface_figure(const ScenarioTuning& t) {
  constexpr int kRidgePoints = 41;
  const auto [first, second] = *t.ridge_of;
  const double reach = std::log(30.0);
  const ScoreSurface surface = score_surface(t.score->model(), t.tuning, first, second, reach);
  std::vector<double> shifts;
  shifts.reserve(kRidgePoints);
  for (int i = 0; i < kRidgePoints; ++i) shifts.push_back(reach * (2.0 * i / (kRidgePoints - 1) - 1.0));
  const ScoreModel& model = t.score->model();
  const TuneAxis x = axis_of(model, t.tuning, keys_of(t), first),
                 y = axis_of(model, t.tuning, keys_of(t), second);
  FigureData ridge_x, ridge_y;
  for (const RidgePoint& point : nis_ridge(model, t.tuning, first, second, shifts)) {
    if (std::abs(point.phi[second] - t.tuning.phi[second]) > reach) continue;
    ridge_x.push_back(x(point.phi[first]));
    ridge_y.push_back(y(point.phi[second]));
  }
  // Nats below what can be told apart by eye are one colour.
  const Matrix drop = surface.drop.cwiseMax(1e-4);
  Panel panel{.x_label = x.label, .y_label = y.label, .log_x = x.logarithm, .log_y = y.logarithm};
  panel.colour_label = "log score lost, a step";
  panel.log_colour = true;
  panel.series = {
      heat_series(figure_data(surface.first_phi, x), figure_data(surface.second_phi, y), drop),
      line_series("mean NIS as expected", ColourRole::alarm, ridge_x, ridge_y),
      point_series("tuned", ColourRole::truth, {x(t.tuning.phi[first])}, {y(t.tuning.phi[second])})};
  const double present_x = x(t.tuning.start[first]), present_y = y(t.tuning.start[second]);
  if (std::abs(t.tuning.start[first] - t.tuning.phi[first]) < reach &&
      std::abs(t.tuning.start[second] - t.tuning.phi[second]) < reach) {
    panel.series.push_back(point_series("present", ColourRole::neutral, {present_x}, {present_y}));
  }
  std::string held;
  for (const Index other : t.tuning.estimate.free) {
    if (other != first && other != second)
      append_item(held, axis_of(model, t.tuning, keys_of(t), other).label);
  }
  return {.name = "surface",
          .caption =
              "The mean log score of the innovations has one maximum. On the line the mean NIS is "
              "the expected one: whoever tunes by NIS alone may end anywhere on it." +
              (held.empty() ? "" : fmt::format(" Held at what was tuned: {}.", held)),
          .panels = {std::move(panel)},
          .row_height = 30.0};
}

Figure tune_profile_figure(const ScenarioTuning& t) {
  return tune_profile_figure(t.score->model(), t.tuning, keys_of(t));
}

}  // namespace credence::internal
