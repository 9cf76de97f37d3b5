#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/nan.h"
#include "datasets/logs/filter_log_header.h"
#include "datasets/logs/line_reader.h"
#include "datasets/logs/log_format.h"

namespace credence::internal {

/// The rows of a log in the project's own CSV format (docs/formats.md), streamed in bounded memory.
///
/// Throws DataError with file and line for what cannot be meant: an empty file, a header or a row that does
/// not fit, a field that is no finite number, steps or times that do not increase, a run whose rows do not
/// stand together. A row whose covariance is not symmetric is data: Step::problem says so.
class FilterLogReader {
 public:
  explicit FilterLogReader(const std::filesystem::path& file);

  const RunLayout& layout() const { return header_.layout; }

  /// Whether its rows hold errors in the place of estimate and truth.
  bool has_errors() const { return !header_.error.empty(); }

  /// Reads the next row; false at the end. `row` keeps its memory from call to call.
  bool next(Step& row);

  /// True if the row last read begins another run.
  bool run_began() const { return run_began_; }
  /// What the column `run` says of the row last read; none in a file without it. A whole number of at most 15
  /// digits is a number, and any other one is what is written: a double does not hold all digits of a date.
  std::optional<std::string> run() const {
    return header_.run < 0 ? std::nullopt : std::optional(run_text());
  }

  /// A line "# failed: OUTCOME at step N" just before the row last read, or the end: how the run before it
  /// ended.
  struct Failure {
    Outcome outcome = Outcome::diverged;
    std::int64_t step = 0;
  };
  const std::optional<Failure>& failure() const { return failure_; }

  /// Where the row last read has the truth of the block "position"; false where it has none.
  bool true_position(Vector& place) const;

  /// When the row last read was; NaN in a file that does not say so.
  double time_s() const { return header_.time < 0 ? kNaN : time_; }

  std::int64_t bytes_read() const { return lines_.bytes_read(); }

 private:
  bool next_line(std::string_view& line);
  void parse_fields(std::string_view line);
  double parse_field(std::string_view text, std::size_t column) const;
  void read_comment(std::string_view line);
  void check_order(std::string_view line);
  std::string run_text() const;
  void read_state(Step& row) const;
  void read_innovations(Step& row);
  void read_noise(std::size_t sensor, std::string_view& problem);
  void read_flag(Index column, const char* name, bool& flag);
  /// Returns a column that is blank although it is needed, else −1.
  Index read_symmetric(const FilterLogHeader::Symmetric& matrix, std::span<const Index> kept, Index size,
                       Matrix& out, std::string_view& problem) const;

  LineReader lines_;
  FilterLogHeader header_;
  std::vector<double> fields_;      // NaN for a blank
  std::vector<char> long_;          // of each column: its last number was too long for a short one
  std::vector<Index> kept_;         // components of an innovation that are there
  std::vector<Matrix> noise_;       // R of each sensor as last said, empty before
  std::vector<std::string> names_;  // of the columns, for messages
  std::set<std::string> runs_;
  double run_ = 0.0, time_ = 0.0;
  std::string long_run_;  // as written where run_ does not hold it, else empty
  std::int64_t step_ = 0;
  bool from_zero_ = false;  ///< the steps of the file are counted from 0
  bool run_began_ = false;
  std::int64_t rows_ = 0;  ///< read so far, of all runs
  std::optional<Failure> failure_;
};

/// --input credence.
LogFormat own_format();

}  // namespace credence::internal
