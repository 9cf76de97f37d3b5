#include "datasets/logs/rtklib.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "core/manifold/angle.h"
#include "core/trim_blanks.h"
#include "datasets/data_error.h"
#include "datasets/logs/distance_travelled.h"
#include "datasets/logs/geodesy.h"
#include "datasets/logs/line_reader.h"
#include "datasets/logs/number_field.h"
#include "datasets/logs/partial_read.h"
#include "datasets/logs/trajectory_errors.h"
#include "datasets/logs/truth_rows.h"

namespace credence::internal {
namespace {

constexpr double kDay_s = 86400.0, kWeek_s = 7.0 * kDay_s;
constexpr std::array<const char*, 7> kQualities = {"none", "fix", "float", "sbas", "dgps", "single", "ppp"};

/// In which coordinates the positions are.
enum class Coordinates { geodetic, earth_fixed, baseline };

class SolutionReader {
 public:
  explicit SolutionReader(const std::filesystem::path& file) : lines_(file) {}

  void read(GnssSolution& solution) {
    solution.file = lines_.file();
    std::optional<Coordinates> coordinates;
    std::string_view line;
    while (lines_.next(line)) {
      if (trim_blanks(line).empty()) continue;
      if (line.starts_with('%')) {
        if (const auto named = coordinates_of(line)) {
          coordinates = named;
          const std::vector<std::string_view> words = words_between(" \t%", line);
          constexpr std::string_view kSystems[] = {"GPST", "UTC", "JST"};
          if (std::ranges::count(kSystems, words.front()) > 0) solution.time_system = words.front();
        }
        continue;
      }
      if (!coordinates) {
        lines_.fail(
            "no line '%  GPST  latitude(deg) …' names the columns before the first row (RTKLIB writes "
            "it with out-outhead = on)");
      }
      solution.baseline = *coordinates == Coordinates::baseline;
      GnssFix fix = row(line, *coordinates);
      if (!solution.fixes.empty() && !(fix.time_s > solution.fixes.back().time_s)) {
        lines_.fail("the time does not increase");
      }
      solution.fixes.push_back(fix);
    }
    if (solution.fixes.empty()) throw DataError(lines_.file(), "", "holds no solutions");
  }

 private:
  std::optional<Coordinates> coordinates_of(std::string_view line) const {
    if (line.find("latitude(deg)") != std::string_view::npos) return Coordinates::geodetic;
    if (line.find("x-ecef(m)") != std::string_view::npos) return Coordinates::earth_fixed;
    if (line.find("e-baseline(m)") != std::string_view::npos) return Coordinates::baseline;
    if (line.find("latitude(d'\")") != std::string_view::npos) {
      lines_.fail("degrees, minutes and seconds are not read; write degrees (out-degform = deg)");
    }
    return std::nullopt;
  }

  double number(std::string_view field) const {
    const std::optional<double> value = parse_finite(field);
    if (!value) lines_.fail(fmt::format("'{}' is not a finite number", shown_field(field)));
    return *value;
  }

  /// "2012/06/10 00:00:00.000", or week and seconds.
  double time(std::string_view first, std::string_view second) const {
    if (first.find('/') == std::string_view::npos) return kWeek_s * number(first) + number(second);
    if (first.size() != 10 || first[4] != '/' || first[7] != '/' || second.size() < 8 || second[2] != ':' ||
        second[5] != ':') {
      lines_.fail(
          fmt::format("'{} {}' is no time: accepted are year/month/day hour:minute:second, and week and "
                      "seconds",
                      shown_field(first), shown_field(second)));
    }
    namespace ch = std::chrono;
    const auto whole = [&](std::string_view field) {
      constexpr double kLargest = 9999.0;
      const double value = number(field);
      if (!(value >= 0.0 && value <= kLargest) || std::floor(value) != value) {
        lines_.fail(fmt::format("'{}' is no whole number of a date", shown_field(field)));
      }
      return static_cast<int>(value);
    };
    const ch::year_month_day day{ch::year(whole(first.substr(0, 4))),
                                 ch::month(static_cast<unsigned int>(whole(first.substr(5, 2)))),
                                 ch::day(static_cast<unsigned int>(whole(first.substr(8, 2))))};
    if (!day.ok()) lines_.fail(fmt::format("'{}' is no day", shown_field(first)));
    constexpr ch::year_month_day kWeekZero{ch::year(1980), ch::January, ch::day(6)};
    const auto days = (ch::sys_days(day) - ch::sys_days(kWeekZero)).count();
    return kDay_s * static_cast<double>(days) + 3600.0 * number(second.substr(0, 2)) +
           60.0 * number(second.substr(3, 2)) + number(second.substr(6));
  }

