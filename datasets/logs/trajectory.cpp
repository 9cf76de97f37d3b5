#include "datasets/logs/trajectory.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/linear_algebra/symmetry.h"
#include "core/trim_blanks.h"
#include "datasets/data_error.h"
#include "datasets/logs/line_reader.h"
#include "datasets/logs/number_field.h"
#include "datasets/logs/pose_columns.h"

namespace credence::internal {
namespace {

constexpr double kUnitTolerance = 0.01;
constexpr std::size_t kWithoutCovariance = 8;  ///< columns of a pose at a time

/// Appends the rows of a file whose columns are known.
class PoseRows {
 public:
  PoseRows(LineReader& lines, const PoseColumns& columns, double metres_per_unit, Trajectory& out)
      : lines_(lines), columns_(columns), metres_per_unit_(metres_per_unit), out_(out) {}

  void add(std::string_view line) {
    fields_ = columns_.commas ? comma_fields(line) : words_between(" \t", line);
    if (fields_.size() < columns_.fewest || fields_.size() > columns_.most) {
      if (has_covariance() && fields_.size() == kWithoutCovariance) {
        lines_.fail(fmt::format(
            "{} fields where {} are expected: poses without a covariance, as a truth has them; are "
            "the log and --truth swapped, or several truths behind one --truth, which is given "
            "once for each?",
            fields_.size(), columns_.fewest));
      }
      lines_.fail(
          columns_.fewest == columns_.most
              ? fmt::format("{} fields where {} are expected", fields_.size(), columns_.fewest)
              : fmt::format("{} fields where at least {} are expected", fields_.size(), columns_.fewest));
    }
    const double time = time_s();
    if (!out_.time_s.empty() && !(time > out_.time_s.back())) {
      lines_.fail(fmt::format("time {:.9f} s does not increase: the row before has {:.9f} s", time,
                              out_.time_s.back()));
    }
    SpatialPose pose;
    for (std::size_t i = 0; i < 3; ++i)
      pose.position[static_cast<Index>(i)] = metres_per_unit_ * number(columns_.position[i]);
    if (columns_.has_orientation) pose.orientation = orientation();
    out_.time_s.push_back(time);
    out_.lines.push_back(lines_.line_number());
    out_.poses.push_back(pose);
    if (has_covariance()) add_covariance();
    if (columns_.error_type) check_convention();
  }

 private:
  Eigen::Quaterniond orientation() const {
    const auto& q = columns_.orientation;
    Eigen::Quaterniond turn(number(q[3]), number(q[0]), number(q[1]), number(q[2]));
    if (std::abs(turn.norm() - 1.0) > kUnitTolerance)
      lines_.fail(fmt::format("the quaternion has length {:.4g}, not 1", turn.norm()));
    turn.normalize();
    return turn;
  }

  bool has_covariance() const {
    return !columns_.joint_covariance.empty() || !columns_.position_covariance.empty();
  }

  double number(std::size_t column) const {
    const std::optional<double> value = parse_finite(fields_[column]);
    if (!value) {
      lines_.fail(
          fmt::format("field {}: '{}' is not a finite number", column + 1, shown_field(fields_[column])));
    }
    return *value;
  }

  double time_s() const {
    const double time = columns_.seconds_per_unit * number(columns_.time);
    if (columns_.nanoseconds) return time + 1e-9 * number(*columns_.nanoseconds);
    return columns_.commas && time > kLargestSeconds ? 1e-9 * time : time;
  }

  void fill(PoseCovariance& P, Index first, Index n, const std::vector<std::size_t>& columns) const {
    std::size_t next = 0;
    for (Index i = 0; i < n; ++i) {
      for (Index j = i; j < n; ++j)
        P(first + i, first + j) = P(first + j, first + i) = number(columns[next++]);
    }
  }

