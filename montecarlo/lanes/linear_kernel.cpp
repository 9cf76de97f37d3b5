#include "montecarlo/lanes/linear_kernel.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/simd/aligned_vector.h"
#include "core/simd/kernel_choice.h"
#include "montecarlo/lanes/linear_kernel_storage.h"
#include "montecarlo/random/normal_kernel.h"

namespace credence::internal {
namespace {

static_assert(kInitialPurpose == static_cast<std::uint32_t>(NoisePurpose::initial) << 24);
static_assert(kProcessPurpose == static_cast<std::uint32_t>(NoisePurpose::process) << 24);
static_assert(kMeasurementPurpose == static_cast<std::uint32_t>(NoisePurpose::measurement) << 24);

void require(bool ok, const char* what, Index value) {
  if (!ok) throw std::invalid_argument(std::string("LinearSimulator: ") + what + std::to_string(value));
}

/// Runs whose states stay in the L1 cache together with what else is there.
std::int64_t runs_of_batch(const LinearPlan& plan) {
  constexpr std::int64_t kDoubles = 512;
  const std::int64_t tiles = kDoubles / std::max<std::int64_t>(1, std::int64_t{plan.states} * kNoiseLanes);
  return std::clamp<std::int64_t>(tiles, 1, 8) * kNoiseLanes;
}

/// Blocks of four steps whose noise is drawn at once, as even as can be: half of a common L1 cache.
std::int64_t groups_of_block(const LinearPlan& plan) {
  constexpr std::int64_t kDoubles = 2048;
  const std::int64_t slots = std::int64_t{plan.process_noises} + plan.measurements;
  const std::int64_t most =
      std::clamp<std::int64_t>(kDoubles / std::max<std::int64_t>(1, slots * 4 * kNoiseLanes), 1, 8);
  const std::int64_t groups = std::max<std::int64_t>(1, (plan.steps + 3) / 4);
  const std::int64_t blocks = (groups + most - 1) / most;
  return (groups + blocks - 1) / blocks;
}

/// Owner of a LinearWorkspace.
class Workspace {
 public:
  Workspace(const LinearPlan& plan, std::int64_t runs) {
    const std::int64_t batch = runs_of_batch(plan), groups = groups_of_block(plan);
    const std::int64_t slots = std::int64_t{plan.process_noises} + plan.measurements;
    const std::int64_t noise =
        round_up(std::max<std::int64_t>(4 * groups * slots, plan.states) * kNoiseLanes);
    const std::int64_t sums = plan.steps * kSumsOfStep, errors = plan.states * batch;
    const std::int64_t scratch = (std::int64_t{plan.states} + plan.measurements) * kNoiseLanes;
    const std::int64_t run_sums = (runs + kNoiseLanes - 1) / kNoiseLanes * kNoiseLanes;
    storage_.resize(static_cast<std::size_t>(noise + sums + errors + scratch + run_sums));
    double* const start = storage_.data();
    double* const after_errors = start + noise + sums + errors;
    workspace_ = {
        batch, groups, start, start + noise, start + noise + sums, after_errors, after_errors + scratch};
  }
  const LinearWorkspace& get() const { return workspace_; }

 private:
  /// To a multiple of 1 KB.
  static std::int64_t round_up(std::int64_t doubles) { return (doubles + 127) / 128 * 128; }

  AlignedVector storage_;
  LinearWorkspace workspace_;
};

const LinearKernel& linear_kernel(InstructionSet set) {
  return require_kernel(set, CREDENCE_KERNELS(linear_kernel));
}

}  // namespace

LinearSimulator::LinearSimulator(const LinearErrorSystem& system)
    : storage_(std::make_unique<const LinearPlanStorage>(linear_system_in_units(system))) {}

LinearSimulator::LinearSimulator(LinearSimulator&&) noexcept = default;
LinearSimulator& LinearSimulator::operator=(LinearSimulator&&) noexcept = default;
LinearSimulator::~LinearSimulator() = default;

void LinearSimulator::simulate(const NoiseSource& noise, Index first_run, Index runs, std::span<Moments> nees,
                               std::span<Moments> nis, std::span<double> run_nees) const {
  const LinearPlan& plan = storage_->plan();
  require(first_run >= 0, "first run is negative: ", first_run);
  require(runs >= 0, "number of runs is negative: ", runs);
  require(std::ssize(nees) == plan.steps, "there are not as many nees as steps: ", std::ssize(nees));
  require(std::ssize(nis) == plan.steps, "there are not as many nis as steps: ", std::ssize(nis));
  const bool run_sums = !run_nees.empty();
  if (run_sums)
    require(std::ssize(run_nees) == runs, "there are not as many run_nees as runs: ", std::ssize(run_nees));
  if (!noise.is_plain()) {
    throw std::invalid_argument("LinearSimulator: the lanes draw white Gaussian noise alone");
  }
  if (runs == 0) return;

  const Workspace workspace(plan, runs);
  linear_kernel(noise.instruction_set())
      .simulate(plan, noise.key(), static_cast<std::uint64_t>(first_run), runs, workspace.get());
  for (std::size_t k = 0; k < nees.size(); ++k) {
    const double* sums_of_step = workspace.get().sums + k * kSumsOfStep;
    nees[k].merge(storage_->nees_moments(k, sums_of_step, runs));
    nis[k].merge(storage_->nis_moments(k, sums_of_step, runs));
  }
  if (!run_sums) return;
  double dof = 0.0;
  for (std::int64_t k = 0; k < plan.steps; ++k) dof += plan.step[k].error_whitening.rows;
  for (std::size_t i = 0; i < run_nees.size(); ++i) run_nees[i] = workspace.get().run_sums[i] + dof;
}

}  // namespace credence::internal
