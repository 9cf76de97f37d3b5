#include "datasets/logs/pose_columns.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>

#include "core/trim_blanks.h"
#include "datasets/logs/number_field.h"

namespace credence::internal {
namespace {

constexpr std::size_t kPositionColumns = 4, kPoseColumns = 8, kTriangleColumns = 21, kSquareColumns = 36;

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

/// "pose.pose.position.x [m]" as "pose_pose_position_x", "covariance[3]" as "covariance_3".
std::string plain_word(std::string_view name) {
  std::string word;
  const std::size_t unit = name.find_first_of("[(");
  const bool has_index = unit != std::string_view::npos && unit + 1 < name.size() &&
                         std::isdigit(static_cast<unsigned char>(name[unit + 1])) != 0;
  for (const char c : has_index ? name : name.substr(0, unit)) {
    if (is_word(c)) {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!word.empty() && word.back() != '_') {
      word += '_';
    }
  }
  while (word.ends_with('_')) word.pop_back();
  return word;
}

/// Finds columns by the last words of their names.
class NamedColumns {
 public:
  explicit NamedColumns(std::string_view header) : fields_(comma_fields(header)) {
    for (const std::string_view field : fields_) words_.push_back(plain_word(field));
  }

  std::size_t count() const { return fields_.size(); }
  std::string_view field(std::size_t column) const { return fields_[column]; }

  /// The first whose name is one of these, or ends with one behind other words.
  std::optional<std::size_t> find(std::span<const std::string> names) const {
    const auto fits = [&](const std::string& word) {
      return std::ranges::any_of(names, [&](const std::string& name) {
        return word == name || (name.size() > 1 && word.ends_with("_" + name));
      });
    };
    const auto found = std::ranges::find_if(words_, fits);
    if (found == words_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - words_.begin());
  }

  /// Those of a covariance: 36 or 21 that are counted behind "cov…", or the upper triangle of P.i.j.
  std::vector<std::size_t> covariance() const {
    std::vector<std::size_t> triangle;
    std::vector<std::pair<int, std::size_t>> counted;  // number, column
    for (std::size_t i = 0; i < words_.size(); ++i) {
      const std::string& word = words_[i];
      const std::size_t digits = word.find_last_not_of("0123456789") + 1;
      const bool is_pose = word.find("twist") == std::string::npos && word.find("vel") == std::string::npos;
      if (digits < word.size() && word.find("cov") != std::string::npos && is_pose) {
        int number = -1;
        std::from_chars(word.data() + digits, word.data() + word.size(), number);
        counted.emplace_back(number, i);
      }
    }
    if (counted.size() == kSquareColumns || counted.size() == kTriangleColumns) {
      // In the order of their numbers: a header that was sorted as text has 10 before 2.
      std::ranges::sort(counted);
      std::vector<std::size_t> columns;
      columns.reserve(counted.size());
      for (const auto& [number, column] : counted) columns.push_back(column);
      return columns;
    }
    for (char i = '1'; i <= '6'; ++i) {
      for (char j = i; j <= '6'; ++j) {
        const auto column = find(std::array{std::string{'p', '_', i, '_', j}, std::string{'p', i, j}});
        if (!column) return {};
        triangle.push_back(*column);
      }
    }
    return triangle;
  }

