#include "datasets/logs/arrays/array_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "core/linear_algebra/symmetry.h"
#include "datasets/data_error.h"

namespace credence::internal {

using namespace array_names;

namespace {

bool is_single(const ArrayShape& array) {
  return std::ranges::all_of(array.dims, [](std::uint64_t size) { return size == 1; });
}

}  // namespace

void RowReader::load(std::uint64_t run, std::uint64_t step) {
  constexpr std::uint64_t kNumbersAtOnce = std::uint64_t{1} << 17;
  run_ = run;
  first_ = step;
  count_ = std::min(steps_ - step, std::max<std::uint64_t>(1, kNumbersAtOnce / size_));
  file_.read(array_, (run * steps_ + step) * size_, count_ * size_, values_);
}

PairReader::PairReader(ArrayFile& file, const ArrayPair& pair, std::optional<std::size_t> less)
    : vectors_(file, pair.vectors, pair.steps, pair.dim),
      matrices_(file, pair.matrices, pair.steps, pair.dim * pair.dim),
      dim_(static_cast<std::size_t>(pair.dim)) {
  if (less) less_.emplace(file, *less, pair.steps, pair.dim);
}

void PairReader::read(std::uint64_t run, std::uint64_t step, std::vector<Index>& kept, Vector& vector,
                      Matrix& matrix, std::string_view& problem) {
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
  } else if (!make_symmetric(matrix)) {
    problem = "a covariance is not symmetric";
  }
}

std::string of_sensor(std::string_view array, const ArrayPair& sensor) {
  return sensor.name.empty() ? std::string(array) : fmt::format("{}_{}", array, sensor.name);
}

std::optional<double> single_number(ArrayFile& file, std::size_t array) {
  if (!is_single(file.arrays()[array])) return std::nullopt;
  std::vector<double> value;
  file.read(array, 0, 1, value);
  return value.front();
}

NoiseReader::NoiseReader(ArrayFile& file, const ArrayPair& sensor, Index piece) {
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
        fmt::format("{}: is no covariance: not finite, not symmetric, or with a negative variance", R.name));
  }
  if (R.dims != S.dims) {
    throw DataError(
        file.path(), "",
        fmt::format("{}: accepted are the dimensions of {}, and ({}, {}) for an R that does not change{}",
                    shape_text(R), shape_text(S), sensor.dim, sensor.dim,
                    of_piece == sensor.dim ? "" : fmt::format(", of one observation ({0}, {0})", of_piece)));
  }
  steps_.emplace(file, *array, sensor.steps, sensor.dim * sensor.dim);
  dim_ = sensor.dim;
}

const Matrix& NoiseReader::at(std::uint64_t run, std::uint64_t step) {
  if (steps_ && !take(steps_->row(run, step), dim_)) noise_.setConstant(std::nan(""));
  return noise_;
}

bool NoiseReader::take(const double* numbers, std::uint64_t dim) {
  const auto m = static_cast<Index>(dim);
  noise_ = Eigen::Map<const Matrix>(numbers, m, m);
  return (noise_.diagonal().array() >= 0.0).all() && make_symmetric(noise_);
}

TimeReader::TimeReader(ArrayFile& file, std::uint64_t runs, std::uint64_t steps,
                       const std::string& scalars_text, LogSink& sink)
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
  sink.remark(
      fmt::format("{} is not used: times in s are ({}) or ({}, {}).", shape_text(time), steps, runs, steps));
  array_.reset();
}

const std::vector<double>& TimeReader::of(std::uint64_t run) {
  if (!array_ || (!each_ && !times_.empty())) return times_;
  file_.read(*array_, each_ ? run * steps_ : 0, steps_, times_);
  // Also false next to what is not a number.
  const auto goes_on = [](double now, double next) { return now < next; };
  if (std::ranges::adjacent_find(times_, std::not_fn(goes_on)) == times_.end()) return times_;
  sink_.remark(fmt::format("{} is not used: it does not increase from step to step{}.",
                           file_.arrays()[*array_].name, each_ ? fmt::format(" of run {}", run) : ""));
  array_.reset();
  times_.clear();
  return times_;
}

}  // namespace credence::internal
