#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/types.h"
#include "reports/figures/figure_style.h"

/// @file
/// A figure as data: panels in a grid, each with series. No drawing here; draw_figures.h does that.
/// Values that are not finite break a line and are left out of point clouds.

namespace credence::internal {

/// Text in a figure. Literal by default: "K_f1 {x}" is shown with its underscore and braces.
struct FigureText {
  FigureText() = default;
  FigureText(std::string words) : text(std::move(words)) {}  // NOLINT: labels are written as literals
  FigureText(const char* words) : text(words) {}             // NOLINT
  bool empty() const { return text.empty(); }
  bool operator==(const FigureText&) const = default;

  std::string text;
  bool has_markup = false;
};

/// Text in which `_{...}` is a subscript and `^{...}` a superscript; everything else stays literal.
FigureText figure_markup(std::string words);

/// Numbers of a series, from a std::vector, a list or any Eigen vector, row, column or expression.
struct FigureData : std::vector<double> {
  using std::vector<double>::vector;
  FigureData(std::vector<double> values) : std::vector<double>(std::move(values)) {}  // NOLINT
  FigureData(std::span<const double> values)                                          // NOLINT
      : std::vector<double>(values.begin(), values.end()) {}
  template <typename Derived>
  FigureData(const Eigen::DenseBase<Derived>& values) {  // NOLINT
    const Vector plain = Eigen::Map<const Vector>(values.derived().eval().data(), values.size());
    assign(plain.data(), plain.data() + plain.size());
  }
};

/// One number of each item: a member, or what a function makes of it.
template <class Items, class Get>
FigureData figure_data(const Items& items, Get get) {
  FigureData data;
  for (const auto& item : items) data.push_back(std::invoke(get, item));
  return data;
}

/// first, first + 1, ... `count` values: the steps of a run as an abscissa.
FigureData index_axis(Index count, Index first = 1);

enum class SeriesKind { line, steps, points, band, level, upright, error_bars, polygon, text, heat_map };

/// One layer of a panel; made by the functions below, then adjusted by assignment where needed.
struct Series {
  SeriesKind kind = SeriesKind::line;
  FigureText label{};  ///< legend entry; empty: none
  ColourRole role = ColourRole::estimate;
  StrokeStyle stroke = StrokeStyle::by_role;
  MarkerShape marker = MarkerShape::by_role;
  double weight = 1.0;  ///< line width and marker size relative to the role's
  double aside = 0.0;   ///< lines, points and error bars: how far to the right, in canvas units
  bool filled = false;  ///< polygons
  FigureData x{}, y{};
  FigureData lower{}, upper{};      ///< bands and error bars
  std::vector<FigureText> texts{};  ///< text marks
  Matrix cells{};                   ///< heat map: row i is y[i], column j is x[j]; NaN: not measured
};

/// Points (x_i, y_i) joined by straight lines.
Series line_series(FigureText label, ColourRole role, FigureData x, FigureData y);
/// y_i holds from x_i to x_{i+1}.
Series step_series(FigureText label, ColourRole role, FigureData x, FigureData y);
/// Unconnected markers.
Series point_series(FigureText label, ColourRole role, FigureData x, FigureData y);
/// The area between two curves, tinted.
Series band_series(FigureText label, ColourRole role, FigureData x, FigureData lower, FigureData upper);
/// A horizontal line across the panel.
Series level_series(FigureText label, ColourRole role, double y);
/// A vertical line across the panel.
Series upright_series(FigureText label, ColourRole role, double x);
/// Markers with bars from lower_i to upper_i (absolute, not offsets).
Series error_bar_series(FigureText label, ColourRole role, FigureData x, FigureData y, FigureData lower,
                        FigureData upper);
/// A curve of errors within the ±2σ that a filter claims, of which `label_bounds` says whether they are
/// named.
std::vector<Series> error_series(FigureText label, ColourRole role, const FigureData& x, FigureData error,
                                 FigureData two_sigma, bool label_bounds = true);
/// Closed outlines, separated by a non-finite point (append_curve).
Series polygon_series(FigureText label, ColourRole role, FigureData x, FigureData y);
/// Words to the right of and above points, or in another corner where they would lie on others.
Series text_series(ColourRole role, FigureData x, FigureData y, std::vector<FigureText> texts);
/// Cells around the centres (x_j, y_i), both strictly increasing; their colours follow the panel's colour
/// scale.
Series heat_series(FigureData x, FigureData y, Matrix cells);

struct AxisRange {
  double low = 0.0;
  double high = 1.0;
};

/// One system of axes. Units belong in the axis labels: "time (s)".
struct Panel {
  FigureText title{}, x_label{}, y_label{};
  std::optional<AxisRange> x_range{}, y_range{};  ///< default: what the series need
  bool log_x = false, log_y = false;
  bool equal_aspect = false;  ///< one unit of x as long as one of y; ranges grow to fill the panel
  /// Names of x and y = 1, 2, …, as the columns and rows of a heat map: ticks, instead of numbers.
  std::vector<FigureText> x_names{}, y_names{};
  std::vector<Series> series{};

  // Heat maps only.
  FigureText colour_label{};
  std::optional<AxisRange> colour_range{};
  bool log_colour = false;
  bool ticks_at_centres = true;  ///< of the cells, where all fit: values that were swept
  ColourScale colour_scale = ColourScale::sequential;
};

/// Panels fill the grid row by row; missing ones at the end leave blanks.
struct Figure {
  std::string name{};     ///< file name and anchor: letters, digits, '-' and '_'
  std::string caption{};  ///< plain text, shown below the figure
  int rows = 1, cols = 1;
  std::vector<Panel> panels{};
  double row_height = 0.0;  ///< of one row, in units of the label font's size; 0: chosen from the grid
};

/// A figure of more would be too long for a page or a picture.
inline constexpr int kMostRows = 40, kMostColumns = 8;
inline constexpr std::size_t kMostPanels = 40;  ///< all of them stand below each other in a narrow column

/// As many rows as the panels take, `columns` in each; of four panels two. Of more than kMostPanels the first
/// ones stay, which is added to the caption.
void arrange(Figure& figure, int columns = 3);

/// Whether anything of a series can be drawn: a finite number, on logarithmic axes a positive one.
bool has_data(const Panel& panel, const Series& series);

/// Whether a panel has more than levels and uprights that can be drawn; the figure, whether one has.
bool has_data(const Panel& panel);
bool has_data(const Figure& figure);

/// Throws std::invalid_argument naming figure, panel and series when names, sizes or ranges do not fit.
void validate(const Figure& figure);

/// A curve in the plane.
struct PlanarCurve {
  FigureData x, y;
};

/// The k-sigma ellipse of a Gaussian in the plane: `count` points of mean + k L (cos t, sin t), L Lᵀ = cov.
/// A singular covariance gives a segment or a point; one that is not finite or not psd gives an empty curve.
PlanarCurve ellipse_points(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance, double k_sigma,
                           int count = 48);

/// Appends `next` to `all` behind a break, so that one series holds many ellipses. An empty curve adds
/// nothing.
void append_curve(PlanarCurve& all, const PlanarCurve& next);

}  // namespace credence::internal
