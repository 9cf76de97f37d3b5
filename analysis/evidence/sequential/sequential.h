#pragma once

#include <span>
#include <string_view>

#include "analysis/evidence/sequential/sequential_e_value.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/joint/betting_e_value.h"
#include "analysis/laws/mean/student.h"
#include "montecarlo/engine/run_averages.h"

/// @file
/// When a Monte Carlo study may stop.
///
/// Looking often at a fixed-sample test inflates its false alarms (every 25 runs, stop at the first
/// rejection: 30.5 % instead of 5 %; theory, section 7). Here α = 1 − confidence is split: one half for the
/// e-values of NEES and NIS (sequential_e_value.h; for NEES half and half with bets on whole runs,
/// betting_e_value.h), valid at every look, and one half for the fixed-sample
/// verdicts at the last look, whose number of runs was set in advance. By the union bound P(a consistent
/// filter is ever called optimistic or pessimistic) ≤ α. Decide only on the contiguous prefix of finished
/// chunks, in their order: the same study then stops at the same chunk whatever the threads did.

namespace credence::internal {

/// When to stop; a study always ends at its `max_runs`.
struct StopRule {
  double confidence = 0.95;
  bool on_verdict = true;          ///< stop when a filter is proved inconsistent
  double consistent_within = 0.0;  ///< > 0: stop as consistent when P is proved right within this factor − 1
  double precision = 0.0;          ///< > 0: stop when the mean NEES is known to this relative half-width
};

/// The sums of the finished prefix of runs.
struct StudyPrefix {
  std::span<const Moments> nees;     ///< at each step
  std::span<const double> nees_dof;  ///< total dof at each step
  std::span<const Moments> nis;      ///< empty without innovations
  std::span<const double> nis_dof;
  const RunAverages* runs = nullptr;    ///< of NEES; null: not known, and no interval of the mean
  const RunBetting* betting = nullptr;  ///< on the same runs; null: not known
  bool last = false;                    ///< max_runs is reached
};

/// What to do after a look.
struct StopDecision {
  bool stop = false;
  std::string_view reason = {};          ///< "verdict", "precision", "max_runs" or empty
  Verdict verdict = Verdict::undecided;  ///< undecided: more runs may tell
  double log_e_value = 0.0;              ///< of the whole study, ln of ½ (E_nees + E_nis)
  /// Valid at any look: twice the smaller of 1/E and, at the last look, that of the fixed-sample tests. A
  /// rule by verdict ends with optimistic or pessimistic iff it is at most 1 − confidence.
  double p_value = 1.0;
  ChiSquareBounds scale;   ///< confidence sequence of the factor on P, from NEES; on a stop
  MeanInterval mean_nees;  ///< over the runs, at `confidence`
};

/// Looks at a prefix. Precision is relative to the measured mean, and not absolute: the moment of stopping
/// then hardly depends on the mean, and the interval keeps its coverage (measured 93.5 to 95.5 % at nominal
/// 95 %); it stops no study before 30 runs. Throws std::invalid_argument for a rule outside its range or
/// sizes that differ.
StopDecision look(const StopRule& rule, const StudyPrefix& prefix);

}  // namespace credence::internal
