#include "datasets/logs/arrays/array_roles.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <system_error>
#include <utility>

#include "core/append_item.h"
#include "datasets/data_error.h"

namespace credence::internal {

using namespace array_names;

namespace {

// A step beyond this is a mistake, and would ask for gigabytes.
constexpr std::uint64_t kMostArraySteps = 10'000'000, kLargestDim = 10'000;

}  // namespace

std::string shape_text(const ArrayShape& array) {
  if (array.dims.empty())
    return fmt::format("{} ({})", array.name, array.type == kCellArray ? kCellArray : "no array of numbers");
  return fmt::format("{} ({})", array.name, fmt::join(array.dims, ", "));
}

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

ArrayRoles::ArrayRoles(const ArrayFile& file) : file_(file) {
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

std::string ArrayRoles::scalars_text() const {
  const ArrayPair* const pair = state_ ? &*state_ : sensors_.empty() ? nullptr : &sensors_.front();
  if (pair == nullptr || file_.arrays()[pair->matrices].dims.size() != 2 || pair->runs == 1) return "";
  const std::uint64_t n = pair->runs, m = pair->steps;
  const std::string &vectors = file_.arrays()[pair->vectors].name,
                    &matrices = file_.arrays()[pair->matrices].name;
  const std::string read = fmt::format("{0} and {1} ({2}, {3}) are read as {2} runs of {4} of one number",
                                       vectors, matrices, n, m, counted(m, "step"));
  if (m == 1) return fmt::format("{}; one run of {} steps is (1, {}).", read, n, n);
  return fmt::format("{}; of {} steps of {} states {} is ({}, {}, {}), with the variances on the diagonal.",
                     read, n, m, matrices, n, m, m);
}

std::string ArrayRoles::square_text() const {
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

bool ArrayRoles::errors_are_told() const { return find(kError) || !find(kEstimate) || !find(kTruth); }

void ArrayRoles::find_estimate() {
  estimate_ = find(kEstimate);
  if (!errors_are_told()) truth_ = find(kTruth);
  const ArrayShape& errors = file_.arrays()[state_->vectors];
  for (const auto& array : {estimate_, truth_}) {
    if (array && file_.arrays()[*array].dims != errors.dims)
      fail(
          fmt::format("{} and {}: other dimensions", shape_text(errors), shape_text(file_.arrays()[*array])));
  }
}

void ArrayRoles::require_different_names() const {
  std::map<std::string, std::size_t> arrays;
  const auto add = [&](const std::string& sensor, std::size_t array) {
    const auto [other, is_new] = arrays.emplace(sensor, array);
    if (is_new) return;
    fail(fmt::format("{} and {} are both of {}: name one of them, or give each a name of its own",
                     file_.arrays()[other->second].name, file_.arrays()[array].name,
                     sensor.empty() ? "the sensor without a name" : fmt::format("the sensor '{}'", sensor)));
  };
  for (const ArrayPair& sensor : sensors_) add(sensor.name, sensor.vectors);
  for (const NisArray& sensor : nis_) add(sensor.name, sensor.values);
}

std::optional<std::size_t> ArrayRoles::find(std::string_view name) const { return find_array(file_, name); }

std::string ArrayRoles::shapes() const {
  std::string text;
  for (const ArrayShape& array : file_.arrays())
    append_item(text, array.dims.empty() ? array.name : shape_text(array));
  return text.empty() ? "none" : text;
}

void ArrayRoles::fail(const std::string& problem) const { throw DataError(file_.path(), "", problem); }

ArrayPair ArrayRoles::pair(std::string name, std::string_view vectors, std::string_view matrices) const {
  const auto v = find(vectors), m = find(matrices);
  if (!v || !m) {
    const bool error = !v && vectors == kError;
    fail(fmt::format("array {} is missing beside {}{}; its arrays are {}", v ? matrices : vectors,
                     v ? vectors : matrices, error ? " (estimate less truth, or these two)" : "", shapes()));
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
  if (result.runs == 0 || result.steps == 0 || result.steps > kMostArraySteps || result.dim == 0 ||
      result.dim > kLargestDim) {
    fail(fmt::format("{}: accepted are one or more runs, 1 to {} steps and 1 to {} components",
                     shape_text(one), kMostArraySteps, kLargestDim));
  }
  return result;
}

std::string ArrayRoles::turned_text(const ArrayShape& vectors, const ArrayShape& matrices) {
  const std::vector<std::uint64_t>&v = vectors.dims, &m = matrices.dims;
  if (matrices.type == kCellArray) {
    return fmt::format("; of a matrix for each step {0} = permute(cat(3, {0}{{:}}), [3 1 2]) makes one array",
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

std::string ArrayRoles::turn_text(const ArrayShape& vectors, const ArrayShape& matrices) {
  const bool runs = vectors.dims.size() == 3;
  return fmt::format("turn them, in MATLAB by permute({}, {}) and permute({}, {}), in NumPy by {}.T and {}.T",
                     vectors.name, runs ? "[3 2 1]" : "[2 1]", matrices.name, runs ? "[4 3 1 2]" : "[3 1 2]",
                     vectors.name, matrices.name);
}

NisArray ArrayRoles::nis_of(const ArrayShape& array, std::uint64_t dim) const {
  const std::size_t rank = array.dims.size();
  if (dim == 0 || dim > kLargestDim || std::ranges::count(array.dims, 0U) > 0 || (rank != 1 && rank != 2) ||
      array.dims.back() == 0 || array.dims.back() > kMostArraySteps) {
    fail(fmt::format(
        "{}: accepted are (runs, steps) or (steps), of at most {} steps, of innovations of 1 to {} "
        "components",
        shape_text(array), kMostArraySteps, kLargestDim));
  }
  constexpr std::size_t kPrefix = 4;  // "nis_"
  const std::size_t last = array.name.rfind('_');
  return {.name = last < kPrefix ? "" : array.name.substr(kPrefix, last - kPrefix),
          .values = static_cast<std::size_t>(&array - file_.arrays().data()),
          .runs = rank == 2 ? array.dims[0] : 1,
          .steps = array.dims.back(),
          .dim = dim};
}

void ArrayRoles::check_same(std::size_t array, std::uint64_t of_runs, std::uint64_t of_steps) const {
  if (of_runs == runs() && of_steps == steps()) return;
  fail(fmt::format("{} and {}: other runs or steps", shape_text(file_.arrays()[array]),
                   shape_text(file_.arrays()[first_])));
}

}  // namespace credence::internal
