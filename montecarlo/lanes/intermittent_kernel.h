#pragma once

#include <cstdint>

#include "core/simd/cpu_dispatch.h"
#include "montecarlo/random/normal_kernel.h"

/// @file
/// The compiled kernels of IntermittentLanes: a monobot's filter for kNoiseLanes runs, each of which does a
/// Riccati step of its own because it has seen something of its own. Internal: plain types only, since the
/// files that include this are compiled for more than the portable machine.

namespace credence::internal {

/// A monobot with n = `states` states, whose measurements are first those of the anchors, −x_0 + w, then
/// those of the landmarks, x_i − x_0 + w.
struct IntermittentPlan {
  std::int32_t states, anchors;
  std::int32_t first_decorrelated;  ///< state from which on P is made diagonal before the update; n: none
  double process_variance, measurement_variance;  ///< as assumed
  double process_std, measurement_std;            ///< the true ones
  const double* constant;  ///< added to P before the update, lower triangle by rows; null for none
};

/// Numbers of one step, each of kNoiseLanes runs.
enum IntermittentValue : int {
  kNeesValue,
  kNisValue,
  kTracePriorValue,
  kTraceValue,
  kVehicleValue,
  kLandmarksValue,
  kCheckValue,  ///< 0 if P was positive definite, else less or NaN
  kIntermittentValues,
};

/// What a lane remembers comes in packs of `lanes` lanes (IntermittentKernel), one after the other, each
/// [row][lanes]; the others are [row][kNoiseLanes]. All is aligned to 64 bytes.
struct IntermittentData {
  double* errors;             ///< e = x − x̂, n rows
  double* covariance;         ///< P, lower triangle by rows
  const double* process;      ///< standard normals of the steps
  const double* measurement;  ///< of the steps of the first measurement, of the second, …
  const double* seen;         ///< likewise: 1 where there is that measurement, else 0
  std::int64_t drawn;         ///< steps from one measurement to the next in the two above
  double* work;               ///< of one pack: n (n + 1)/2 + 3 n rows
  double* values;             ///< step by step kIntermittentValues rows
};

/// The functions of one instruction set.
struct IntermittentKernel {
  /// `count` steps of all lanes: e and P of the last one, values of each.
  void (*steps)(const IntermittentPlan&, std::int64_t count, const IntermittentData&);
  /// Mean, and sum of squared deviations, of each of `rows` rows of kNoiseLanes values.
  void (*moments)(const double* values, std::int64_t rows, double* mean, double* m2);
  int lanes;  ///< of a pack
};

/// The kernel of one instruction set; throws std::invalid_argument if this machine does not support it.
const IntermittentKernel& intermittent_kernel(InstructionSet set);

/// Kernels by instruction set; null where the binary was built without it.
const IntermittentKernel* intermittent_kernel_scalar();
const IntermittentKernel* intermittent_kernel_avx2();
const IntermittentKernel* intermittent_kernel_avx512();

}  // namespace credence::internal
