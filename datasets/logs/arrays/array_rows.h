#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.h"
#include "datasets/logs/arrays/array_log.h"
#include "datasets/logs/arrays/array_roles.h"
#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// Reads the rows of an array, one for each step of each run, some at a time.
class RowReader {
 public:
  /// `size`: the numbers in a row.
  RowReader(ArrayFile& file, std::size_t array, std::uint64_t steps, std::uint64_t size)
      : file_(file), array_(array), steps_(steps), size_(size) {}

  const double* row(std::uint64_t run, std::uint64_t step) {
    if (run != run_ || step < first_ || step >= first_ + count_) load(run, step);
    return values_.data() + (step - first_) * size_;
  }

 private:
  void load(std::uint64_t run, std::uint64_t step);

  ArrayFile& file_;
  std::size_t array_;
  std::uint64_t steps_, size_;
  std::vector<double> values_;
  std::uint64_t run_ = 0, first_ = 0, count_ = 0;
};

/// Reads one step after another of a pair of arrays.
class PairReader {
 public:
  /// `less`: an array of the same dimensions that is taken from the vectors.
  PairReader(ArrayFile& file, const ArrayPair& pair, std::optional<std::size_t> less = {});

  /// Writes the components that are not NaN, and their covariance. `problem` is set for one that is not
  /// finite or not symmetric.
  void read(std::uint64_t run, std::uint64_t step, std::vector<Index>& kept, Vector& vector, Matrix& matrix,
            std::string_view& problem);

 private:
  RowReader vectors_, matrices_;
  std::optional<RowReader> less_;
  std::size_t dim_;
  std::vector<double> difference_;
};

/// "R" of the only sensor, "R_NAME" of one that has a name.
std::string of_sensor(std::string_view array, const ArrayPair& sensor);

/// The only number of an array; nothing where it has more.
std::optional<double> single_number(ArrayFile& file, std::size_t array);

/// R of a sensor, step by step: as it is at each, or the same at all, of an innovation or of one observation
/// of it; empty where the file has none.
class NoiseReader {
 public:
  /// `piece`: the components of one observation. Throws DataError for an R of other dimensions, and for one
  /// that does not change and is no covariance.
  NoiseReader(ArrayFile& file, const ArrayPair& sensor, Index piece);

  /// NaN where it is no covariance.
  const Matrix& at(std::uint64_t run, std::uint64_t step);

 private:
  bool take(const double* numbers, std::uint64_t dim);

  std::optional<RowReader> steps_;
  std::uint64_t dim_ = 0;
  Matrix noise_;
};

/// The times of the steps of a run: of each, or the same of all; empty where the file has none. Throws
/// DataError for as many as there are runs of scalars, which are then steps.
class TimeReader {
 public:
  TimeReader(ArrayFile& file, std::uint64_t runs, std::uint64_t steps, const std::string& scalars_text,
             LogSink& sink);

  const std::vector<double>& of(std::uint64_t run);

 private:
  ArrayFile& file_;
  LogSink& sink_;
  std::uint64_t steps_;
  std::optional<std::size_t> array_;
  bool each_ = false;
  std::vector<double> times_;
};

}  // namespace credence::internal
