#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/verdicts/step_times.h"
#include "analysis/evidence/verdicts/verdict.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/student.h"
#include "core/nan.h"
#include "montecarlo/engine/moments.h"
#include "montecarlo/engine/run_averages.h"

/// @file
/// One verdict over all steps of a Monte Carlo study of NEES or NIS (theory, section 7).
///
/// A verdict joins two tests by the union bound, each at half the level α = 1 − confidence:
///  - steps: every step's mean against its χ² law, Bonferroni over the T steps. Proved for any dependence
///    between the steps. Sees a deviation at one step, such as a wrong initial P. A mean that is too small is
///    not looked for at a step of one or two degrees of freedom, nor where it is zero in fewer than five
///    runs: there it tells that values were rounded.
///  - overall: the sum over steps and runs. NEES is correlated in time, so whole runs are compared, which are
///    independent (run_mean.h; its measured level is there); of fewer than five runs, or where the averages
///    of the runs are not known, the sum is tested by a bound proved for any dependence
///    (chi_square_dependent_sum.h). NIS of a consistent filter is white, so its sum is χ² exactly. Sees a
///    small deviation that lasts.
/// Hence P(false alarm) ≤ α for NEES under every correlation in time, and for NIS under whiteness. A single
/// step is tested once, at the full level. Each direction has its own p-value: a filter may be optimistic at
/// some steps and pessimistic at others.
/// Assumed: errors and innovations Gaussian, runs independent, and the count of runs of a step not chosen by
/// the outcome (failed runs are reported elsewhere).

namespace credence::internal {

/// The test of one step; a step without data has count 0 or total_dof 0 and NaN elsewhere.
struct StepTest {
  double mean = 0.0;      ///< over the runs
  double expected = 0.0;  ///< total_dof / count
  double lower = 0.0;     ///< pointwise acceptance bounds of the mean at `confidence`
  double upper = 0.0;
  double simultaneous_lower = 0.0;  ///< bounds that all steps of a consistent filter keep together
  double simultaneous_upper = 0.0;
  double p_value = 0.0;    ///< of this step alone, two-sided, not adjusted
  std::int64_t count = 0;  ///< runs that contributed
  double total_dof = 0.0;  ///< sum over these runs of their dof
  bool outside = false;    ///< the mean lies outside the pointwise bounds

  bool has_data() const { return count > 0 && total_dof > 0.0; }
};

/// Steps that reject in one direction, from 1; none: first = 0.
struct StepSpan {
  std::int64_t first = 0, last = 0, count = 0;

  /// Steps come in their order.
  void add(std::int64_t step) {
    if (count++ == 0) first = step;
    last = step;
  }
};

/// The verdict over all steps with everything it rests on.
struct ConsistencyVerdict {
  Verdict verdict = Verdict::undecided;
  std::string reason;  ///< why undecided, else empty
  std::string method;  ///< the tests in words
  double confidence = 0.0;
  double p_value = kNaN;              ///< adjusted: the verdict is not `consistent`
                                      ///< iff p_value ≤ 1 − confidence
  double optimistic_p_value = kNaN;   ///< of this direction, adjusted; p_value is the smaller of both
  double pessimistic_p_value = kNaN;  ///< likewise
  bool decided_by_steps = false;      ///< the smallest p-value is that of a step, and not of the overall test
  bool decided_by_sensors = false;    ///< the verdict is that of the sensors one by one
  MeanInterval factor = {};           ///< on P, of whole runs at `confidence`; a reason where not known
  StepSpan optimistic_steps, pessimistic_steps;  ///< that reject, adjusted for the number of steps
  double overall_p_value = kNaN;                 ///< of the overall test alone
  double bounds_p_value = kNaN;  ///< of the test that has the bounds; NaN: it is the overall one
  double steps_p_value = kNaN;   ///< of the worst step, adjusted for the number of steps
  double mean = 0.0;  ///< over all steps and runs; of runs of different lengths that are compared, over these
  double expected = 0.0;   ///< dof / count
  ChiSquareBounds bounds;  ///< of the overall mean, as the verdict uses them
  double dof = 0.0;        ///< sum over steps and runs
  std::int64_t count = 0;  ///< values: runs summed over steps
  std::int64_t tests = 0;  ///< made: steps tested, and the overall one where it is a further one
  std::int64_t steps_tested = 0;
  std::int64_t steps_without_data = 0;
  std::int64_t steps_rejected = 0;           ///< by Holm's procedure at 1 − confidence
  std::int64_t worst_step = -1;              ///< index of the smallest p-value, −1 for none
  double share_outside = 0.0;                ///< of tested steps outside their pointwise bounds
  double expected_share_outside = 0.0;       ///< 1 − confidence for a consistent filter
  std::vector<StepTest> steps;               ///< one for each step given
  std::int64_t step_stride = 1;              ///< between two of them, in steps of the runs
  std::shared_ptr<const StepTimes> times{};  ///< of the runs; null: not known

  /// The step of the runs, from 1, that is the entry-th of the steps given, from 1.
  std::int64_t step_of(std::int64_t entry) const { return 1 + (entry - 1) * step_stride; }

  /// " (t = 1.8 s)" of these entries, from 1; empty where not known.
  std::string time_text(std::int64_t first, std::int64_t last) const;
  /// "step 3 (t = 0.3 s)" or "steps 3 to 7", of the runs; empty for none.
  std::string text_of(const StepSpan& span) const;
  /// Of one of the steps given, from 1.
  std::string text_of_step(std::int64_t entry) const {
    return text_of({.first = entry, .last = entry, .count = 1});
  }
};

/// The verdict on NEES, total or of a block of the state: steps correlated in time in any way.
///
/// runs: the averages of the whole runs among them, where known. per_step[k] holds the NEES of the runs at
/// step k, total_dof_per_step[k] the sum of their dof (runs × n, or less where a variance is zero). Steps
/// with count or dof 0 are left out and counted. Undecided, with a reason: no step with data; a NaN or
/// negative mean, which no covariance can give. Throws std::invalid_argument for sizes that differ, a
/// negative or non-finite dof, a negative count, or a confidence outside (0, 1).
ConsistencyVerdict judge_nees(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                              double confidence, const RunAverages* runs = nullptr);

/// The verdict on NIS: steps white, so the sum over runs and steps is χ²(Σ dof). Of steps that are not, the
/// variance of the sum is `correlation_time` ≥ 1 times that (square_correlation.h), and its law that of
/// correlation_time χ²(Σ dof/correlation_time), an approximation. Else as judge_nees.
ConsistencyVerdict judge_nis(std::span<const Moments> per_step, std::span<const double> total_dof_per_step,
                             double confidence, double correlation_time = 1.0);

/// The verdict on NIS that had to pass a gate, all of dimension `dof`: each step and the sum, as judge_nis,
/// with the law of χ²(dof) truncated at `gate` (chi_square_truncated.h).
///
/// The sums are taken as matched in three cumulants: an approximation, good from about 20 values a step on
/// for the 99 % gate. count values of a step, all ≤ gate; NEES of a gated filter has no such simple law.
/// correlation_time: as of judge_nis. Throws as judge_nis, and unless dof and gate are > 0.
ConsistencyVerdict judge_gated_nis(std::span<const Moments> per_step, double dof, double gate,
                                   double confidence, double correlation_time = 1.0);

}  // namespace credence::internal
