#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/sample_size.h"

/// @file
/// What to do about a verdict: which block is responsible, by what to scale, and how many runs would tell
/// more.

namespace credence::internal {

/// The verdict on one block of the state.
struct BlockVerdict {
  std::string name;
  ConsistencyVerdict verdict;
};

/// A factor on a covariance with its interval.
struct ScaleAdvice {
  double factor = 1.0;
  double lower = 0.0;
  double upper = 0.0;
  std::string_view reason = {};  ///< why there is no factor (numbers NaN), else empty
};

/// No factor, and why.
ScaleAdvice no_scale(std::string_view reason);

/// The factor on P that would make the mean NEES the expected one, from the averages of whole runs
/// (ConsistencyVerdict::factor): the interval holds for an inconsistent filter too. It mends the mean only;
/// left_by_scale says what else that leaves.
ScaleAdvice scale_of_covariance(const ConsistencyVerdict& nees);

/// What the one factor on P (ConsistencyVerdict::factor) leaves where parts of the state, else steps, ask for
/// different ones: "acc optimistic and pos pessimistic", "steps 1 to 9 pessimistic"; empty where the factor
/// may be 1 or no difference is significant. Blocks: the logarithms of their factors against that of the
/// whole, by the intervals, Holm over the blocks; the one that differs most either way. It neglects that a
/// block is part of the whole, which errs towards saying nothing. Steps: by the bounds that all steps of a
/// consistent filter keep together, with the end of the factor's interval that speaks for them.
std::string left_by_scale(const ConsistencyVerdict& nees, std::span<const BlockVerdict> blocks);

/// The factor on S that would make the mean NIS the expected one: sum / dof with the χ² interval, which is
/// exact where NIS is white; correlation_time: as of judge_nis. Undefined, with a reason, without data.
ScaleAdvice scale_of_innovation(const ConsistencyVerdict& nis, double correlation_time = 1.0);

/// The factor on R alone that scales S by `scale` while P in it stays: 1 + (scale − 1) / share, share = mean
/// of tr(S⁻¹ R) / m in (0, 1], the part of S that is R. As what R adds to the errors is in P as well, the
/// factor by which R is wrong, if R alone is, lies between `scale` and this. Where the interval reaches below
/// 0 it is cut there; no factor, with a reason, if even the value is negative.
ScaleAdvice scale_of_measurement_noise(const ScaleAdvice& scale, double share);

/// Where an inconsistency sits.
struct ResponsibleBlock {
  std::int64_t index = -1;  ///< −1: no block is inconsistent
  bool joint_only = false;  ///< the whole state is inconsistent but no block: cross-covariances are wrong
};

/// The block with the largest standardised deviation (mean/expected − 1) √(dof per step / 2), of the mean or
/// of the step that decided, among the blocks that are inconsistent after Holm's adjustment over the blocks.
ResponsibleBlock responsible_block(const ConsistencyVerdict& whole, std::span<const BlockVerdict> blocks);

/// The power with which the runs that settle a case would settle it (settle_nees and settle_nis of
/// Judgement).
inline constexpr double kSettlingPower = 0.9;

/// How an undecided case could be settled.
struct SettlingRuns {
  double observed_factor = 1.0;  ///< mean / expected
  std::int64_t runs = 0;  ///< to detect that factor, if it is real, with this power; 0: none needed or known
  DetectableFactors detectable;  ///< with the runs there are
  std::string_view reason = {};  ///< why runs is 0, else empty
};

/// For a verdict `consistent`: the runs that would decide whether the deviation seen is real. No runs, with a
/// reason, for an inconsistent or undecided verdict and for a deviation below 10⁻⁴. runs: those of the study.
SettlingRuns runs_to_settle(const ConsistencyVerdict& verdict, const VerdictDesign& design, double runs,
                            double power);

}  // namespace credence::internal
