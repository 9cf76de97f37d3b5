#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/record/step.h"
#include "datasets/arrays/array_runs.h"

namespace credence::internal {

/// Reads rows of arrays as the steps of a filter. Angles of the layout are wrapped, P and S are taken from
/// their upper triangles.
class ArrayReader {
 public:
  explicit ArrayReader(const ArrayRuns& arrays) : arrays_(arrays) {}

  /// Row `row` of run `run`; `step` keeps its memory from call to call. Throws std::invalid_argument naming
  /// array and index for an infinite number, for an estimate or a covariance that is not finite where it is
  /// needed, and for a covariance that is not symmetric.
  void read(std::int64_t run, std::int64_t row, Step& step);

 private:
  struct Place {
    std::string_view array, sensor;
    std::int64_t run = 0, row = 0;
  };

  void read_state(const ArrayRun& run, Place place, Step& step);
  void read_innovation(std::size_t sensor, const InnovationRows& rows, Place place, Innovation& out);
  void keep_finite(const double* values, Index size, const Place& place);
  void read_covariance(const double* entries, Index size, const Place& place, Matrix& out) const;
  [[noreturn]] void fail(const Place& place, std::string_view inner, const std::string& problem) const;

  const ArrayRuns& arrays_;
  std::vector<Index> kept_;  ///< the components of the row at hand that are there
};

}  // namespace credence::internal
