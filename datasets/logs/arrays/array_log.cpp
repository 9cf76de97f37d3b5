#include "datasets/logs/arrays/array_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "core/append_item.h"
#include "core/control_characters.h"
#include "core/linear_algebra/symmetry.h"
#include "core/manifold/angle.h"
#include "core/utf8.h"
#include "datasets/data_error.h"
#include "datasets/logs/assumed_noise.h"
#include "datasets/logs/conventions/log_conventions.h"
#include "datasets/logs/conventions/swapped_axes.h"
#include "datasets/logs/number_field.h"
#include "montecarlo/worlds/plugged/plugged_concepts.h"

namespace credence::internal {
namespace {

constexpr std::string_view kError = "error", kEstimate = "estimate", kTruth = "truth",
                           kInnovation = "innovation", kS = "S", kObservation = "observation", kR = "R",
                           kNonlinear = "nonlinear", kInflated = "inflated", kTime = "time", kP = "P";
// A step beyond this is a mistake, and would ask for gigabytes.
constexpr std::uint64_t kMostSteps = 10'000'000, kLargestDim = 10'000;

/// Vectors and their covariances: two arrays that belong together.
struct ArrayPair {
  std::string name;  ///< of the sensor; "" for the only one
  std::size_t vectors = 0, matrices = 0;
  std::uint64_t runs = 0, steps = 0, dim = 0;
};

std::string shape_text(const ArrayShape& array) {
  if (array.dims.empty())
    return fmt::format("{} ({})", array.name, array.type == kCellArray ? kCellArray : "no array of numbers");
  return fmt::format("{} ({})", array.name, fmt::join(array.dims, ", "));
}

/// An array of NIS alone: "nis_DIM" or "nis_NAME_DIM", (runs, steps) or (steps).
struct NisArray {
  std::string name;
  std::size_t values = 0;
  std::uint64_t runs = 0, steps = 0, dim = 0;
};

/// DIM of "nis_DIM" or "nis_NAME_DIM"; nothing for another name.
std::optional<std::uint64_t> nis_dimension(std::string_view name) {
  if (!name.starts_with("nis_")) return std::nullopt;
  const std::string_view digits = name.substr(name.rfind('_') + 1);
  std::uint64_t dim = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), dim);
  if (error != std::errc() || stop != digits.data() + digits.size()) return std::nullopt;
  return dim;
}

std::optional<std::size_t> find_array(const ArrayFile& file, std::string_view name) {
  const auto found = std::ranges::find(file.arrays(), name, &ArrayShape::name);
  if (found == file.arrays().end()) return std::nullopt;
  return static_cast<std::size_t>(found - file.arrays().begin());
}

/// Finds the arrays that are to be judged.
class ArrayRoles {
 public:
  explicit ArrayRoles(const ArrayFile& file) : file_(file) {
    if (find(kError) || find(kP)) state_ = pair("", errors_are_told() ? kError : kEstimate, kP);
    if (state_) find_estimate();
    for (const ArrayShape& array : file.arrays()) {
      if (array.name == kInnovation) {
        sensors_.push_back(pair("", kInnovation, kS));
      } else if (array.name.starts_with("innovation_")) {
        const std::string sensor = array.name.substr(kInnovation.size() + 1);
        sensors_.push_back(pair(sensor, array.name, "S_" + sensor));
      } else if (const auto dim = nis_dimension(array.name)) {
        nis_.push_back(nis_of(array, *dim));
      }
    }
    require_different_names();
    if (!state_ && sensors_.empty() && nis_.empty()) {
      fail(fmt::format(
          "holds nothing to judge: error with P, or innovation with S, or nis_DIM; its arrays are {}",
          shapes()));
    }
    const auto take = [this](std::size_t array, const auto& of) {
      first_ = array;
      runs_ = of.runs;
      steps_ = of.steps;
    };
    if (!nis_.empty()) take(nis_.front().values, nis_.front());
    if (!sensors_.empty()) take(sensors_.front().vectors, sensors_.front());
    if (state_) take(state_->vectors, *state_);
    for (const ArrayPair& sensor : sensors_) check_same(sensor.vectors, sensor.runs, sensor.steps);
    for (const NisArray& sensor : nis_) check_same(sensor.values, sensor.runs, sensor.steps);
  }

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
  std::string scalars_text() const {
    const ArrayPair* const pair = state_ ? &*state_ : sensors_.empty() ? nullptr : &sensors_.front();
    if (pair == nullptr || file_.arrays()[pair->matrices].dims.size() != 2 || pair->runs == 1) return "";
    const std::uint64_t n = pair->runs, m = pair->steps;
    const std::string &vectors = file_.arrays()[pair->vectors].name,
                      &matrices = file_.arrays()[pair->matrices].name;
    const std::string read =
        fmt::format("{0} and {1} ({2}, {3}) are read as {2} runs of {3} step{4} of one number", vectors,
                    matrices, n, m, m == 1 ? "" : "s");
    if (m == 1) return fmt::format("{}; one run of {} steps is (1, {}).", read, n, n);
    return fmt::format("{}; of {} steps of {} states {} is ({}, {}, {}), with the variances on the diagonal.",
                       read, n, m, matrices, n, m, m);
  }

