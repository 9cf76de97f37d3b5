#include "montecarlo/random/noise_shape.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "montecarlo/random/noise.h"

namespace credence::internal {
namespace {

constexpr int kLeastStudentDof = 3;  // of finite variance
constexpr double kLargestCorrelation = 0.9999;
constexpr double kNoCorrelation = 0x1p-60;  // nothing of it is left beside 1

/// The Gauss-Markov sequence over some steps, by bisection of intervals that are powers of two long.
class MarkovSequence {
 public:
  MarkovSequence(const NoiseSource& plain, double correlation, std::int64_t run, NoisePurpose purpose,
                 std::int64_t first_slot, std::int64_t slots)
      : plain_(plain), run_(run), purpose_(purpose), first_slot_(first_slot), slots_(slots) {
    double r = correlation;
    while (r > kNoCorrelation) {
      correlation_.push_back(r);
      r *= r;
    }
  }

  /// The steps first, first + 1, … into `out`.
  void draw(std::int64_t first, std::span<double> out) {
    first_ = first;
    last_ = first + std::ssize(out) / slots_ - 1;
    out_ = out;
    const std::int64_t length = std::int64_t{1} << correlation_.size();
    for (std::int64_t a = first / length * length; a <= last_; a += length) {
      const std::vector<double> left = own(a);
      keep(a, left);
      if (last_ > a) bisect(a, correlation_.size(), left, own(a + length));
    }
  }

 private:
  /// What is drawn for this step alone.
  std::vector<double> own(std::int64_t step) const {
    std::vector<double> values(static_cast<std::size_t>(slots_));
    plain_.normals(run_, step, purpose_, values, first_slot_);
    return values;
  }

  void keep(std::int64_t step, const std::vector<double>& values) {
    if (step < first_ || step > last_) return;
    std::ranges::copy(values, out_.begin() + (step - first_) * slots_);
  }

  /// Between `a` and a + 2^level. With ρ over half of it, the middle given both ends has the mean
  /// ρ (left + right)/(1 + ρ²) and the variance (1 − ρ²)/(1 + ρ²).
  void bisect(std::int64_t a, std::size_t level, const std::vector<double>& left,
              const std::vector<double>& right) {
    if (level == 0) return;
    const std::int64_t half = std::int64_t{1} << (level - 1), middle = a + half;
    const double rho = correlation_[level - 1], whole = 1.0 + rho * rho;
    const double weight = rho / whole, std = std::sqrt((1.0 - rho * rho) / whole);
    std::vector<double> values = own(middle);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = weight * (left[i] + right[i]) + std * values[i];
    keep(middle, values);
    if (first_ < middle) bisect(a, level - 1, left, values);
    if (last_ > middle) bisect(middle, level - 1, values, right);
  }

  const NoiseSource& plain_;
  std::int64_t run_;
  NoisePurpose purpose_;
  std::int64_t first_slot_, slots_;
  std::vector<double> correlation_;  ///< over 1, 2, 4, … steps
  std::int64_t first_ = 0, last_ = 0;
  std::span<double> out_;
};

}  // namespace

void check_noise_shape(const NoiseShape& shape) {
  const auto require = [](bool ok, const char* rule, double value) {
    if (!ok) throw std::invalid_argument(std::string("noise: ") + rule + ", not " + std::to_string(value));
  };
  require(shape.correlation >= 0.0 && shape.correlation <= kLargestCorrelation,
          "the correlation must be a number >= 0 and <= 0.9999", shape.correlation);
  require(shape.student_dof == 0 || shape.student_dof >= kLeastStudentDof,
          "the degrees of freedom of Student's t must be 0 (Gaussian) or at least 3", shape.student_dof);
  require(shape.outlier_rate >= 0.0 && shape.outlier_rate <= 1.0,
          "the rate of outliers must be a number >= 0 and <= 1", shape.outlier_rate);
  require(std::isfinite(shape.outlier_scale) && shape.outlier_scale >= 0.0,
          "the scale of outliers must be a finite number >= 0", shape.outlier_scale);
}

void shaped_normals(const NoiseSource& plain, const NoiseShape& shape, std::int64_t run,
                    std::int64_t first_step, NoisePurpose purpose, std::int64_t first_slot,
                    std::int64_t slots, std::span<double> out) {
  const std::int64_t steps = slots == 0 ? 0 : std::ssize(out) / slots;
  if (steps == 0) return;
  if (shape.correlation > 0.0) {
    MarkovSequence(plain, shape.correlation, run, purpose, first_slot, slots).draw(first_step, out);
  } else {
    for (std::int64_t k = 0; k < steps; ++k) {
      const auto at = static_cast<std::size_t>(k * slots), count = static_cast<std::size_t>(slots);
      plain.normals(run, first_step + k, purpose, out.subspan(at, count), first_slot);
    }
  }
  // What process and measurement need of purpose `tail` lies apart.
  const std::int64_t dof = shape.student_dof, outlier = purpose == NoisePurpose::process ? 1 : 0;
  const std::int64_t squares = outlier == 1 ? std::int64_t{1} << 23 : 0;
  std::vector<double> normals(static_cast<std::size_t>(dof));
  for (std::int64_t k = 0; k < steps; ++k) {
    for (std::int64_t slot = 0; slot < slots; ++slot) {
      double& value = out[static_cast<std::size_t>(k * slots + slot)];
      const std::int64_t step = first_step + k, named = first_slot + slot;
      if (dof > 0) {
        plain.normals(run, step, NoisePurpose::tail, normals, squares + named * dof);
        double chi_square = 0.0;
        for (const double x : normals) chi_square += x * x;
        value *= std::sqrt((static_cast<double>(dof) - 2.0) / chi_square);
      }
      if (shape.outlier_rate > 0.0 &&
          plain.uniform(run, step, NoisePurpose::tail, 2 * named + outlier) < shape.outlier_rate) {
        value *= shape.outlier_scale;
      }
    }
  }
}

}  // namespace credence::internal
