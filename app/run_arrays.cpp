#include "app/run_arrays.h"

#include <algorithm>
#include <vector>

#include "core/nan.h"
#include "core/record/state_name.h"
#include "datasets/logs/arrays/array_log.h"
#include "datasets/logs/arrays/npz_writer.h"
#include "datasets/logs/assumed_noise.h"

namespace credence::internal {
namespace {

/// Vectors and their covariances, padded with NaN to one dimension.
class ArrayPairWriter {
 public:
  ArrayPairWriter(const char* vectors, const char* matrices, std::size_t steps, Index dim) : dim_(dim) {
    const auto n = static_cast<std::uint64_t>(dim);
    vectors_ = {vectors, {1, steps, n}, std::vector<double>(steps * n, kNaN)};
    matrices_ = {matrices, {1, steps, n, n}, std::vector<double>(steps * n * n, kNaN)};
  }

  /// places: where the components stand among all.
  void set(std::size_t step, const std::vector<Index>& places, const Vector& vector, const Matrix& matrix) {
    const auto n = static_cast<std::size_t>(dim_);
    for (Index i = 0; i < vector.size(); ++i) {
      const auto row = step * n + static_cast<std::size_t>(places[static_cast<std::size_t>(i)]);
      vectors_.values[row] = vector[i];
      for (Index j = 0; j < vector.size(); ++j) {
        matrices_.values[row * n + static_cast<std::size_t>(places[static_cast<std::size_t>(j)])] =
            matrix(i, j);
      }
    }
  }

  void take(std::vector<NamedArray>& arrays) {
    if (dim_ == 0) return;
    arrays.push_back(std::move(vectors_));
    arrays.push_back(std::move(matrices_));
  }

 private:
  Index dim_;
  NamedArray vectors_, matrices_;
};

std::vector<Index> first_places(Index n) {
  std::vector<Index> all;
  for (Index i = 0; i < n; ++i) all.push_back(i);
  return all;
}

}  // namespace

std::string run_arrays(const RunLayout& layout, std::span<const Step> steps, double step_s) {
  Index measured = 0;
  for (const Step& step : steps) {
    for (const Innovation& innovation : step.innovations) measured = std::max(measured, innovation.nu.size());
  }
  ArrayPairWriter state("error", "P", steps.size(), std::ssize(layout.states));
  ArrayPairWriter innovations("innovation", "S", steps.size(), measured);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    state.set(k, steps[k].states, steps[k].error, steps[k].P);
    for (const Innovation& innovation : steps[k].innovations) {
      innovations.set(k, first_places(innovation.nu.size()), innovation.nu, innovation.S);
    }
  }
  std::vector<NamedArray> arrays;
  if (step_s > 0.0) {
    arrays.push_back({"time", {steps.size()}, {}});
    for (const Step& step : steps) arrays.back().values.push_back(step_s * static_cast<double>(step.step));
  }
  state.take(arrays);
  arrays.push_back({std::string(kNamesOfStates), {layout.states.size()}, {}, marked_states(layout)});
  innovations.take(arrays);
  const Index piece = layout.sensors.empty() ? 0 : layout.sensors.front().piece;
  if (measured > piece && piece > 0) arrays.push_back({"observation", {1}, {static_cast<double>(piece)}});
  const Matrix R = measured > 0 ? assumed_noise(layout.sensors.front(), measured) : Matrix();
  if (R.size() > 0) {
    const auto m = static_cast<std::uint64_t>(R.rows());
    arrays.push_back({"R", {m, m}, {R.data(), R.data() + R.size()}});
  }
  if (layout.nonlinear) arrays.push_back({"nonlinear", {1}, {1.0}});
  if (layout.inflated) arrays.push_back({"inflated", {1}, {1.0}});
  return npz_bytes(arrays);
}

}  // namespace credence::internal