  void add_covariance() {
    PoseCovariance P = PoseCovariance::Zero();
    constexpr std::size_t kSquare = 36;
    if (columns_.joint_covariance.size() == kSquare) {
      for (std::size_t i = 0; i < kSquare; ++i)
        P(static_cast<Index>(i / 6), static_cast<Index>(i % 6)) = number(columns_.joint_covariance[i]);
      if (!is_symmetric(P, kMostAsymmetry)) lines_.fail("the covariance is not symmetric");
      P = (0.5 * (P + P.transpose())).eval();
    } else if (!columns_.joint_covariance.empty()) {
      fill(P, 0, 6, columns_.joint_covariance);
    } else {
      fill(P, 0, 3, columns_.position_covariance);
      fill(P, 3, 3, columns_.orientation_covariance);
    }
    out_.covariances.push_back(P);
  }

  /// The words of a cnspy file: the same in all rows.
  void check_convention() {
    const std::string_view type = fields_[*columns_.error_type];
    PoseErrorAxes axes;
    if (type == "type1") {
      axes.position = PositionError::body;
    } else if (type == "type6") {
      axes.orientation = OrientationError::world;
    } else if (type != "type5" && type != "none" && !type.empty()) {
      lines_.fail(fmt::format("error type '{}': accepted are type1, type5, type6", shown_field(type)));
    }
    const std::string_view how = columns_.error_representation ? fields_[*columns_.error_representation] : "";
    static constexpr std::string_view kAccepted[] = {
        "", "none", "R_small_theta", "theta_R", "q_small_theta", "theta_q", "so3_theta"};
    if (std::ranges::find(kAccepted, how) == std::end(kAccepted)) {
      lines_.fail(
          fmt::format("error representation '{}': accepted are R_small_theta, q_small_theta, so3_theta",
                      shown_field(how)));
    }
    const bool first = out_.poses.size() == 1;
    if (!first && axes != out_.axes) lines_.fail("the error type changes within the file");
    out_.axes = axes;
  }

  LineReader& lines_;
  const PoseColumns& columns_;
  double metres_per_unit_;
  Trajectory& out_;
  std::vector<std::string_view> fields_;
};

/// Columns by name; `line` is a header.
PoseColumns named_columns(const LineReader& lines, std::string_view line, bool with_covariance) {
  if (line.starts_with('#')) line.remove_prefix(1);
  const std::vector<std::string_view> names = comma_fields(line);
  const auto find = [&](std::string_view name) -> std::optional<std::size_t> {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names.begin());
  };
  const auto need = [&](std::string_view name) {
    const std::optional<std::size_t> column = find(name);
    if (!column && !with_covariance) {
      lines.fail(
          fmt::format("column '{}' is missing: accepted are a time (t, time, timestamp), x, y, z and, of "
                      "poses, qx, qy, qz, qw, also as "
                      "the last words of longer names, below one line of names (docs/formats.md)",
                      name));
    }
    if (!column) lines.fail(fmt::format("column '{}' is missing", name));
    return *column;
  };
  PoseColumns columns{.commas = true, .fewest = names.size(), .most = names.size(), .time = need("t")};
  columns.position = {need("tx"), need("ty"), need("tz")};
  columns.orientation = {need("qx"), need("qy"), need("qz"), need("qw")};
  if (!with_covariance) return columns;
  for (const char* name : {"pxx", "pxy", "pxz", "pyy", "pyz", "pzz"}) {
    columns.position_covariance.push_back(need(name));
  }
  for (const char* name : {"qrr", "qrp", "qry", "qpp", "qpy", "qyy"}) {
    columns.orientation_covariance.push_back(need(name));
  }
  columns.error_type = find("est_err_type");
  columns.error_representation = find("err_representation");
  return columns;
}

/// Metres of the unit that a header tells of positions; a covariance has to be of metres.
double metres_per_unit(const LineReader& lines, const PoseColumns& columns) {
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"", 1.0}, {"m", 1.0}, {"mm", 1e-3}, {"cm", 1e-2}, {"km", 1e3}};
  const std::string& unit = columns.position_units.front();
  const auto found = std::ranges::find(kUnits, unit, &std::pair<std::string_view, double>::first);
  const bool with_covariance = !columns.joint_covariance.empty();
  if (std::ranges::count(columns.position_units, unit) != std::ssize(columns.position_units) ||
      found == std::end(kUnits) || (with_covariance && found->second != 1.0)) {
    lines.fail(fmt::format(
        "positions in [{}]: accepted is [m]{}", fmt::join(columns.position_units, "], ["),
        with_covariance ? ", with a covariance in m² and rad²" : ", or of all three [mm], [cm] or [km]"));
  }
  return found->second;
}