  GnssFix row(std::string_view line, Coordinates coordinates) const {
    constexpr std::size_t kNeeded = 13;
    const std::vector<std::string_view> fields = words_between(" \t,", line);
    if (fields.size() < kNeeded) {
      lines_.fail(
          fmt::format("{} fields where at least {} are expected: time, position, Q, ns and six standard "
                      "deviations",
                      fields.size(), kNeeded));
    }
    GnssFix fix;
    fix.line = lines_.line_number();
    fix.time_s = time(fields[0], fields[1]);
    const Eigen::Vector3d place(number(fields[2]), number(fields[3]), number(fields[4]));
    const double quality = number(fields[5]);
    if (!(quality >= 0.0 && quality < static_cast<double>(kQualities.size())) ||
        std::floor(quality) != quality) {
      lines_.fail(fmt::format("Q = {}: accepted are 0 to 6", quality));
    }
    fix.quality = static_cast<int>(quality);
    Eigen::Matrix3d C;
    std::array<double, 6> sd{};
    for (std::size_t i = 0; i < sd.size(); ++i) {
      const double value = number(fields[7 + i]);
      sd[i] = std::copysign(value * value, value);
    }
    C << sd[0], sd[3], sd[5], sd[3], sd[1], sd[4], sd[5], sd[4], sd[2];
    if (coordinates == Coordinates::baseline) {
      fix.earth_fixed = place;
      fix.covariance = C;
    } else if (coordinates == Coordinates::geodetic) {
      fix.earth_fixed =
          earth_fixed({kRadiansPerDegree * place.x(), kRadiansPerDegree * place.y(), place.z()});
      // The file's order is north, east, up.
      const Eigen::PermutationMatrix<3> swap(Eigen::Vector3i(1, 0, 2));
      fix.covariance = swap * C * swap;
    } else {
      fix.earth_fixed = place;
      const Eigen::Matrix3d R = east_north_up(geodetic(place));
      fix.covariance = R * C * R.transpose();
    }
    return fix;
  }

