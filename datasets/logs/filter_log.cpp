#include "datasets/logs/filter_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/append_item.h"
#include "core/linear_algebra/symmetry.h"
#include "core/manifold/angle.h"
#include "core/nan.h"
#include "core/trim_blanks.h"
#include "datasets/data_error.h"
#include "datasets/logs/assumed_noise.h"
#include "datasets/logs/conventions/log_conventions.h"
#include "datasets/logs/distance_travelled.h"
#include "datasets/logs/number_field.h"
#include "datasets/logs/short_fields.h"
#include "datasets/logs/short_number.h"

namespace credence::internal {
namespace {

// A step beyond this is a mistake, and would ask for gigabytes; and so is one far beyond the rows there are.
constexpr std::int64_t kLargestStep = 10'000'000;
constexpr std::int64_t kLargestGap = 100'000, kLargestStepsPerRow = 100;

/// Where the entry (i, j), i ≤ j, of an n×n matrix stands when its upper triangle is listed by rows.
std::size_t triangle_index(Index i, Index j, Index n) {
  return static_cast<std::size_t>(i * n - i * (i - 1) / 2 + (j - i));
}

constexpr const char* kBeforeItsRun =
    "a line '# failed: …' stands behind the last row of its run, and before this line there is none";

/// Whether it is whole and of at most 15 digits: all that a double holds.
bool is_short_whole(double run) { return std::abs(run) < 1e15 && std::floor(run) == run; }

/// The field of a column as it is written, of a line that has it.
std::string_view written_field(std::string_view line, Index column) {
  for (; column > 0; --column) line.remove_prefix(line.find(',') + 1);
  return trim_quotes(trim_blanks(line.substr(0, line.find(','))));
}

/// "nan" as programs write it, in letters of either case, with a sign or without.
bool is_nan_word(std::string_view field) {
  if (field.front() == '-' || field.front() == '+') field.remove_prefix(1);
  return std::ranges::equal(field, std::string_view("nan"), {},
                            [](char c) { return c < 'a' ? static_cast<char>(c + ('a' - 'A')) : c; });
}

}  // namespace

FilterLogReader::FilterLogReader(const std::filesystem::path& file) : lines_(file) {
  std::string_view line;
  if (!next_line(line)) throw DataError(file, "", "is empty: the first line names the columns");
  if (failure_) lines_.fail(kBeforeItsRun);
  try {
    header_ = parse_filter_log_header(line);
  } catch (const std::invalid_argument& error) {
    lines_.fail(error.what());
  }
  for (const std::string_view name : comma_fields(line)) names_.emplace_back(name);
  fields_.resize(static_cast<std::size_t>(header_.columns));
  long_.resize(fields_.size() + 1);  // and of all fields too many
  noise_.resize(header_.innovations.size());
}

bool FilterLogReader::next_line(std::string_view& line) {
  while (lines_.next(line)) {
    if (trim_blanks(line).empty()) continue;
    if (!line.starts_with('#')) return true;
    read_comment(line);
  }
  return false;
}

void FilterLogReader::read_comment(std::string_view line) {
  constexpr std::string_view kFailed = "# failed: ", kAtStep = " at step ";
  if (!line.starts_with(kFailed)) return;
  if (failure_) lines_.fail("a second line '# failed: …' behind one run: each run has one");
  line.remove_prefix(kFailed.size());
  const std::size_t at = line.find(kAtStep);
  const double step =
      at == std::string_view::npos ? 0.0 : parse_finite(line.substr(at + kAtStep.size())).value_or(0.0);
  const Outcome outcome = outcome_named(line.substr(0, at)).value_or(Outcome::ok);
  if (outcome == Outcome::ok || step < 1.0 || step > static_cast<double>(kLargestStep) ||
      std::floor(step) != step) {
    lines_.fail("accepted is '# failed: diverged at step N', with not_positive_definite or threw likewise");
  }
  failure_ = Failure{outcome, static_cast<std::int64_t>(step) + (from_zero_ ? 1 : 0)};
}

void FilterLogReader::parse_fields(std::string_view line) {
  static_assert(LineReader::kReadable >= kReadBeyond);
  constexpr std::ptrdiff_t kLongestShort = 15;  // characters
  std::size_t count = 0;
  const std::size_t columns = fields_.size();
  const char* begin = line.data();
  const char* const line_end = begin + line.size();
  for (; begin <= line_end; ++begin, ++count) {
    begin = read_short_fields(begin, line_end, fields_, count);
    if (begin > line_end) break;
    double number = 0.0;
    char& is_long = long_[std::min(count, columns)];
    const char* end = is_long ? nullptr : read_short_number(begin, line_end, number);
    if (end == nullptr) {
      const auto [stop, error] = std::from_chars(begin, line_end, number);
      is_long = stop - begin > kLongestShort;
      if (error == std::errc() && std::isfinite(number)) end = stop;
    }
    if (end == nullptr || (end != line_end && *end != ',')) {
      end = std::find(begin, line_end, ',');
      if (count < columns) number = parse_field({begin, end}, count);
    }
    if (count < columns) fields_[count] = number;
    begin = end;
  }
  if (count != columns) {
    lines_.fail(fmt::format("{} fields where the header names {} columns", count, columns));
  }
}

double FilterLogReader::parse_field(std::string_view text, std::size_t column) const {
  const std::string_view field = trim_quotes(trim_blanks(text));
  if (field.empty() || is_nan_word(field)) return kNaN;
  if (const std::optional<double> number = parse_finite(field)) return *number;
  lines_.fail(fmt::format("column {}: '{}' is not a finite number (a missing value is a blank field or nan)",
                          shown_field(names_[column]), shown_field(field)));
}

std::string FilterLogReader::run_text() const {
  return long_run_.empty() ? fmt::format("{}", run_ + 0.0) : long_run_;  // no −0
}

void FilterLogReader::check_order(std::string_view line) {
  const auto field = [&](Index column, const char* name) {
    const double value = fields_[static_cast<std::size_t>(column)];
    if (std::isnan(value)) lines_.fail(fmt::format("column {} is blank", name));
    return value;
  };
  run_began_ = rows_ == 0;
  if (header_.run >= 0) {
    const double run = field(header_.run, "run");
    const std::string_view long_run = is_short_whole(run) ? "" : written_field(line, header_.run);
    run_began_ = run_began_ || run != run_ || long_run != long_run_;
    if (run_began_) {
      run_ = run;
      long_run_ = long_run;
      if (const std::string name = run_text(); !runs_.insert(name).second)
        lines_.fail(fmt::format("the rows of run {} do not stand together", shown_field(name)));
    }
  }
  if (header_.time >= 0) {
    double time = field(header_.time, "time");
    if (time > kLargestSeconds) time *= 1e-9;
    if (!run_began_ && !(time > time_)) {
      lines_.fail(
          fmt::format("time {} does not increase: the row before has {}; a run that begins anew is told "
                      "by a column run, or has its own file",
                      time, time_));
    }
    time_ = time;
  }
  if (header_.step < 0) {
    step_ = run_began_ ? 1 : step_ + 1;
    if (step_ > kLargestStep) lines_.fail(fmt::format("a run of more than {} rows", kLargestStep));
  } else {
    const double written = field(header_.step, "step");
    if (rows_ == 0) from_zero_ = written == 0.0;
    const double step = written + (from_zero_ ? 1.0 : 0.0);
    if (written == 0.0 && !from_zero_)
      lines_.fail(
          "step 0 in a file whose first step is not 0: steps are counted from 1 here, since only a first 0 "
          "tells that they are not; add 1 to all, or let the run that has step 0 be the first");
    if (!(step >= 1.0 && step <= static_cast<double>(kLargestStep)) || std::floor(step) != step) {
      lines_.fail(fmt::format("step {}: accepted are whole numbers, counted from 0 or 1, to {}", written,
                              kLargestStep));
    }
    const auto whole = static_cast<std::int64_t>(step);
    if (whole > kLargestGap + kLargestStepsPerRow * rows_) {
      lines_.fail(
          fmt::format("step {} with {} rows before it: the steps of a run are counted from 0 or 1, and a "
                      "log has at least a row for every {} of them",
                      written, rows_, kLargestStepsPerRow));
    }
    if (!run_began_ && whole <= step_) {
      lines_.fail(fmt::format("step {} does not increase: the row before has {}", written,
                              step_ - (from_zero_ ? 1 : 0)));
    }
    step_ = whole;
  }
  ++rows_;
}

Index FilterLogReader::read_symmetric(const FilterLogHeader::Symmetric& matrix, std::span<const Index> kept,
                                      Index size, Matrix& out, std::string_view& problem) const {
  const Index n = std::ssize(kept);
  const double* const value = fields_.data();
  const Index *const upper = matrix.upper.data(), *const lower = matrix.lower.data();
  out.resize(n, n);
  double* const P = out.data();
  Index missing = -1;
  bool full = false;
  std::size_t next = 0;  // of all components in their order
  for (Index i = 0; i < n; ++i) {
    for (Index j = i; j < n; ++j) {
      const std::size_t place = n == size ? next++
                                          : triangle_index(kept[static_cast<std::size_t>(i)],
                                                           kept[static_cast<std::size_t>(j)], size);
      const double entry = value[upper[place]];
      P[i + j * n] = P[j + i * n] = entry;
      if (std::isnan(entry)) missing = upper[place];
      if (lower[place] < 0) continue;
      full = true;
      P[i + j * n] = value[lower[place]];
      if (std::isnan(P[i + j * n])) missing = lower[place];
    }
  }
  if (!full || missing >= 0) return missing;
  if (!make_symmetric(out)) problem = "a covariance is not symmetric";
  return -1;
}

void FilterLogReader::read_state(Step& row) const {
  row.states.clear();
  const Index n = std::ssize(header_.layout.states);
  if (!header_.layout.has_truth) return;
  const auto field = [&](const std::vector<Index>& columns, Index state) {
    return fields_[static_cast<std::size_t>(columns[static_cast<std::size_t>(state)])];
  };
  const auto error_of = [&](Index state) {  // NaN: not there
    return header_.error[static_cast<std::size_t>(state)] >= 0
               ? field(header_.error, state)
               : field(header_.estimate, state) - field(header_.truth, state);
  };
  for (Index i = 0; i < n; ++i) {
    if (!std::isnan(error_of(i))) row.states.push_back(i);
  }
  row.error.resize(std::ssize(row.states));
  row.estimate.resize(header_.layout.componentwise ? row.error.size() : 0);
  for (Index i = 0; i < row.error.size(); ++i) {
    const Index state = row.states[static_cast<std::size_t>(i)];
    if (header_.layout.componentwise) {
      const bool known = header_.estimate[static_cast<std::size_t>(state)] >= 0;
      row.estimate[i] = known ? field(header_.estimate, state) : kNaN;
    }
    row.error[i] = error_of(state);
    if (header_.layout.angles[static_cast<std::size_t>(state)]) row.error[i] = wrap_angle(row.error[i]);
  }
  const Index missing = read_symmetric(header_.P, row.states, n, row.P, row.problem);
  if (missing >= 0) {
    lines_.fail(fmt::format("column {} is blank although its states have an estimate or an error",
                            names_[static_cast<std::size_t>(missing)]));
  }
}

void FilterLogReader::read_flag(Index column, const char* name, bool& flag) {
  if (column < 0) return;
  const double value = fields_[static_cast<std::size_t>(column)];
  const bool first = rows_ == 1;
  if (!first && (std::isnan(value) || value == (flag ? 1.0 : 0.0))) return;
  if (!first)
    lines_.fail(fmt::format("column {}: what it says of the filter changes; blank: as before", name));
  if (value != 0.0 && value != 1.0) {
    lines_.fail(
        fmt::format("column {}: the first row says 1 for a filter that is, 0 for one that is not", name));
  }
  flag = value == 1.0;
}

void FilterLogReader::read_noise(std::size_t sensor, std::string_view& problem) {
  const FilterLogHeader::Innovation& columns = header_.innovations[sensor];
  if (columns.noise_dim == 0) return;
  const auto blank = [&](Index column) {
    return column < 0 || std::isnan(fields_[static_cast<std::size_t>(column)]);
  };
  if (std::ranges::all_of(columns.R.upper, blank) && std::ranges::all_of(columns.R.lower, blank)) return;
  std::vector<Index> all;
  for (Index i = 0; i < columns.noise_dim; ++i) all.push_back(i);
  const Index missing = read_symmetric(columns.R, all, columns.noise_dim, noise_[sensor], problem);
  if (missing >= 0) {
    lines_.fail(fmt::format("column {} is blank where others of its matrix are not: all blank is as before",
                            names_[static_cast<std::size_t>(missing)]));
  }
  if ((noise_[sensor].diagonal().array() < 0.0).any()) lines_.fail("a variance of R is negative");
}

void FilterLogReader::read_innovations(Step& row) {
  row.innovations.resize(header_.innovations.size());
  std::vector<Index>& kept = kept_;
  for (std::size_t s = 0; s < header_.innovations.size(); ++s) {
    const FilterLogHeader::Innovation& columns = header_.innovations[s];
    if (const Sensor& sensor = header_.layout.sensors[s]; sensor.nis_alone) {
      const double nis = fields_[static_cast<std::size_t>(columns.nu.front())];
      row.innovations[s] = nis >= 0.0 ? nis_alone(nis) : Innovation{};
      if (nis < 0.0) row.problem = "a NIS is negative";
      continue;
    }
    kept.clear();
    kept.reserve(columns.nu.size());
    for (Index i = 0; i < std::ssize(columns.nu); ++i) {
      if (!std::isnan(fields_[static_cast<std::size_t>(columns.nu[static_cast<std::size_t>(i)])])) {
        kept.push_back(i);
      }
    }
    read_noise(s, row.problem);
    Innovation& innovation = row.innovations[s];
    innovation.nu.resize(std::ssize(kept));
    for (std::size_t i = 0; i < kept.size(); ++i) {
      innovation.nu[static_cast<Index>(i)] =
          fields_[static_cast<std::size_t>(columns.nu[static_cast<std::size_t>(kept[i])])];
    }
    const Index missing = read_symmetric(columns.S, kept, std::ssize(columns.nu), innovation.S, row.problem);
    if (missing >= 0) {
      lines_.fail(fmt::format("column {} is blank although its innovation is there",
                              names_[static_cast<std::size_t>(missing)]));
    }
    const Index piece = header_.layout.sensors[s].piece;
    const bool whole = kept.size() == columns.nu.size() && std::ssize(kept) == piece;
    innovation.complete = whole || are_complete(kept, piece);
    take_assumed_noise(noise_[s], piece, kept, innovation.R);
  }
}

bool FilterLogReader::true_position(Vector& place) const {
  const std::vector<Block>& blocks = header_.layout.blocks;
  const auto block = std::ranges::find(blocks, Part::position, &Block::part);
  if (header_.truth.empty() || block == blocks.end()) return false;
  place.resize(std::ssize(block->states));
  for (Index i = 0; i < place.size(); ++i) {
    const auto state = static_cast<std::size_t>(block->states[static_cast<std::size_t>(i)]);
    if (header_.truth[state] < 0) return false;
    place[i] = fields_[static_cast<std::size_t>(header_.truth[state])];
  }
  return place.size() > 0 && place.allFinite();
}

bool FilterLogReader::next(Step& row) {
  failure_.reset();
  std::string_view line;
  if (!next_line(line)) {
    run_began_ = false;
    if (rows_ == 0 && !failure_) lines_.fail("holds no rows");
    return false;
  }
  if (failure_ && rows_ == 0) lines_.fail(kBeforeItsRun);
  parse_fields(line);
  check_order(line);
  if (failure_ && !run_began_)
    lines_.fail(
        "the line '# failed: …' before stands behind the last row of its run, and this row is of the same");
  read_flag(header_.nonlinear, "nonlinear", header_.layout.nonlinear);
  read_flag(header_.inflated, "inflated", header_.layout.inflated);
  row.step = step_;
  row.line = lines_.line_number();
  row.problem = {};
  read_state(row);
  read_innovations(row);
  return true;
}

namespace {

void read_own_log(const std::filesystem::path& file, const LogReadOptions& /*options*/, LogSink& judged) {
  constexpr std::int64_t kRowsBetween = 4096;
  FilterLogReader reader(file);
  LogConventions conventions(judged);
  LogSink& sink = conventions.sink();
  Step row;
  std::int64_t rows = 0, told = 0;
  bool open = false;
  const auto end_failed = [&] {
    if (!reader.failure()) return;
    if (!open) sink.begin_run(reader.layout());  // it failed before its first row
    sink.end_run(reader.failure()->outcome, reader.failure()->step);
    open = false;
  };
  DistanceTravelled travelled;
  Vector place;
  while (reader.next(row)) {
    if (reader.run_began()) {
      end_failed();
      if (const auto number = reader.run()) sink.run_number(*number);
      sink.begin_run(reader.layout());
      open = true;
      travelled = {};
    }
    if (reader.true_position(place)) sink.travelled(travelled.at(place));
    sink.at(reader.time_s());
    sink.add(row);
    if (++rows % kRowsBetween == 0) {
      sink.advance(reader.bytes_read() - told);
      told = reader.bytes_read();
    }
  }
  end_failed();
  conventions.finish();
  sink.advance(reader.bytes_read() - told);
}

LogContents list_own_log(const std::filesystem::path& file) {
  FilterLogReader reader(file);
  const RunLayout& layout = reader.layout();
  LogTopic state{.name = reader.has_errors() ? "error" : "estimate",
                 .type = fmt::format("{} states", layout.states.size()),
                 .use = reader.has_errors() ? "error"
                        : layout.has_truth  ? "estimate with its truth"
                                            : ""};
  state.covariance = layout.has_truth;
  std::vector<LogTopic> sensors;
  for (const Sensor& sensor : layout.sensors) {
    sensors.push_back({.name = sensor.name.empty() ? "innovation" : "innovation " + sensor.name,
                       .type = fmt::format("dimension {}", sensor.dim),
                       .use = sensor.nis_alone ? "NIS alone" : "innovations",
                       .covariance = !sensor.nis_alone});
  }
  Step row;
  std::int64_t runs = 0;
  while (reader.next(row)) {
    runs += reader.run_began() ? 1 : 0;
    state.count += row.states.empty() ? 0 : 1;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      sensors[i].count += row.innovations[i].nu.size() > 0 ? 1 : 0;
    }
  }
  LogContents contents{.topics = std::move(sensors), .remark = counted(runs, "run") + "."};
  if (!layout.states.empty()) contents.topics.insert(contents.topics.begin(), std::move(state));
  return contents;
}

/// A first line that is no comment, of names separated by commas, one of them what a log of ours must have.
bool begins_as_own_log(std::string_view beginning, const std::filesystem::path& file) {
  if (file.extension() == ".csv") return true;
  const std::string_view header = beginning.substr(0, beginning.find('\n'));
  return header.find("innovation.") != std::string_view::npos ||
         header.find("nis.") != std::string_view::npos ||
         header.find("estimate.") != std::string_view::npos ||
         header.find("error.") != std::string_view::npos;
}

}  // namespace

LogFormat own_format() {
  return {.name = "credence",
          .title = "Credence CSV",
          .extensions = ".csv",
          .recognises = begins_as_own_log,
          .list = list_own_log,
          .read = read_own_log};
}

}  // namespace credence::internal