bool is_comment(std::string_view line) { return line.empty() || line.starts_with('#'); }

/// Reads the rows that follow, `first` before them if it is none of comments.
Trajectory read_rows(LineReader& lines, const PoseColumns& columns, std::optional<std::string_view> first,
                     Trajectory* part = nullptr) {
  Trajectory out;
  out.file = lines.file();
  out.joint_covariance = !columns.joint_covariance.empty();
  out.has_orientation = columns.has_orientation;
  PoseRows rows(lines, columns, metres_per_unit(lines, columns), out);
  try {
    if (first && !is_comment(trim_blanks(*first))) rows.add(*first);
    std::string_view line;
    while (lines.next(line)) {
      if (!is_comment(trim_blanks(line))) rows.add(line);
    }
  } catch (const DataError&) {
    if (part != nullptr) {
      // The row that failed may be there in part.
      out.time_s.resize(out.covariances.size());
      out.lines.resize(out.covariances.size());
      out.poses.resize(out.covariances.size());
      *part = std::move(out);
    }
    throw;
  }
  if (out.poses.empty()) throw DataError(lines.file(), "", "holds no poses");
  return out;
}

std::string_view first_line(LineReader& lines) {
  std::string_view line;
  if (!lines.next(line)) throw DataError(lines.file(), "", "is empty");
  return line;
}

}  // namespace

Trajectory read_estimate(const std::filesystem::path& file, TrajectoryFormat format, PoseErrorAxes axes,
                         Trajectory* part) {
  LineReader lines(file);
  const std::string_view line = first_line(lines);
  if (format == TrajectoryFormat::cnspy) return read_rows(lines, named_columns(lines, line, true), {}, part);
  if (format == TrajectoryFormat::poses) {
    const std::optional<PoseColumns> csv = csv_pose_columns(line, true);
    if (!csv) {
      lines.fail(
          "names no poses with a covariance: accepted are a header with a time, x, y, z, qx, qy, qz, qw and "
          "covariance_0 to covariance_35 (or the 21 of the upper triangle), rows of these without one, and "
          "what ros2 topic echo --csv prints");
    }
    Trajectory out =
        is_pose_header(line) ? read_rows(lines, *csv, {}, part) : read_rows(lines, *csv, line, part);
    out.axes = axes;
    return out;
  }
  PoseColumns columns;
  if (format == TrajectoryFormat::openvins) {
    columns.fewest = columns.most = 20;
    columns.orientation_covariance = columns_from(8, 6);
    columns.position_covariance = columns_from(14, 6);
  } else {
    columns.fewest = columns.most = 29;
    columns.joint_covariance = columns_from(8, 21);
  }
  Trajectory out = read_rows(lines, columns, line, part);
  if (format == TrajectoryFormat::tum) out.axes = axes;
  return out;
}

Trajectory read_truth(const std::filesystem::path& file) {
  constexpr std::size_t kAny = 1000, kPosition = 4;
  LineReader lines(file);
  std::string_view line = first_line(lines);
  while (is_comment(trim_blanks(line)) && line.find(',') == std::string_view::npos && lines.next(line)) {
  }
  const bool commas = line.find(',') != std::string_view::npos;
  if (!commas) {
    PoseColumns columns{.fewest = 8, .most = kAny};
    if (!is_comment(line) && words_between(" \t", line).size() == kPosition) {
      columns.fewest = columns.most = kPosition;
      columns.has_orientation = false;
    }
    return read_rows(lines, columns, line);
  }
  if (const std::optional<PoseColumns> named = csv_pose_columns(line, false)) {
    return is_pose_header(line) ? read_rows(lines, *named, {}) : read_rows(lines, *named, line);
  }
  if (line.find("timestamp") != std::string_view::npos) {
    const PoseColumns euroc{
        .commas = true, .fewest = 8, .most = kAny, .seconds_per_unit = 1e-9, .orientation = {5, 6, 7, 4}};
    return read_rows(lines, euroc, {});
  }
  return read_rows(lines, named_columns(lines, line, false), {});
}

}  // namespace credence::internal