  /// How arrays are read that would also fit if their dimensions stood the other way round, as where there
  /// are as many steps as states; empty where there are none.
  std::string square_text() const {
    std::vector<ArrayPair> pairs = sensors_;
    if (state_) pairs.insert(pairs.begin(), *state_);
    for (const ArrayPair& pair : pairs) {
      const ArrayShape &vectors = file_.arrays()[pair.vectors], &matrices = file_.arrays()[pair.matrices];
      const bool runs = vectors.dims.size() == 3;
      if (pair.dim < 2 || pair.steps != pair.dim || (runs && pair.runs != pair.dim)) continue;
      return fmt::format(
          "{} and {} fit two readings: taken are {}{} steps of {} components, ({}steps, n) and ({}steps, n, "
          "n). Where steps stand last, {}.",
          shape_text(vectors), shape_text(matrices), runs ? fmt::format("{} runs of ", pair.runs) : "",
          pair.steps, pair.dim, runs ? "runs, " : "", runs ? "runs, " : "", turn_text(vectors, matrices));
    }
    return "";
  }

 private:
  /// Without an array of errors, one of estimates will do that has its truth.
  bool errors_are_told() const { return find(kError) || !find(kEstimate) || !find(kTruth); }

  void find_estimate() {
    estimate_ = find(kEstimate);
    if (!errors_are_told()) truth_ = find(kTruth);
    const ArrayShape& errors = file_.arrays()[state_->vectors];
    for (const auto& array : {estimate_, truth_}) {
      if (array && file_.arrays()[*array].dims != errors.dims)
        fail(fmt::format("{} and {}: other dimensions", shape_text(errors),
                         shape_text(file_.arrays()[*array])));
    }
  }

  /// Of two arrays with the innovations of one sensor nobody could tell which is meant.
  void require_different_names() const {
    std::map<std::string, std::size_t> arrays;
    const auto add = [&](const std::string& sensor, std::size_t array) {
      const auto [other, is_new] = arrays.emplace(sensor, array);
      if (is_new) return;
      fail(
          fmt::format("{} and {} are both of {}: name one of them, or give each a name of its own",
                      file_.arrays()[other->second].name, file_.arrays()[array].name,
                      sensor.empty() ? "the sensor without a name" : fmt::format("the sensor '{}'", sensor)));
    };
    for (const ArrayPair& sensor : sensors_) add(sensor.name, sensor.vectors);
    for (const NisArray& sensor : nis_) add(sensor.name, sensor.values);
  }

  std::optional<std::size_t> find(std::string_view name) const { return find_array(file_, name); }

  std::string shapes() const {
    std::string text;
    for (const ArrayShape& array : file_.arrays())
      append_item(text, array.dims.empty() ? array.name : shape_text(array));
    return text.empty() ? "none" : text;
  }

  [[noreturn]] void fail(const std::string& problem) const { throw DataError(file_.path(), "", problem); }

