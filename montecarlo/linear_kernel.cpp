#include "montecarlo/linear_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "montecarlo/linear_kernel_plan.h"
#include "montecarlo/normal_kernel.h"

namespace credence {
namespace {

static_assert(kInitialPurpose == static_cast<std::uint32_t>(NoisePurpose::initial) << 24);
static_assert(kProcessPurpose == static_cast<std::uint32_t>(NoisePurpose::process) << 24);
static_assert(kMeasurementPurpose == static_cast<std::uint32_t>(NoisePurpose::measurement) << 24);

void require(bool ok, const std::string& what) {
  if (!ok) throw std::invalid_argument("linear system: " + what);
}

void require_shape(const char* name, const Matrix& matrix, Index rows, Index columns) {
  const auto shape = [](Index r, Index c) { return std::to_string(r) + "x" + std::to_string(c); };
  require(matrix.rows() == rows && matrix.cols() == columns,
          std::string(name) + " is " + shape(matrix.rows(), matrix.cols()) + ", not " + shape(rows, columns));
  require(matrix.allFinite(), std::string(name) + " has an entry that is not finite");
}

void check_runs(Index first_run, Index runs) {
  require(first_run >= 0, "first run is negative: " + std::to_string(first_run));
  require(runs >= 0, "number of runs is negative: " + std::to_string(runs));
}

/// Owner of SparseRows.
class SparseMatrix {
 public:
  explicit SparseMatrix(const Matrix& matrix) : row_start_{0} {
    for (Index row = 0; row < matrix.rows(); ++row) {
      for (Index column = 0; column < matrix.cols(); ++column) {
        if (matrix(row, column) == 0.0) continue;
        column_.push_back(static_cast<std::int32_t>(column));
        value_.push_back(matrix(row, column));
      }
      row_start_.push_back(static_cast<std::int32_t>(value_.size()));
    }
  }
  SparseRows rows() const { return {row_start_.data(), column_.data(), value_.data()}; }

 private:
  std::vector<std::int32_t> row_start_, column_;
  std::vector<double> value_;
};

/// Owner of DenseRows.
class DenseMatrix {
 public:
  explicit DenseMatrix(const Matrix& matrix)
      : rows_(static_cast<std::int32_t>(matrix.rows())), columns_(static_cast<std::int32_t>(matrix.cols())) {
    for (Index row = 0; row < matrix.rows(); ++row) {
      Index begin = 0, end = matrix.cols();
      while (begin < end && matrix(row, begin) == 0.0) ++begin;
      while (end > begin && matrix(row, end - 1) == 0.0) --end;
      begin_.push_back(static_cast<std::int32_t>(begin));
      end_.push_back(static_cast<std::int32_t>(end));
      for (Index column = 0; column < matrix.cols(); ++column) value_.push_back(matrix(row, column));
    }
  }
  DenseRows rows() const { return {rows_, columns_, begin_.data(), end_.data(), value_.data()}; }

 private:
  std::int32_t rows_, columns_;
  std::vector<std::int32_t> begin_, end_;
  std::vector<double> value_;
};

/// True for the monobots that have a kernel of their own: F = I, noise on the vehicle alone, anchors first.
bool is_small_monobot(const LinearErrorSystem& system) {
  const Index n = system.F.rows(), m = system.H.rows(), anchors = m - (n - 1);
  if ((n != 2 && n != 3) || anchors < 0 || anchors > 1 || !system.F.isIdentity(0.0)) return false;
  if (system.noise_input.cols() != 1 || !(system.noise_input.bottomRows(n - 1).array() == 0.0).all())
    return false;
  Matrix H = Matrix::Zero(m, n);
  H.col(0).setConstant(-1.0);
  H.bottomRightCorner(n - 1, n - 1).setIdentity();
  if (H != system.H) return false;
  if (!system.measurement_root.isDiagonal(0.0)) return false;
  return std::all_of(system.steps.begin(), system.steps.end(), [&](const LinearErrorSystem::Step& step) {
    return step.innovation_whitening.rows() == m && step.error_whitening.rows() == n &&
           step.innovation_whitening.isLowerTriangular(0.0) && step.error_whitening.isLowerTriangular(0.0);
  });
}

void append_rows(const Matrix& matrix, bool lower, std::vector<double>& out) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index column = 0; column < (lower ? row + 1 : matrix.cols()); ++column)
      out.push_back(matrix(row, column));
  }
}

