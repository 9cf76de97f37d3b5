#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/types.h"
#include "montecarlo/engine/moments.h"
#include "montecarlo/random/noise.h"

/// @file
/// Monte Carlo of a linear filter at the cost of its random numbers. P, K and S depend on no data, so they
/// are computed once for all runs; what is left of a run is its error, propagated in SIMD lanes, one run a
/// lane.
///
/// Arithmetic, the same at every SIMD width and in trace_linear: every sum of products starts at zero and
/// takes its terms by fused multiply-adds in the order in which this header writes them, columns ascending;
/// terms that are structurally zero may be left out, which changes no bit of a finite result but the sign of
/// a zero.

namespace credence::internal {

class LinearPlanStorage;

/// What moves an error in one step, and what is measured of it.
struct LinearErrorDynamics {
  Matrix F;
  Matrix noise_input;       ///< G_q = G chol(Q)
  Matrix H;                 ///< m×n
  Matrix measurement_root;  ///< R_r = chol(R)
};

/// Error dynamics of a linear filter, step k = 1 … steps.size(), with the error e = x − x̂:
///
///   e_0 = L n,  e⁻ = F e + G_q v,  nu = H e⁻ + R_r w,  e = e⁻ − K_k nu,
///   NIS_k = ‖W_k nu‖²,  NEES_k = ‖V_k e‖²,  n, v, w standard normal.
///
/// The noise that drives it is the true one, whatever the filter assumes. Shapes: F n×n, noise_input n×q,
/// H m×n, measurement_root m×m, initial_root n×n. F, G_q, H and R_r may be periodic.
struct LinearErrorSystem : LinearErrorDynamics {
  Matrix initial_root;                     ///< L = chol(P0)
  std::vector<LinearErrorDynamics> later;  ///< of the steps 2 … p of a period; empty: the same always

  Index period() const { return 1 + std::ssize(later); }
  /// Of step k, from 1 on.
  const LinearErrorDynamics& at(Index k) const {
    const auto phase = static_cast<std::size_t>((k - 1) % period());
    return phase == 0 ? *this : later[phase - 1];
  }

  struct Step {
    Matrix K;                     ///< gain, n×m
    Matrix innovation_whitening;  ///< W with Wᵀ W = S⁻¹, r×m, r <= m: its rows are the dof of NIS
    Matrix error_whitening;  ///< V with Vᵀ V = P⁻¹, r×n, r <= n: states of zero variance are left out
  };
  std::vector<Step> steps;
};

/// Throws std::invalid_argument naming the first matrix whose shape does not match or that is not finite.
void check_linear_error_system(const LinearErrorSystem& system);

/// A system made ready for any number of chunks of runs, in any number of threads.
class LinearSimulator {
 public:
  /// Throws as check_linear_error_system does.
  explicit LinearSimulator(const LinearErrorSystem& system);
  LinearSimulator(LinearSimulator&&) noexcept;
  LinearSimulator& operator=(LinearSimulator&&) noexcept;
  ~LinearSimulator();

  /// Adds NEES and NIS of the runs first_run … first_run + runs − 1 to the moments of each step.
  ///
  /// Noise of run i: step 0, purpose initial, slots 0 … n − 1; step k, purpose process, slots 0 … q − 1, and
  /// purpose measurement, slots 0 … m − 1. With c the dof of a step, the deviation d of a run is −c plus its
  /// squares, one by one; Σ d and Σ d² are kept in eight accumulators (in the units mentioned above), run
  /// first_run + i in accumulator i mod 8, added up as ((0+4)+(2+6))+((1+5)+(3+7)), and merged into `nees`
  /// and `nis` as one chunk. `run_nees`, unless empty, gets the sum of the NEES of each run over its steps: d
  /// of the steps in their order, then the dof. Uses the instruction set of `noise`. Not finite where an
  /// error is not. Throws std::invalid_argument for negative runs, spans that are not as long as there are
  /// steps or runs, or noise that is not white and Gaussian.
  void simulate(const NoiseSource& noise, Index first_run, Index runs, std::span<Moments> nees,
                std::span<Moments> nis, std::span<double> run_nees = {}) const;

 private:
  std::unique_ptr<const LinearPlanStorage> storage_;
};

/// All that one run of a LinearSimulator went through, to the bit. Entry k − 1 is of step k.
struct LinearRunTrace {
  Vector initial_error;                   ///< e_0
  std::vector<Vector> errors;             ///< e after the update
  std::vector<Vector> innovations;        ///< nu
  std::vector<Vector> process_noise;      ///< G_q v
  std::vector<Vector> measurement_noise;  ///< R_r w
  std::vector<double> nees, nis;
};

/// Replays one run; throws std::invalid_argument as check_linear_error_system does, or for a negative run.
LinearRunTrace trace_linear(const LinearErrorSystem& system, const NoiseSource& noise, Index run);

}  // namespace credence::internal