  ArrayPair pair(std::string name, std::string_view vectors, std::string_view matrices) const {
    const auto v = find(vectors), m = find(matrices);
    if (!v || !m) {
      const bool error = !v && vectors == kError;
      fail(fmt::format("array {} is missing beside {}{}; its arrays are {}", v ? matrices : vectors,
                       v ? vectors : matrices, error ? " (estimate less truth, or these two)" : "",
                       shapes()));
    }
    const ArrayShape& one = file_.arrays()[*v];
    const ArrayShape& other = file_.arrays()[*m];
    const std::size_t rank = one.dims.size();
    ArrayPair result{std::move(name), *v, *m};
    if (rank == 2 && other.dims == one.dims) {  // scalars
      result.runs = one.dims[0];
      result.steps = one.dims[1];
      result.dim = 1;
    } else {
      const bool fits = (rank == 2 || rank == 3) && other.dims.size() == rank + 1 &&
                        std::equal(one.dims.begin(), one.dims.end(), other.dims.begin()) &&
                        other.dims.back() == one.dims.back();
      if (!fits) {
        fail(
            fmt::format("{} and {}: accepted are (runs, steps, n) with (runs, steps, n, n), of one run "
                        "(steps, n) with (steps, n, n), and of scalars (runs, steps) with (runs, steps){}",
                        shape_text(one), shape_text(other), turned_text(one, other)));
      }
      result.runs = rank == 3 ? one.dims[0] : 1;
      result.steps = one.dims[rank - 2];
      result.dim = one.dims[rank - 1];
    }
    if (result.runs == 0 || result.steps == 0 || result.steps > kMostSteps || result.dim == 0 ||
        result.dim > kLargestDim) {
      fail(fmt::format("{}: accepted are one or more runs, 1 to {} steps and 1 to {} components",
                       shape_text(one), kMostSteps, kLargestDim));
    }
    return result;
  }

  /// How dimensions that stand the other way round, as (n, steps, runs), are brought into order.
  static std::string turned_text(const ArrayShape& vectors, const ArrayShape& matrices) {
    const std::vector<std::uint64_t>&v = vectors.dims, &m = matrices.dims;
    if (matrices.type == kCellArray) {
      return fmt::format(
          "; of a matrix for each step {0} = permute(cat(3, {0}{{:}}), [3 1 2]) makes one array",
          matrices.name);
    }
    if (v.size() == 2 && m == std::vector<std::uint64_t>{v[1], v[1], v[0]}) {
      return fmt::format(
          "; {0} seems to be (n, n, steps): turn it, in MATLAB by permute({0}, [3 1 2]), in NumPy by {0}.T",
          matrices.name);
    }
    const bool turned = (v.size() == 2 || v.size() == 3) && m.size() == v.size() + 1 && m[0] == v[0] &&
                        std::equal(v.begin(), v.end(), m.begin() + 1);
    if (!turned) return "";
    const bool runs = v.size() == 3;
    return fmt::format("; these seem to be (n, steps{}): {}", runs ? ", runs" : "",
                       turn_text(vectors, matrices));
  }

  static std::string turn_text(const ArrayShape& vectors, const ArrayShape& matrices) {
    const bool runs = vectors.dims.size() == 3;
    return fmt::format(
        "turn them, in MATLAB by permute({}, {}) and permute({}, {}), in NumPy by {}.T and {}.T",
        vectors.name, runs ? "[3 2 1]" : "[2 1]", matrices.name, runs ? "[4 3 1 2]" : "[3 1 2]", vectors.name,
        matrices.name);
  }

  NisArray nis_of(const ArrayShape& array, std::uint64_t dim) const {
    const std::size_t rank = array.dims.size();
    if (dim == 0 || dim > kLargestDim || std::ranges::count(array.dims, 0U) > 0 || (rank != 1 && rank != 2) ||
        array.dims.back() == 0 || array.dims.back() > kMostSteps) {
      fail(fmt::format(
          "{}: accepted are (runs, steps) or (steps), of at most {} steps, of innovations of 1 to {} "
          "components",
          shape_text(array), kMostSteps, kLargestDim));
    }
    constexpr std::size_t kPrefix = 4;  // "nis_"
    const std::size_t last = array.name.rfind('_');
    return {.name = last < kPrefix ? "" : array.name.substr(kPrefix, last - kPrefix),
            .values = static_cast<std::size_t>(&array - file_.arrays().data()),
            .runs = rank == 2 ? array.dims[0] : 1,
            .steps = array.dims.back(),
            .dim = dim};
  }