 private:
  std::vector<std::string_view> fields_;
  std::vector<std::string> words_;
};

/// "mm" of "x [mm]" and "x (mm)"; "" where nothing is told.
std::string unit_of(std::string_view field) {
  const std::size_t begin = field.find_first_of("[(");
  if (begin == std::string_view::npos) return {};
  const std::string_view inside = field.substr(begin + 1);
  return std::string(trim_blanks(inside.substr(0, inside.find_first_of("])"))));
}

/// Of the unit that a header tells behind the name of a time.
double seconds_per_unit(std::string_view field) {
  for (const auto& [unit, seconds] : {std::pair{"ns", 1e-9}, std::pair{"us", 1e-6}, std::pair{"ms", 1e-3}}) {
    const std::size_t at = field.rfind(unit);
    if (at == std::string_view::npos || at == 0 || is_word(field[at - 1])) continue;
    if (at + 2 == field.size() || !is_word(field[at + 2])) return seconds;
  }
  return 1.0;
}

std::optional<PoseColumns> named(std::string_view header, bool with_covariance) {
  const NamedColumns names(header);
  PoseColumns columns{.commas = true, .fewest = names.count(), .most = names.count()};
  const auto nanoseconds = names.find(std::array<std::string, 4>{"nanosec", "nanosecs", "nsec", "nsecs"});
  const auto seconds = names.find(std::array<std::string, 2>{"sec", "secs"});
  const auto time = names.find(std::array<std::string, 8>{"t", "time", "timestamp", "stamp", "time_ns",
                                                          "timestamp_ns", "time_s", "timestamp_s"});
  if (seconds && nanoseconds) {
    columns.time = *seconds;
    columns.nanoseconds = nanoseconds;
  } else if (time) {
    columns.time = *time;
    columns.seconds_per_unit = seconds_per_unit(names.field(*time));
  } else {
    return std::nullopt;
  }
  const auto axis_of = [&](std::initializer_list<const char*> before, char axis, bool alone) {
    std::vector<std::string> all;
    for (const char* const word : before) all.push_back(word + std::string(1, axis));
    if (alone) all.emplace_back(1, axis);
    return names.find(all);
  };
  std::size_t turns = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const char axis = "xyzw"[i];
    const auto turn =
        axis_of({"orientation_", "quaternion_", "quat_", "rotation_", "q", "q_", "r"}, axis, false);
    if (turn) columns.orientation[i] = *turn, ++turns;
    if (i == 3) break;
    const auto place = axis_of({"position_", "pos_", "translation_", "t", "t_", "p", "p_"}, axis, true);
    if (!place) return std::nullopt;
    columns.position[i] = *place;
    columns.position_units[i] = unit_of(names.field(*place));
  }
  columns.has_orientation = turns > 0;
  if (turns > 0 && turns < 4) return std::nullopt;
  if (!with_covariance) return columns;
  if (!columns.has_orientation) return std::nullopt;
  columns.joint_covariance = names.covariance();
  if (columns.joint_covariance.empty()) return std::nullopt;
  return columns;
}

std::optional<PoseColumns> unnamed(std::string_view row, bool with_covariance) {
  const std::vector<std::string_view> fields = comma_fields(row);
  const std::size_t count = fields.size();
  PoseColumns columns{.commas = true, .fewest = count, .most = count};
  // sec, nanosec, frame, of an odometry another frame.
  constexpr std::size_t kPoseTopic = 3 + 7 + kSquareColumns,
                        kOdometry = 4 + 7 + kSquareColumns + 6 + kSquareColumns;
  if ((count == kPoseTopic || count == kOdometry) && !parse_finite(fields[2])) {
    const std::size_t first = count == kPoseTopic ? 3 : 4;
    columns.nanoseconds = 1;
    columns.position = {first, first + 1, first + 2};
    columns.orientation = {first + 3, first + 4, first + 5, first + 6};
    columns.joint_covariance = columns_from(first + 7, kSquareColumns);
    return columns;
  }
  if (!std::ranges::all_of(fields, [](std::string_view field) { return parse_finite(field).has_value(); }))
    return std::nullopt;
  if (count == kPoseColumns + kTriangleColumns || count == kPoseColumns + kSquareColumns) {
    columns.joint_covariance = columns_from(kPoseColumns, count - kPoseColumns);
    return columns;
  }
  columns.has_orientation = count != kPositionColumns;
  if (with_covariance || (columns.has_orientation && count < kPoseColumns)) return std::nullopt;
  return columns;
}

}  // namespace

std::vector<std::size_t> columns_from(std::size_t first, std::size_t count) {
  std::vector<std::size_t> all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = first + i;
  return all;
}

bool is_pose_header(std::string_view line) {
  const std::string_view first = trim_blanks(line.substr(0, line.find(',')));
  return !parse_finite(first);
}

std::optional<PoseColumns> csv_pose_columns(std::string_view line, bool with_covariance) {
  if (line.find(',') == std::string_view::npos) return std::nullopt;
  return is_pose_header(line) ? named(line, with_covariance) : unnamed(line, with_covariance);
}

}  // namespace credence::internal