  LineReader lines_;
};

/// The truth at a time; a survey point holds for all times.
std::optional<GnssFix> truth_fix(const GnssSolution& truth, double time_s,
                                 const TrajectoryMatching& matching) {
  if (truth.fixes.size() == 1) return truth.fixes.front();
  const std::optional<TruthRows> rows = truth_rows(truth.fixes, time_s, matching, &GnssFix::time_s);
  if (!rows) return std::nullopt;
  GnssFix between = truth.fixes[rows->row];
  if (rows->share == 0.0) return between;
  const GnssFix& after = truth.fixes[rows->row + 1];
  between.time_s = time_s;
  between.earth_fixed += rows->share * (after.earth_fixed - between.earth_fixed);
  between.covariance += rows->share * (after.covariance - between.covariance);
  return between;
}

/// Leap seconds are not undone.
void require_one_time_system(const GnssSolution& log, const GnssSolution& truth) {
  if (truth.fixes.size() == 1 || log.time_system.empty() || truth.time_system.empty()) return;
  if (log.time_system == truth.time_system) return;
  throw DataError(truth.file, "",
                  fmt::format("its times are {} and those of {} {}: write both in one (RTKLIB: out-timesys)",
                              truth.time_system, log.file.string(), log.time_system));
}

/// "1692 10.000 to 1692 11.000".
std::string times_of(const GnssSolution& solution) {
  const auto text = [](double time_s) {
    const double week = std::floor(time_s / kWeek_s);
    return fmt::format("{} {:.3f}", week, time_s - week * kWeek_s);
  };
  return text(solution.fixes.front().time_s) + " to " + text(solution.fixes.back().time_s);
}

void read_solution(const std::filesystem::path& file, const LogReading& options, LogSink& sink) {
  if (options.truth.empty()) {
    throw std::invalid_argument(fmt::format(
        "{}: a solution has no truth in it: name by --truth another .pos, a better solution or a survey "
        "point (one row)",
        file.string()));
  }
  GnssSolution log;
  read_part(
      options, sink, [&] { log = read_rtklib(file, &log); }, [&] { return !log.fixes.empty(); });
  const GnssSolution truth = read_rtklib(options.truth.file_of(file));
  if (log.baseline != truth.baseline) {
    throw DataError(truth.file, "", "one of truth and log holds baselines, the other positions on the earth");
  }
  require_one_time_system(log, truth);
  std::map<int, Index> first_state;  // by quality
  for (const GnssFix& fix : log.fixes) first_state.try_emplace(fix.quality, 0);
  RunLayout layout;
  for (auto& [quality, first] : first_state) {
    first = std::ssize(layout.states);
    for (const char* axis : {"east", "north", "up"}) {
      layout.states.push_back(fmt::format("{}.{}", kQualities[static_cast<std::size_t>(quality)], axis));
    }
  }
  layout.angles.assign(layout.states.size(), false);
  layout.units.assign(layout.states.size(), "m");
  add_named_blocks(layout);
  sink.begin_run(layout);
  Step step;
  std::int64_t unmatched = 0;
  DistanceTravelled travelled;
  for (const GnssFix& fix : log.fixes) {
    const std::optional<GnssFix> at = truth_fix(truth, fix.time_s, options.matching);
    if (!at) {
      ++unmatched;
      continue;
    }
    ++step.step;
    step.line = fix.line;
    const Index first = first_state.at(fix.quality);
    step.states = {first, first + 1, first + 2};
    const Eigen::Vector3d difference = fix.earth_fixed - at->earth_fixed;
    step.error =
        log.baseline ? difference : Eigen::Vector3d(east_north_up(geodetic(at->earth_fixed)) * difference);
    step.P = fix.covariance + at->covariance;
    if (truth.fixes.size() > 1) sink.travelled(travelled.at(at->earth_fixed));
    sink.at(fix.time_s);
    sink.add(step);
  }
  if (step.step == 0) {
    throw DataError(
        file, "",
        fmt::format("no row has a truth at its time in {}: estimates from {}, truth from {} (week "
                    "and seconds), within {} s (--max-time-difference, --truth-time nearest)",
                    truth.file.string(), times_of(log), times_of(truth),
                    options.matching.max_time_difference_s));
  }
  sink.unmatched(unmatched);
  if (std::ranges::any_of(truth.fixes, [](const GnssFix& fix) { return !fix.covariance.isZero(0.0); })) {
    sink.remark(
        fmt::format("{}: the truth has a covariance of its own, which is added to P.", truth.file.string()));
  }
  sink.advance(static_cast<std::int64_t>(std::filesystem::file_size(file)));
}

LogContents list_solution(const std::filesystem::path& file) {
  const GnssSolution log = read_rtklib(file);
  std::map<int, std::int64_t> counts;
  for (const GnssFix& fix : log.fixes) ++counts[fix.quality];
  LogContents contents{.topics = {}, .remark = "The truth is to be named by --truth."};
  for (const auto& [quality, count] : counts) {
    contents.topics.push_back({.name = fmt::format("Q = {}", quality),
                               .type = kQualities[static_cast<std::size_t>(quality)],
                               .count = count,
                               .use = "estimate, truth",
                               .covariance = true});
  }
  return contents;
}

}  // namespace

GnssSolution read_rtklib(const std::filesystem::path& file, GnssSolution* part) {
  GnssSolution solution;
  try {
    SolutionReader(file).read(solution);
  } catch (const DataError&) {
    if (part != nullptr) *part = std::move(solution);
    throw;
  }
  return solution;
}

LogFormat rtklib_format() {
  return {.name = "rtklib",
          .title = "RTKLIB solution",
          .extensions = ".pos",
          .takes_truth = true,
          .recognises =
              [](std::string_view beginning, const std::filesystem::path& file) {
                return file.extension() == ".pos" ||
                       (beginning.starts_with('%') && (beginning.find("GPST") != std::string_view::npos ||
                                                       beginning.find("UTC") != std::string_view::npos));
              },
          .list = list_solution,
          .read = read_solution};
}

}  // namespace credence::internal