  void check_same(std::size_t array, std::uint64_t of_runs, std::uint64_t of_steps) const {
    if (of_runs == runs() && of_steps == steps()) return;
    fail(fmt::format("{} and {}: other runs or steps", shape_text(file_.arrays()[array]),
                     shape_text(file_.arrays()[first_])));
  }

  const ArrayFile& file_;
  std::optional<ArrayPair> state_;
  std::optional<std::size_t> estimate_, truth_;
  std::vector<ArrayPair> sensors_;
  std::vector<NisArray> nis_;
  std::size_t first_ = 0;  ///< an array to which the others must fit
  std::uint64_t runs_ = 0, steps_ = 0;
};

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
  void load(std::uint64_t run, std::uint64_t step) {
    constexpr std::uint64_t kNumbersAtOnce = std::uint64_t{1} << 17;
    run_ = run;
    first_ = step;
    count_ = std::min(steps_ - step, std::max<std::uint64_t>(1, kNumbersAtOnce / size_));
    file_.read(array_, (run * steps_ + step) * size_, count_ * size_, values_);
  }

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
  PairReader(ArrayFile& file, const ArrayPair& pair, std::optional<std::size_t> less = {})
      : vectors_(file, pair.vectors, pair.steps, pair.dim),
        matrices_(file, pair.matrices, pair.steps, pair.dim * pair.dim),
        dim_(static_cast<std::size_t>(pair.dim)) {
    if (less) less_.emplace(file, *less, pair.steps, pair.dim);
  }

  /// Writes the components that are not NaN, and their covariance. `problem` is set for one that is not
  /// finite or not symmetric.
  void read(std::uint64_t run, std::uint64_t step, std::vector<Index>& kept, Vector& vector, Matrix& matrix,
            std::string_view& problem) {
    const double* v = vectors_.row(run, step);
    if (less_) {
      const double* const other = less_->row(run, step);
      difference_.resize(dim_);
      std::transform(v, v + dim_, other, difference_.begin(), std::minus<>());
      v = difference_.data();
    }
    const double* const m = matrices_.row(run, step);
    kept.clear();
    for (std::size_t i = 0; i < dim_; ++i) {
      if (!std::isnan(v[i])) kept.push_back(static_cast<Index>(i));
    }
    const Index size = std::ssize(kept);
    vector.resize(size);
    matrix.resize(size, size);
    for (Index i = 0; i < size; ++i) {
      const auto row = static_cast<std::size_t>(kept[static_cast<std::size_t>(i)]);
      vector[i] = v[row];
      for (Index j = 0; j < size; ++j) {
        matrix(i, j) = m[row * dim_ + static_cast<std::size_t>(kept[static_cast<std::size_t>(j)])];
      }
    }
    if (!matrix.allFinite()) {
      problem = "a covariance is not finite";
    } else if (!make_symmetric(matrix, kMostAsymmetry)) {
      problem = "a covariance is not symmetric";
    }
  }

 private:
  RowReader vectors_, matrices_;
  std::optional<RowReader> less_;
  std::size_t dim_;
  std::vector<double> difference_;
};

/// "R" of the only sensor, "R_NAME" of one that has a name.
std::string of_sensor(std::string_view array, const ArrayPair& sensor) {
  return sensor.name.empty() ? std::string(array) : fmt::format("{}_{}", array, sensor.name);
}

bool is_single(const ArrayShape& array) {
  return std::ranges::all_of(array.dims, [](std::uint64_t size) { return size == 1; });
}

