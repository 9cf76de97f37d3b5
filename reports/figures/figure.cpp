#include "reports/figures/figure.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/nan.h"

namespace credence::internal {
namespace {

Series make_series(SeriesKind kind, FigureText label, ColourRole role, FigureData x, FigureData y) {
  Series series;
  series.kind = kind;
  series.label = std::move(label);
  series.role = role;
  series.x = std::move(x);
  series.y = std::move(y);
  return series;
}

void require(bool fits, const std::string& where, const std::string& what) {
  if (!fits) throw std::invalid_argument(where + ": " + what);
}

bool strictly_increasing(const FigureData& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i]) || (i > 0 && !(values[i] > values[i - 1]))) return false;
  }
  return true;
}

void validate_heat_map(const Series& series, const std::string& where) {
  const auto rows = static_cast<Index>(series.y.size());
  const auto cols = static_cast<Index>(series.x.size());
  require(series.cells.rows() == rows && series.cells.cols() == cols && rows > 0 && cols > 0, where,
          fmt::format("{}x{} cells for {} rows and {} columns", series.cells.rows(), series.cells.cols(),
                      rows, cols));
  require(strictly_increasing(series.x) && strictly_increasing(series.y), where,
          "centres of cells must increase strictly");
}

void validate_series(const Series& series, const std::string& where) {
  const std::size_t n = series.x.size();
  const bool has_bounds = series.kind == SeriesKind::band || series.kind == SeriesKind::error_bars;
  require(std::isfinite(series.weight) && series.weight > 0.0, where,
          fmt::format("weight = {} must be a finite number > 0", series.weight));
  if (series.kind == SeriesKind::heat_map) return validate_heat_map(series, where);
  if (series.kind == SeriesKind::upright) return require(n == 1, where, "an upright needs one x");
  if (series.kind == SeriesKind::level) return require(series.y.size() == 1, where, "a level needs one y");
  if (series.kind != SeriesKind::band) {
    require(series.y.size() == n, where, fmt::format("{} values of x, {} of y", n, series.y.size()));
  }
  if (has_bounds) {
    require(series.lower.size() == n && series.upper.size() == n, where,
            fmt::format("{} values of x, {} lower, {} upper", n, series.lower.size(), series.upper.size()));
  }
  if (series.kind == SeriesKind::text) {
    require(series.texts.size() == n, where, fmt::format("{} texts for {} points", series.texts.size(), n));
  }
}

void validate_range(const std::optional<AxisRange>& range, bool log, const char* axis,
                    const std::string& where) {
  if (!range) return;
  const bool ordered = std::isfinite(range->low) && std::isfinite(range->high) && range->low < range->high;
  require(ordered && (!log || range->low > 0.0), where,
          fmt::format("{} range [{}, {}] must be finite, increasing{}", axis, range->low, range->high,
                      log ? " and positive (log scale)" : ""));
}

void validate_panel(const Panel& panel, const std::string& where) {
  validate_range(panel.x_range, panel.log_x, "x", where);
  validate_range(panel.y_range, panel.log_y, "y", where);
  validate_range(panel.colour_range, panel.log_colour, "colour", where);
  require((panel.x_names.empty() || !panel.log_x) && (panel.y_names.empty() || !panel.log_y), where,
          "names stand at 1, 2, …, which a logarithmic axis does not space evenly");
  require(!(panel.equal_aspect && (panel.log_x || panel.log_y)), where,
          "equal aspect and logarithmic axes exclude each other");
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    validate_series(panel.series[i],
                    fmt::format("{}, series {} '{}'", where, i + 1, panel.series[i].label.text));
  }
}

}  // namespace

FigureText figure_markup(std::string words) {
  FigureText text(std::move(words));
  text.has_markup = true;
  return text;
}

FigureData index_axis(Index count, Index first) {
  FigureData axis;
  for (Index i = 0; i < count; ++i) axis.push_back(static_cast<double>(first + i));
  return axis;
}

Series line_series(FigureText label, ColourRole role, FigureData x, FigureData y) {
  return make_series(SeriesKind::line, std::move(label), role, std::move(x), std::move(y));
}

Series step_series(FigureText label, ColourRole role, FigureData x, FigureData y) {
  return make_series(SeriesKind::steps, std::move(label), role, std::move(x), std::move(y));
}

Series point_series(FigureText label, ColourRole role, FigureData x, FigureData y) {
  return make_series(SeriesKind::points, std::move(label), role, std::move(x), std::move(y));
}

Series band_series(FigureText label, ColourRole role, FigureData x, FigureData lower, FigureData upper) {
  Series series = make_series(SeriesKind::band, std::move(label), role, std::move(x), {});
  series.lower = std::move(lower);
  series.upper = std::move(upper);
  return series;
}

Series level_series(FigureText label, ColourRole role, double y) {
  return make_series(SeriesKind::level, std::move(label), role, {}, FigureData(1, y));
}

Series upright_series(FigureText label, ColourRole role, double x) {
  return make_series(SeriesKind::upright, std::move(label), role, FigureData(1, x), {});
}

Series error_bar_series(FigureText label, ColourRole role, FigureData x, FigureData y, FigureData lower,
                        FigureData upper) {
  Series series = make_series(SeriesKind::error_bars, std::move(label), role, std::move(x), std::move(y));
  series.lower = std::move(lower);
  series.upper = std::move(upper);
  return series;
}

