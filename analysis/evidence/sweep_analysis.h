#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/studies/rank_map.h"
#include "montecarlo/scenario/sweep_plan.h"

namespace credence::internal {

/// A sweep: the study of each configuration, and what they say together.
struct SweepAnalysis {
  SweepPlan plan;
  std::vector<StudyAnalysis> studies;  ///< of the configurations that have results, in the plan's order
  std::vector<std::size_t> points;     ///< index in the plan of each study's configuration
  std::vector<double> p_values;        ///< of each study, all taken together: sweep_p_values
  std::vector<RankMapCell> rank_map;   ///< of each study; empty unless the whole plan is a map of ranks

  const SweepPoint& point(std::size_t study) const { return plan.points[points[study]]; }
  /// The level of the tests of all configurations together.
  double confidence() const { return studies.front().scenario.study.confidence; }
  /// Whether this study is inconsistent also when all are taken together.
  bool stands(std::size_t study) const;
};

/// One p-value for each configuration of a sweep, adjusted so that among those at or below 1 − confidence the
/// expected share of consistent filters is at most 1 − confidence, whatever noise the configurations share
/// ([Benjamini 2001]).
///
/// Before the adjustment: the p-value of the word, or that of the stop rule; NaN for a configuration without
/// data.
std::vector<double> sweep_p_values(std::span<const StudyAnalysis> analyses);

/// Drops what is of single steps and runs, which a sweep's JSON alone shows, and of which there are
/// thousands.
void forget_steps(StudyAnalysis& study);

/// Judges a sweep as a whole; throws std::invalid_argument for a study of no point of the plan.
/// Cost: in a map of ranks, the long covariance recursion of every cell.
SweepAnalysis analyse_sweep(SweepPlan plan, std::vector<StudyAnalysis> studies);

}  // namespace credence::internal