/// The only number of an array; nothing where it has more.
std::optional<double> single_number(ArrayFile& file, std::size_t array) {
  if (!is_single(file.arrays()[array])) return std::nullopt;
  std::vector<double> value;
  file.read(array, 0, 1, value);
  return value.front();
}

/// Whether the array of this name says 1; false where there is none.
bool flag(ArrayFile& file, std::string_view name) {
  const auto array = find_array(file, name);
  if (!array) return false;
  const std::optional<double> value = single_number(file, *array);
  if (value == 0.0 || value == 1.0) return value == 1.0;
  throw DataError(file.path(), "",
                  fmt::format("{}: accepted is one number, 1 for a filter that is, 0 for one that is not",
                              shape_text(file.arrays()[*array])));
}

/// R of a sensor, step by step: as it is at each, or the same at all, of an innovation or of one observation
/// of it; empty where the file has none.
class NoiseReader {
 public:
  NoiseReader(ArrayFile& file, const ArrayPair& sensor, Index piece) {
    const auto array = find_array(file, of_sensor(kR, sensor));
    if (!array) return;
    const ArrayShape& R = file.arrays()[*array];
    const ArrayShape& S = file.arrays()[sensor.matrices];
    const auto of_piece = static_cast<std::uint64_t>(piece);
    const auto constant = [&](std::uint64_t dim) {
      return R.dims == std::vector<std::uint64_t>{dim, dim} || (dim == 1 && is_single(R));
    };
    if (constant(sensor.dim) || constant(of_piece)) {
      const std::uint64_t dim = constant(sensor.dim) ? sensor.dim : of_piece;
      RowReader once(file, *array, 1, dim * dim);
      if (take(once.row(0, 0), dim)) return;
      throw DataError(
          file.path(), "",
          fmt::format("{}: is no covariance: not finite, not symmetric, or with a negative variance",
                      R.name));
    }
    if (R.dims != S.dims) {
      throw DataError(
          file.path(), "",
          fmt::format(
              "{}: accepted are the dimensions of {}, and ({}, {}) for an R that does not change{}",
              shape_text(R), shape_text(S), sensor.dim, sensor.dim,
              of_piece == sensor.dim ? "" : fmt::format(", of one observation ({0}, {0})", of_piece)));
    }
    steps_.emplace(file, *array, sensor.steps, sensor.dim * sensor.dim);
    dim_ = sensor.dim;
  }

  /// NaN where it is no covariance.
  const Matrix& at(std::uint64_t run, std::uint64_t step) {
    if (steps_ && !take(steps_->row(run, step), dim_)) noise_.setConstant(std::nan(""));
    return noise_;
  }

 private:
  bool take(const double* numbers, std::uint64_t dim) {
    const auto m = static_cast<Index>(dim);
    noise_ = Eigen::Map<const Matrix>(numbers, m, m);
    return (noise_.diagonal().array() >= 0.0).all() && make_symmetric(noise_, kMostAsymmetry);
  }

  std::optional<RowReader> steps_;
  std::uint64_t dim_ = 0;
  Matrix noise_;
};

/// The times of the steps of a run: of each, or the same of all; empty where the file has none. Throws
/// DataError for as many as there are runs of scalars, which are then steps.
class TimeReader {
 public:
  TimeReader(ArrayFile& file, std::uint64_t runs, std::uint64_t steps, const std::string& scalars_text,
             LogSink& sink)
      : file_(file), sink_(sink), steps_(steps), array_(find_array(file, kTime)) {
    if (!array_) return;
    const ArrayShape& time = file.arrays()[*array_];
    std::uint64_t size = 1;
    for (const std::uint64_t dim : time.dims) size *= dim;
    each_ = time.dims == std::vector<std::uint64_t>{runs, steps};
    const bool once = size == steps && std::ranges::count(time.dims, steps) > 0;
    if (each_ || once) return;
    if (!scalars_text.empty() && size == runs)
      throw DataError(file.path(), "",
                      fmt::format("{} seems to be of steps, and {}", shape_text(time), scalars_text));
    sink.remark(fmt::format("{} is not used: times in s are ({}) or ({}, {}).", shape_text(time), steps, runs,
                            steps));
    array_.reset();
  }

