#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"

/// @file
/// What the compiled kernels of LinearSimulator read: plain arrays, since the kernels are compiled for more
/// than the portable machine. Internal: use montecarlo/lanes/linear_kernel.h.

namespace credence::internal {

/// Rows of a sparse matrix: row i has the entries row_start[i] … row_start[i + 1] − 1.
struct SparseRows {
  const std::int32_t* row_start;
  const std::int32_t* column;
  const double* value;
};

/// Rows of a dense matrix, row-major; row i is zero outside the columns begin[i] … end[i] − 1.
struct DenseRows {
  std::int32_t rows, columns;
  const std::int32_t* begin;
  const std::int32_t* end;
  const double* value;
};

/// One step of the filter.
struct LinearPlanStep {
  DenseRows gain, innovation_whitening, error_whitening;
  double nis_centre, nees_centre;  ///< what is taken off before the sums, near the mean
  double nees_scale;               ///< of NEES in the original units
};

/// The matrices of one step of a period.
struct LinearPlanPhase {
  bool identity;  ///< F = I
  SparseRows F, noise_input, H, measurement_root;
  /// Of a small system: F and H by rows, noise_input and, after H, measurement_root by columns.
  const double *dense_F, *dense_H, *noise_columns;
};

/// States and measurements of a system that can be small.
inline constexpr int kMostSmallStates = 4, kMostSmallMeasurements = 3;

/// A LinearErrorSystem, in the units of linear_kernel_units.h, as the kernels want it.
struct LinearPlan {
  std::int32_t states, process_noises, measurements;
  std::int64_t steps, period;
  const LinearPlanPhase* phase;  ///< `period` of them
  SparseRows initial_root;
  const LinearPlanStep* step;  ///< `steps` of them
  /// Not null for a small system, whose whitenings are lower triangles of full size that end in one: for
  /// every step K by rows, then both whitenings by rows.
  const double* small_coefficients;
  const double* monobot_roots;  ///< the diagonal of the root of R; null unless it is a small monobot
};

/// Sums of one step over the runs: Σ (x − centre) and Σ (x − centre)² of NEES, then of NIS, each in eight
/// accumulators.
inline constexpr int kAccumulators = 8;
inline constexpr int kSumsOfStep = 4 * kAccumulators;

/// Counter word 2 of slot 0 of a purpose (montecarlo/random/noise.h).
inline constexpr std::uint32_t kInitialPurpose = 0u << 24, kProcessPurpose = 1u << 24,
                               kMeasurementPurpose = 2u << 24;

/// Memory of a simulation; all of it aligned to 64 bytes. Noise and sums are a multiple of 1 KB apart: they
/// advance in step, and a load whose address has the low 12 bits of a recent store would have to wait for it.
struct LinearWorkspace {
  std::int64_t
      runs_of_batch;    ///< carried through a block of steps before the next block; a multiple of kNoiseLanes
  std::int64_t groups;  ///< noise is drawn for so many times four steps at once
  double* noise;        ///< kNoiseLanes times 4 groups slots, or the states if they are more
  double* sums;         ///< of all steps
  double* errors;       ///< kNoiseLanes times states, for every kNoiseLanes runs of a batch
  double* scratch;      ///< kNoiseLanes times states and measurements
  double* run_sums;     ///< of every run, and to a multiple of kNoiseLanes: Σ_k nees_scale (NEES − centre)
};

/// The function of one instruction set.
struct LinearKernel {
  /// Adds the runs to the sums of the workspace.
  void (*simulate)(const LinearPlan&, std::uint64_t noise_key, std::uint64_t first_run, std::int64_t runs,
                   const LinearWorkspace&);
};

/// Kernels by instruction set; null where the binary was built without it.
const LinearKernel* linear_kernel_scalar();
const LinearKernel* linear_kernel_avx2();
const LinearKernel* linear_kernel_avx512();

}  // namespace credence::internal
