#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/evidence/sums/whole_turns.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/tuning/innovation_tests.h"
#include "core/nan.h"

/// @file
/// What a log of innovations ν and their covariance S alone can say of a filter's noise: by what S is wrong,
/// and to which side the gain. Q and R can only be told apart by a model, F and H, which a log does not hold.

namespace credence::internal {

/// The innovations of one sensor.
struct SensorRecord {
  std::string name;
  std::vector<RecordedInnovations> runs;  ///< NIS and L⁻¹ν in order of time, all of one dimension
  double log_determinant = 0.0;           ///< of S, summed over all
  std::int64_t left_out = 0;      ///< of another dimension, or with an S that is not positive definite
  std::int64_t unwrapped = 0;     ///< components that are angles, beyond half a turn
  std::vector<WholeTurns> turns;  ///< of the components of a piece that are not marked as angles
};

/// To which side the gain is wrong.
enum class GainError {
  none_seen,  ///< the innovations look white
  too_small,  ///< they are positively correlated: errors linger, Q over R is too small
  too_large,  ///< they alternate: the filter follows the noise, Q over R is too large
  other,      ///< correlated, but not from one to the next
};

/// "none seen", "too small", "too large" or "other".
std::string_view to_string(GainError error);

/// One left-out part after the other against the scale of all others: the ratio of their mean NIS follows
/// the F law if they are white; else it is not tested.
struct LeftOut {
  Verdict verdict = Verdict::undecided;
  std::int64_t parts = 0, rejected = 0;  ///< rejected by Holm's procedure
  bool tested = false;
  bool of_runs = false;    ///< the parts are runs; else stretches of them
  double mean_nis = kNaN;  ///< of all parts, each over the scale of the others
};

/// How the note of InnovationTuning::comes_first begins.
inline constexpr std::string_view kComesFirst = "First: ";

/// One sensor, tuned.
struct InnovationTuning {
  std::string name;
  double dof = 0.0;  ///< of an innovation
  std::int64_t values = 0;
  std::int64_t left_out = 0;           ///< innovations that could not be used
  NoiseScale scale;                    ///< by which S, and so all of P0, Q and R together, must be multiplied
  double steps_for_10_percent = kNaN;  ///< until the standard error of the scale is 10 %
  double lag_one = kNaN;               ///< autocorrelation of the normalised innovation at lag 1
  double band = kNaN;                  ///< its half-width if they were white
  double whiteness_p_value = kNaN;
  GainError gain = GainError::none_seen;
  double score_before = kNaN, score_after = kNaN;  ///< mean log score, with S and with the scaled one
  double likelihood_ratio_p_value = kNaN;          ///< NaN where they are not white: it would need that
  LeftOut left_out_parts;
  /// What no noise mends, and what makes the scale and the gain say nothing until it is mended: "the
  /// innovations have mean 0.4 standard deviations (p = 1e−9)". Empty: nothing of the kind is seen.
  std::string comes_first;
  std::vector<std::string> notes;  ///< the first holds for every log
};

/// Tunes a sensor. An angle that is not wrapped, or a mean of the innovations that is not zero (by its
/// p-value adjusted as in InnovationTests), comes first. The interval of the scale assumes neither whiteness
/// nor a law (NoiseScale); tests are at the level of one of so many sensors. Parts that are left out are
/// compared by the F law, of so many fewer values as NIS varies more than χ². Throws std::invalid_argument
/// for a record without innovations.
InnovationTuning tune_innovations(const SensorRecord& record, double confidence, std::int64_t sensors = 1);

}  // namespace credence::internal