  const std::vector<double>& of(std::uint64_t run) {
    if (!array_ || (!each_ && !times_.empty())) return times_;
    file_.read(*array_, each_ ? run * steps_ : 0, steps_, times_);
    // Also false next to what is not a number.
    const auto goes_on = [](double now, double next) { return now < next; };
    if (std::ranges::adjacent_find(times_, std::not_fn(goes_on)) == times_.end()) return times_;
    sink_.remark(fmt::format("{} is not used: it does not increase from step to step of run {}.",
                             file_.arrays()[*array_].name, run + 1));
    array_.reset();
    times_.clear();
    return times_;
  }

 private:
  ArrayFile& file_;
  LogSink& sink_;
  std::uint64_t steps_;
  std::optional<std::size_t> array_;
  bool each_ = false;
  std::vector<double> times_;
};

/// Of how many components an observation is, of which the innovation of a sensor may hold several: the array
/// "observation" or "observation_NAME", if there is one.
Index observation_dim(ArrayFile& file, const ArrayPair& sensor) {
  const auto dim = static_cast<Index>(sensor.dim);
  const auto array = find_array(file, of_sensor(kObservation, sensor));
  if (!array) return dim;
  const std::optional<double> value = single_number(file, *array);
  for (Index piece = 1; piece <= dim; ++piece) {
    if (dim % piece == 0 && value == static_cast<double>(piece)) return piece;
  }
  throw DataError(file.path(), "",
                  fmt::format("{}: accepted is one number, the dimension of an observation, that divides the "
                              "{} components of the innovation",
                              shape_text(file.arrays()[*array]), dim));
}

void require_printable(const ArrayFile& file, const char* what, std::string_view name) {
  if (!has_control_character(name)) return;
  throw DataError(file.path(), "",
                  fmt::format("{} '{}': its name holds a control character", what, shown_field(name)));
}

/// The texts of the array of names; none where there is no such array.
std::vector<std::string> state_names(ArrayFile& file, std::uint64_t states) {
  std::vector<std::string> names;
  const auto array = find_array(file, kNamesOfStates);
  if (!array || file.arrays()[*array].dims.empty()) return names;
  const ArrayShape& shape = file.arrays()[*array];
  if (shape.dims.size() != 2 || shape.dims[0] != states) {
    const std::uint64_t given = shape.dims.size() == 2 ? shape.dims[0] : 0;
    throw DataError(
        file.path(), "",
        fmt::format("{}: {} names for {} states; accepted is one for each", shape.name, given, states));
  }
  std::vector<double> letters;
  file.read(*array, 0, shape.dims[0] * shape.dims[1], letters);
  for (auto at = letters.begin(); at != letters.end(); at += static_cast<std::ptrdiff_t>(shape.dims[1])) {
    std::string name;
    for (auto letter = at; letter != at + static_cast<std::ptrdiff_t>(shape.dims[1]) && *letter > 0.0;
         ++letter)
      append_utf8(name, static_cast<char32_t>(*letter));
    require_printable(file, "state", name);
    names.push_back(std::move(name));
  }
  return names;
}

RunLayout layout_of(ArrayFile& file, const ArrayRoles& roles) {
  constexpr std::uint64_t kMostBlocks = 30;
  RunLayout layout;
  layout.has_truth = roles.state().has_value();
  layout.nonlinear = flag(file, kNonlinear);
  layout.inflated = flag(file, kInflated);
  const std::uint64_t n = roles.state() ? roles.state()->dim : 0;
  if (const std::vector<std::string> names = state_names(file, n); !names.empty()) {
    try {
      RunLayout named = model_layout(names, {});
      layout.states = std::move(named.states);
      layout.angles = std::move(named.angles);
      layout.blocks = std::move(named.blocks);
      layout.landmark_dim = named.landmark_dim;
    } catch (const std::invalid_argument& error) {
      throw DataError(file.path(), "", fmt::format("{}: {}", kNamesOfStates, error.what()));
    }
  } else {
    for (std::uint64_t i = 0; i < n; ++i) layout.states.push_back(fmt::format("x{}", i + 1));
    layout.angles.assign(layout.states.size(), false);
    if (n <= kMostBlocks) add_named_blocks(layout);
  }
  for (const ArrayPair& sensor : roles.sensors()) {
    require_printable(file, "sensor", sensor.name);
    const auto dim = static_cast<Index>(sensor.dim);
    layout.sensors.push_back({.name = sensor.name, .dim = dim, .piece = observation_dim(file, sensor)});
  }
  for (const NisArray& sensor : roles.nis()) {
    require_printable(file, "sensor", sensor.name);
    const auto dim = static_cast<Index>(sensor.dim);
    layout.sensors.push_back({.name = sensor.name, .dim = dim, .piece = dim, .nis_alone = true});
  }
  return layout;
}

