#include "montecarlo/linear_kernel.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "montecarlo/linear_kernel_storage.h"
#include "montecarlo/normal_kernel.h"

namespace credence {
namespace {

static_assert(kInitialPurpose == static_cast<std::uint32_t>(NoisePurpose::initial) << 24);
static_assert(kProcessPurpose == static_cast<std::uint32_t>(NoisePurpose::process) << 24);
static_assert(kMeasurementPurpose == static_cast<std::uint32_t>(NoisePurpose::measurement) << 24);

void require(bool ok, const char* what, Index value) {
  if (!ok) throw std::invalid_argument(std::string("simulate_linear: ") + what + std::to_string(value));
}

/// 64-byte aligned doubles.
class AlignedBuffer {
 public:
  explicit AlignedBuffer(std::size_t size) : storage_(size + 8, 0.0) {
    void* p = storage_.data();
    std::size_t space = storage_.size() * sizeof(double);
    data_ = static_cast<double*>(std::align(64, size * sizeof(double), p, space));
  }
  double* data() { return data_; }

 private:
  std::vector<double> storage_;
  double* data_;
};

/// Half of a common L1 cache, for the noise of a block of steps and for the states of a batch each.
constexpr std::int64_t kBudget = 2048;

std::int64_t runs_of_batch(const LinearPlan& plan) {
  const std::int64_t tiles = kBudget / std::max<std::int64_t>(1, std::int64_t{plan.states} * kNoiseLanes);
  return std::clamp<std::int64_t>(tiles, 1, 32) * kNoiseLanes;
}

std::int64_t groups_of_block(const LinearPlan& plan) {
  const std::int64_t slots = std::int64_t{plan.process_noises} + plan.measurements;
  return std::clamp<std::int64_t>(kBudget / std::max<std::int64_t>(1, slots * 4 * kNoiseLanes), 1, 8);
}

const LinearKernel& linear_kernel(InstructionSet set) {
  const LinearKernel* kernel = set == InstructionSet::avx512 ? linear_kernel_avx512()
                               : set == InstructionSet::avx2 ? linear_kernel_avx2()
                                                             : linear_kernel_scalar();
  return *kernel;  // a NoiseSource of that set exists, so the binary has it
}

double sum_of(const double* s) { return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7])); }

Moments moments_of(const double* sums, Index dof, Index runs) {
  const double n = static_cast<double>(runs);
  const double first = sum_of(sums), second = sum_of(sums + kAccumulators);
  const double shift = first / n;
  // rounding may leave less than nothing of a sum of squares; a NaN stays one
  const double m2 = second - first * shift;
  return {.count = runs, .mean = static_cast<double>(dof) + shift, .m2 = m2 < 0.0 ? 0.0 : m2};
}

}  // namespace

LinearSimulator::LinearSimulator(const LinearErrorSystem& system)
    : storage_(std::make_unique<const LinearPlanStorage>(system)) {}

LinearSimulator::LinearSimulator(LinearSimulator&&) noexcept = default;
LinearSimulator& LinearSimulator::operator=(LinearSimulator&&) noexcept = default;
LinearSimulator::~LinearSimulator() = default;

void LinearSimulator::simulate(const NoiseSource& noise, Index first_run, Index runs, std::span<Moments> nees,
                               std::span<Moments> nis) const {
  const LinearPlan& plan = storage_->plan();
  require(first_run >= 0, "first run is negative: ", first_run);
  require(runs >= 0, "number of runs is negative: ", runs);
  require(std::ssize(nees) == plan.steps, "there are not as many nees as steps: ", std::ssize(nees));
  require(std::ssize(nis) == plan.steps, "there are not as many nis as steps: ", std::ssize(nis));
  if (runs == 0) return;

  const std::int64_t batch = runs_of_batch(plan), groups = groups_of_block(plan);
  const std::int64_t slots =
      std::max<std::int64_t>(4 * groups * (plan.process_noises + plan.measurements), plan.states);
  const std::int64_t rows = std::int64_t{plan.states} * (batch / kNoiseLanes + 1) + plan.measurements + slots;
  AlignedBuffer workspace(static_cast<std::size_t>(rows * kNoiseLanes));
  AlignedBuffer sums(static_cast<std::size_t>(plan.steps * kSumsOfStep));
  linear_kernel(noise.instruction_set())
      .simulate(plan, noise.key(), static_cast<std::uint64_t>(first_run), runs, batch, groups, sums.data(),
                workspace.data());
  for (std::size_t k = 0; k < nees.size(); ++k) {
    const double* s = sums.data() + k * kSumsOfStep;
    nees[k].merge(moments_of(s, plan.step[k].error_whitening.rows, runs));
    nis[k].merge(moments_of(s + 2 * kAccumulators, plan.step[k].innovation_whitening.rows, runs));
  }
}

void simulate_linear(const LinearErrorSystem& system, const NoiseSource& noise, Index first_run, Index runs,
                     std::span<Moments> nees, std::span<Moments> nis) {
  LinearSimulator(system).simulate(noise, first_run, runs, nees, nis);
}

}  // namespace credence
