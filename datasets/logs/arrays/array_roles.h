#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/logs/arrays/array_log.h"

namespace credence::internal {

namespace array_names {

/// The names of arrays (array_log.h); "_NAME" of a sensor may follow that of its innovations, S, R and
/// observation.
inline constexpr std::string_view kError = "error", kEstimate = "estimate", kTruth = "truth",
                                  kInnovation = "innovation", kS = "S", kObservation = "observation",
                                  kR = "R", kNonlinear = "nonlinear", kInflated = "inflated", kTime = "time",
                                  kP = "P";

}  // namespace array_names

/// Vectors and their covariances: two arrays that belong together.
struct ArrayPair {
  std::string name;  ///< of the sensor; "" for the only one
  std::size_t vectors = 0, matrices = 0;
  std::uint64_t runs = 0, steps = 0, dim = 0;
};

/// An array of NIS alone: "nis_DIM" or "nis_NAME_DIM", (runs, steps) or (steps).
struct NisArray {
  std::string name;
  std::size_t values = 0;
  std::uint64_t runs = 0, steps = 0, dim = 0;
};

/// "error (8, 100, 2)": an array and its dimensions, or that it holds no numbers.
std::string shape_text(const ArrayShape& array);

/// DIM of "nis_DIM" or "nis_NAME_DIM"; nothing for another name.
std::optional<std::uint64_t> nis_dimension(std::string_view name);

/// Which array of a file has this name; nothing where none has.
std::optional<std::size_t> find_array(const ArrayFile& file, std::string_view name);

/// Finds the arrays that are to be judged.
class ArrayRoles {
 public:
  /// Refers to the file. Throws DataError where there is nothing to judge, an array is missing beside
  /// another, two are of one sensor, or dimensions are not accepted or do not agree.
  explicit ArrayRoles(const ArrayFile& file);

  /// The error, or the estimate less truth(), with P.
  const std::optional<ArrayPair>& state() const { return state_; }
  /// x̂ and x of the same dimensions as state(); nothing where there are none, or x is not needed.
  std::optional<std::size_t> estimate() const { return estimate_; }
  std::optional<std::size_t> truth() const { return truth_; }
  const std::vector<ArrayPair>& sensors() const { return sensors_; }
  const std::vector<NisArray>& nis() const { return nis_; }
  std::uint64_t runs() const { return runs_; }
  std::uint64_t steps() const { return steps_; }

  /// How two arrays of the same two dimensions are read, which could be meant otherwise; empty where there
  /// are none.
  std::string scalars_text() const;
  /// How arrays are read that would also fit if their dimensions stood the other way round, as where there
  /// are as many steps as states; empty where there are none.
  std::string square_text() const;

 private:
  /// Without an array of errors, one of estimates will do that has its truth.
  bool errors_are_told() const;
  void find_estimate();
  /// Of two arrays with the innovations of one sensor nobody could tell which is meant.
  void require_different_names() const;
  std::optional<std::size_t> find(std::string_view name) const;
  std::string shapes() const;
  [[noreturn]] void fail(const std::string& problem) const;
  ArrayPair pair(std::string name, std::string_view vectors, std::string_view matrices) const;
  /// How dimensions that stand the other way round, as (n, steps, runs), are brought into order.
  static std::string turned_text(const ArrayShape& vectors, const ArrayShape& matrices);
  static std::string turn_text(const ArrayShape& vectors, const ArrayShape& matrices);
  NisArray nis_of(const ArrayShape& array, std::uint64_t dim) const;
  void check_same(std::size_t array, std::uint64_t of_runs, std::uint64_t of_steps) const;

  const ArrayFile& file_;
  std::optional<ArrayPair> state_;
  std::optional<std::size_t> estimate_, truth_;
  std::vector<ArrayPair> sensors_;
  std::vector<NisArray> nis_;
  std::size_t first_ = 0;  ///< an array to which the others must fit
  std::uint64_t runs_ = 0, steps_ = 0;
};

}  // namespace credence::internal