/// Names the arrays that nobody reads, of which one may be misspelt.
void tell_unread(const ArrayFile& file, const ArrayRoles& roles, const RunLayout& layout, LogSink& sink) {
  constexpr std::size_t kMost = 8;
  const auto lacks_its_sensor = [&layout](std::string_view name) {
    constexpr std::string_view kPrefixes[] = {"S_", "R_", "observation_"};
    return std::ranges::any_of(kPrefixes, [&](std::string_view prefix) {
      return name.starts_with(prefix) && std::ranges::find(layout.sensors, name.substr(prefix.size()),
                                                           &Sensor::name) == layout.sensors.end();
    });
  };
  std::vector<std::string> unread;
  for (const ArrayShape& array : file.arrays()) {
    const bool used = array.name == kTruth ? roles.truth().has_value()
                                           : is_log_array(array.name) && !lacks_its_sensor(array.name);
    if (array.name == kNamesOfStates || used) continue;
    unread.push_back(shown_field(array.name));
  }
  if (!unread.empty()) sink.remark(fmt::format("Not read: {}.", first_items(unread, kMost)));
}

}  // namespace

std::uint64_t column_major_place(const std::vector<std::uint64_t>& dims, std::uint64_t k) {
  std::uint64_t place = 0, stride = 1;
  for (const std::uint64_t dim : dims) stride *= dim;
  for (std::size_t d = dims.size(); d-- > 0;) {
    stride /= dims[d];
    place += k % dims[d] * stride;
    k /= dims[d];
  }
  return place;
}

bool is_log_array(std::string_view name) {
  return name == kError || name == kEstimate || name == kTruth || name == kP || name == kInnovation ||
         name == kS || name.starts_with("innovation_") || name.starts_with("S_") || name == kObservation ||
         name.starts_with("observation_") || name == kR || name.starts_with("R_") || name == kNonlinear ||
         name == kInflated || name == kTime || nis_dimension(name).has_value();
}

namespace {

void add_estimate(const double* estimate, Step& step) {
  step.estimate.resize(step.error.size());
  for (Index i = 0; i < step.error.size(); ++i) {
    step.estimate[i] = estimate[static_cast<std::size_t>(step.states[static_cast<std::size_t>(i)])];
  }
}

/// As those of every other format.
void wrap_errors(const RunLayout& layout, Step& step) {
  for (Index i = 0; i < step.error.size(); ++i) {
    const auto state = static_cast<std::size_t>(step.states[static_cast<std::size_t>(i)]);
    if (layout.angles[state]) step.error[i] = wrap_angle(step.error[i]);
  }
}

}  // namespace