/// Owner of a LinearPlan.
class Plan {
 public:
  explicit Plan(const LinearErrorSystem& system)
      : F_(system.F),
        noise_input_(system.noise_input),
        H_(system.H),
        measurement_root_(system.measurement_root),
        initial_root_(system.initial_root) {
    for (const LinearErrorSystem::Step& step : system.steps) {
      matrices_.emplace_back(step.K);
      matrices_.emplace_back(step.innovation_whitening);
      matrices_.emplace_back(step.error_whitening);
    }
    for (std::size_t i = 0; i < matrices_.size(); i += 3) {
      steps_.push_back({matrices_[i].rows(), matrices_[i + 1].rows(), matrices_[i + 2].rows()});
    }
    if (is_small_monobot(system)) set_monobot(system);
    plan_ = {.states = static_cast<std::int32_t>(system.F.rows()),
             .process_noises = static_cast<std::int32_t>(system.noise_input.cols()),
             .measurements = static_cast<std::int32_t>(system.H.rows()),
             .steps = static_cast<std::int64_t>(system.steps.size()),
             .identity = system.F.isIdentity(0.0),
             .F = F_.rows(),
             .noise_input = noise_input_.rows(),
             .H = H_.rows(),
             .measurement_root = measurement_root_.rows(),
             .initial_root = initial_root_.rows(),
             .step = steps_.data(),
             .monobot_coefficients = monobot_coefficients_.empty() ? nullptr : monobot_coefficients_.data(),
             .monobot_roots = monobot_roots_.data()};
  }
  Plan(const Plan&) = delete;
  Plan& operator=(const Plan&) = delete;

  const LinearPlan& get() const { return plan_; }

 private:
  void set_monobot(const LinearErrorSystem& system) {
    monobot_roots_.push_back(system.noise_input(0, 0));
    for (Index i = 0; i < system.H.rows(); ++i) monobot_roots_.push_back(system.measurement_root(i, i));
    for (const LinearErrorSystem::Step& step : system.steps) {
      append_rows(step.K, false, monobot_coefficients_);
      append_rows(step.innovation_whitening, true, monobot_coefficients_);
      append_rows(step.error_whitening, true, monobot_coefficients_);
    }
  }

  SparseMatrix F_, noise_input_, H_, measurement_root_, initial_root_;
  std::vector<DenseMatrix> matrices_;
  std::vector<LinearPlanStep> steps_;
  std::vector<double> monobot_coefficients_, monobot_roots_;
  LinearPlan plan_;
};

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

void check_linear_error_system(const LinearErrorSystem& system) {
  const Index n = system.F.rows(), m = system.H.rows();
  require_shape("F", system.F, n, n);
  require_shape("noise_input", system.noise_input, n, system.noise_input.cols());
  require_shape("H", system.H, m, n);
  require_shape("measurement_root", system.measurement_root, m, m);
  require_shape("initial_root", system.initial_root, n, n);
  for (const LinearErrorSystem::Step& step : system.steps) {
    require_shape("K", step.K, n, m);
    require_shape("innovation_whitening", step.innovation_whitening, step.innovation_whitening.rows(), m);
    require_shape("error_whitening", step.error_whitening, step.error_whitening.rows(), n);
  }
}

void simulate_linear(const LinearErrorSystem& system, const NoiseSource& noise, Index first_run, Index runs,
                     std::span<Moments> nees, std::span<Moments> nis) {
  check_linear_error_system(system);
  check_runs(first_run, runs);
  require(nees.size() == system.steps.size(), "length of nees is " + std::to_string(nees.size()));
  require(nis.size() == system.steps.size(), "length of nis is " + std::to_string(nis.size()));
  if (runs == 0) return;

  const Plan owner(system);
  const LinearPlan& plan = owner.get();
  const std::int64_t batch = runs_of_batch(plan), groups = groups_of_block(plan);
  const std::int64_t slots =
      std::max<std::int64_t>(4 * groups * (plan.process_noises + plan.measurements), plan.states);
  const std::int64_t rows = std::int64_t{plan.states} * (batch / kNoiseLanes + 1) + plan.measurements + slots;
  AlignedBuffer workspace(static_cast<std::size_t>(rows * kNoiseLanes));
  AlignedBuffer sums(system.steps.size() * kSumsOfStep);
  linear_kernel(noise.instruction_set())
      .simulate(plan, noise.key(), static_cast<std::uint64_t>(first_run), runs, batch, groups, sums.data(),
                workspace.data());
  for (std::size_t k = 0; k < system.steps.size(); ++k) {
    const double* s = sums.data() + k * kSumsOfStep;
    const LinearErrorSystem::Step& step = system.steps[k];
    nees[k].merge(moments_of(s, step.error_whitening.rows(), runs));
    nis[k].merge(moments_of(s + 2 * kAccumulators, step.innovation_whitening.rows(), runs));
  }
}

}  // namespace credence