std::vector<Series> error_series(FigureText label, ColourRole role, const FigureData& x, FigureData error,
                                 FigureData two_sigma, bool label_bounds) {
  FigureData lower = figure_data(two_sigma, std::negate<>());
  return {line_series(label_bounds ? "±2σ" : "", ColourRole::bound, x, std::move(lower)),
          line_series("", ColourRole::bound, x, std::move(two_sigma)),
          line_series(std::move(label), role, x, std::move(error))};
}

Series polygon_series(FigureText label, ColourRole role, FigureData x, FigureData y) {
  Series series = make_series(SeriesKind::polygon, std::move(label), role, std::move(x), std::move(y));
  // Dashes tear small ellipses apart.
  series.stroke = StrokeStyle::solid;
  return series;
}

Series text_series(ColourRole role, FigureData x, FigureData y, std::vector<FigureText> texts) {
  Series series = make_series(SeriesKind::text, {}, role, std::move(x), std::move(y));
  series.texts = std::move(texts);
  return series;
}

Series heat_series(FigureData x, FigureData y, Matrix cells) {
  Series series = make_series(SeriesKind::heat_map, {}, ColourRole::neutral, std::move(x), std::move(y));
  series.cells = std::move(cells);
  return series;
}

void arrange(Figure& figure, int columns) {
  if (const std::size_t all = figure.panels.size(); all > kMostPanels) {
    figure.panels.resize(kMostPanels);
    figure.caption += fmt::format(" Of {} panels the first {} are shown.", all, kMostPanels);
  }
  const int panels = std::max(1, static_cast<int>(figure.panels.size()));
  figure.cols = panels == 4 ? 2 : std::min(panels, columns);
  figure.rows = (panels + figure.cols - 1) / figure.cols;
}

bool has_data(const Panel& panel, const Series& series) {
  const auto drawn = [](const FigureData& values, std::size_t i, bool log) {
    return i < values.size() && std::isfinite(values[i]) && (!log || values[i] > 0.0);
  };
  if (series.kind == SeriesKind::heat_map) return series.cells.array().isFinite().any();
  if (series.kind == SeriesKind::level) return drawn(series.y, 0, panel.log_y);
  if (series.kind == SeriesKind::upright) return drawn(series.x, 0, panel.log_x);
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const bool area = drawn(series.lower, i, panel.log_y) && drawn(series.upper, i, panel.log_y);
    if (drawn(series.x, i, panel.log_x) && (area || drawn(series.y, i, panel.log_y))) return true;
  }
  return false;
}

bool has_data(const Panel& panel) {
  return std::ranges::any_of(panel.series, [&](const Series& series) {
    return series.kind != SeriesKind::level && series.kind != SeriesKind::upright && has_data(panel, series);
  });
}

bool has_data(const Figure& figure) {
  return std::ranges::any_of(figure.panels, [](const Panel& panel) { return has_data(panel); });
}

void validate(const Figure& figure) {
  const std::string where = fmt::format("figure '{}'", figure.name);
  constexpr const char* kNameLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  require(!figure.name.empty() && figure.name.find_first_not_of(kNameLetters) == std::string::npos, where,
          "the name must be letters, digits, '-' and '_'");
  require(figure.rows >= 1 && figure.cols >= 1 && figure.rows <= kMostRows && figure.cols <= kMostColumns,
          where,
          fmt::format("grid of {}x{} panels must be within 1x1 and {}x{}", figure.rows, figure.cols,
                      kMostRows, kMostColumns));
  require(!figure.panels.empty() && figure.panels.size() <= static_cast<std::size_t>(figure.rows) *
                                                                static_cast<std::size_t>(figure.cols),
          where,
          fmt::format("{} panels for a grid of {}x{}", figure.panels.size(), figure.rows, figure.cols));
  require(std::isfinite(figure.row_height) && figure.row_height >= 0.0, where,
          fmt::format("row_height = {} must be a finite number >= 0", figure.row_height));
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    validate_panel(figure.panels[i],
                   fmt::format("{}, panel {} '{}'", where, i + 1, figure.panels[i].title.text));
  }
}

PlanarCurve ellipse_points(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance, double k_sigma,
                           int count) {
  if (!mean.allFinite() || !covariance.allFinite() || !std::isfinite(k_sigma) || count < 3) return {};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
  // Rounding may leave a singular covariance slightly negative; more than that is no covariance.
  constexpr double kTolerance = 1e-12;
  if (axes.info() != Eigen::Success || axes.eigenvalues()(0) < -kTolerance * axes.eigenvalues()(1)) return {};
  const Eigen::Vector2d radii = k_sigma * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  PlanarCurve curve;
  for (int i = 0; i < count; ++i) {
    const double t = 2.0 * std::numbers::pi * i / count;
    const Eigen::Vector2d point =
        mean + axes.eigenvectors() * radii.cwiseProduct(Eigen::Vector2d(std::cos(t), std::sin(t)));
    curve.x.push_back(point.x());
    curve.y.push_back(point.y());
  }
  return curve;
}

void append_curve(PlanarCurve& all, const PlanarCurve& next) {
  if (next.x.empty()) return;
  if (!all.x.empty()) {
    all.x.push_back(kNaN);
    all.y.push_back(kNaN);
  }
  all.x.insert(all.x.end(), next.x.begin(), next.x.end());
  all.y.insert(all.y.end(), next.y.begin(), next.y.end());
}

}  // namespace credence::internal