void read_arrays(ArrayFile& file, LogSink& judged) {
  LogConventions conventions(judged);
  LogSink& sink = conventions.sink();
  const ArrayRoles roles(file);
  const RunLayout layout = layout_of(file, roles);
  std::vector<PairReader> sensors;
  std::vector<NoiseReader> noise;
  for (const ArrayPair& sensor : roles.sensors()) {
    const Index piece = layout.sensors[sensors.size()].piece;
    sensors.emplace_back(file, sensor);
    noise.emplace_back(file, sensor, piece);
  }
  std::optional<PairReader> state;
  if (roles.state()) state.emplace(file, *roles.state(), roles.truth());
  std::optional<RowReader> estimate;
  if (roles.estimate()) estimate.emplace(file, *roles.estimate(), roles.steps(), roles.state()->dim);
  const std::string scalars = roles.scalars_text();
  TimeReader times(file, roles.runs(), roles.steps(), scalars, sink);
  if (!scalars.empty()) sink.remark(scalars);
  if (std::string square = roles.square_text(); !square.empty()) sink.remark(std::move(square));
  tell_unread(file, roles, layout, sink);
  SwappedAxes axes;
  Step step;
  std::vector<Index> measured;
  std::vector<std::vector<double>> nis(roles.nis().size());
  for (std::uint64_t run = 0; run < roles.runs(); ++run) {
    if (roles.runs() > 1) sink.run_number(static_cast<double>(run));
    sink.begin_run(layout);
    axes.begin_run();
    const std::vector<double>& time_s = times.of(run);
    for (std::size_t i = 0; i < nis.size(); ++i)
      file.read(roles.nis()[i].values, run * roles.steps(), roles.steps(), nis[i]);
    for (std::uint64_t k = 0; k < roles.steps(); ++k) {
      step.step = static_cast<std::int64_t>(k) + 1;
      step.line = static_cast<std::int64_t>(run * roles.steps() + k) + 1;
      step.problem = {};
      if (state) {
        state->read(run, k, step.states, step.error, step.P, step.problem);
        wrap_errors(layout, step);
        axes.add(step);
      }
      if (estimate) add_estimate(estimate->row(run, k), step);
      step.innovations.resize(layout.sensors.size());
      for (std::size_t i = 0; i < sensors.size(); ++i) {
        Innovation& innovation = step.innovations[i];
        sensors[i].read(run, k, measured, innovation.nu, innovation.S, step.problem);
        innovation.complete = are_complete(measured, layout.sensors[i].piece);
        if (!measured.empty()) {
          take_assumed_noise(noise[i].at(run, k), layout.sensors[i].piece, measured, innovation.R);
        }
      }
      for (std::size_t i = 0; i < nis.size(); ++i) {
        const double value = nis[i][k];
        step.innovations[sensors.size() + i] = value >= 0.0 ? nis_alone(value) : Innovation{};
        if (value < 0.0) step.problem = "a NIS is negative";
      }
      if (!time_s.empty()) sink.at(time_s[k]);
      sink.add(step);
    }
  }
  if (std::string swapped = axes.says(); !swapped.empty()) sink.swapped_axes(std::move(swapped));
  conventions.finish();
}

LogContents list_arrays(const ArrayFile& file) {
  LogContents contents;
  for (const ArrayShape& array : file.arrays()) {
    std::int64_t count =
        array.dims.empty() ? 0 : 1;  // rows: all dimensions but the last, of P and S the last two
    const bool matrices = array.name == kP || array.name == kS || array.name.starts_with("S_") ||
                          array.name == kR || array.name.starts_with("R_");
    const bool vectors = array.name == kError || array.name == kEstimate || array.name == kTruth ||
                         array.name.starts_with(kInnovation);
    const std::size_t of_row = matrices ? 2U : nis_dimension(array.name) || array.name == kTime ? 0U : 1U;
    const std::size_t inner = std::min(array.dims.size(), of_row);
    for (std::size_t i = 0; i + inner < array.dims.size(); ++i)
      count *= static_cast<std::int64_t>(array.dims[i]);
    contents.topics.push_back({.name = array.name,
                               .type = array.dims.empty()
                                           ? array.type
                                           : fmt::format("{} ({})", array.type, fmt::join(array.dims, ", ")),
                               .count = count,
                               .use = array.name == kError        ? "error"
                                      : array.name == kEstimate   ? "estimate"
                                      : array.name == kTruth      ? "truth"
                                      : array.name == kTime       ? "time"
                                      : nis_dimension(array.name) ? "NIS alone"
                                      : vectors                   ? "innovations"
                                      : matrices                  ? "covariance"
                                                                  : "",
                               .covariance = matrices});
  }
  return contents;
}

}  // namespace credence::internal
