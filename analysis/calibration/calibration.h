#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/calibration/calibration_sums.h"
#include "analysis/evidence/verdicts/claimed_sigma.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/mean/student.h"
#include "core/nan.h"

/// @file
/// Where P lies, by how much, and what would mend it, judged on runs that were left out.
///
/// Units are whole runs, from five on; of fewer runs their stretches, ten of each, and of a single one
/// twenty, as far as they are long enough (shortest_stretch) and no error stays as it is
/// (LawSums::errors_stand). Every mean over units takes the tests of run_mean.h, which need neither a
/// Gaussian law nor independence in time.

namespace credence::internal {

/// The factor between true and claimed variance of one state where it claims standard deviations in a range:
/// that of all rows there. It is tested by Σ (e²/σ² − 1) of each unit, whose mean is 0 even where σ follows
/// the errors.
struct SigmaBin {
  Index state = 0;
  double lower = 0.0, upper = 0.0;   ///< of the claimed σ
  double claimed = 0.0, rmse = 0.0;  ///< root mean squares over the rows
  std::int64_t rows = 0;
  MeanInterval factor;  ///< mean e²/σ² of all rows; reason: fewer than five units came here
  DirectedPValues directed{kNaN, kNaN};  ///< that it is 1; NaN without a test
  double p_value = 0.0;                  ///< two-sided
  double adjusted = 0.0;                 ///< Holm over all bins
};

/// The factor on P in one part of the state.
struct PartFactor {
  std::string name;
  MeanInterval factor;
};

/// The factor on P with which a further run, exchangeable with these, has 95 % of its rows within their 95 %
/// ellipsoid, with probability at least 95 % (split conformal prediction over runs [Vovk 2005]): no law is
/// assumed. Of M runs the ⌈0.95 (M + 1)⌉-th smallest of their own factors. (To leave runs out and count those
/// that are covered would prove nothing: by ranks alone ⌈0.95 M⌉ of them are, whatever they hold.)
struct ConformalFactor {
  double factor = kNaN;  ///< NaN with fewer than 19 runs
  double least = kNaN;   ///< that 95 % of the runs at hand need
  std::int64_t runs = 0;
};

/// Position errors against the protection level k √λ_max(P), P(χ²(d) > k²) = risk: a bound of the claimed
/// risk of an error beyond it (Stanford diagram).
struct ProtectionLevel {
  double risk = 0.0, k = 0.0;
  std::int64_t rows = 0, beyond = 0;
  double effective_rows = 0.0;  ///< independent ones, by NEES: of rare errors no fewer
  double upper_limit = 1.0;     ///< of the risk at 95 %, Clopper-Pearson over the effective rows
  double needed_rows = 0.0;     ///< independent rows, none beyond, that would show the risk at 95 %
};

/// Rows with a position error and a claim of about these sizes (Stanford diagram).
struct StanfordCell {
  double error = 0.0, sigma = 0.0;  ///< centres: ‖e‖, √λ_max(P); m
  std::int64_t rows = 0;
};

/// NEES over n, and position errors over what is claimed, on one length of the way.
struct DistanceBin {
  double from_m = 0.0, to_m = 0.0;  ///< of the distance travelled
  std::int64_t rows = 0;
  MeanInterval nees;                    ///< over n: mean over runs; reason: fewer than five of them came here
  double p_value = 0.0;                 ///< that it is 1; NaN without a test
  double adjusted = 0.0;                ///< Holm over all bins
  double error_m = 0.0, sigma_m = 0.0;  ///< root mean squares of ‖e‖ and √tr P; 0: no position
};

struct Calibration {
  std::string units;  ///< "runs", "stretches", or "" where neither will do
  std::int64_t unit_count = 0;
  double confidence = 0.95;
  std::int64_t rows = 0;       ///< looked at: those with all states
  std::vector<SigmaBin> bins;  ///< by state, then σ
  ClaimedSigmaTest claimed_sigma;
  PartFactor whole;
  std::vector<PartFactor> parts;  ///< none where the state is one part
  /// NEES over n of units whose P was scaled by factors that the other units gave. No test that it is 1: as
  /// every unit is also among those that scale the others, the mean is 1 to first order whatever they hold.
  MeanInterval with_factor, with_part_factors;
  ConformalFactor conformal;
  std::array<ProtectionLevel, CalibrationRecorder::kRisks.size()> protection;  ///< rows 0: no position
  std::vector<StanfordCell> stanford;
  std::vector<DistanceBin> distance;  ///< none where the way is not known
};

/// layout: of the names and units of the states, as far as they have some; memory: as in CalibrationUnits.
Calibration judge_calibration(std::span<const CalibrationRun> runs, std::span<const Block> parts,
                              const RunLayout& layout, double confidence, double memory = kNaN);
inline Calibration judge_calibration(const CalibrationUnits& units, double confidence) {
  return judge_calibration(units.runs, units.parts, units.layout, confidence, units.memory);
}

/// Its name, or "x3" where it has none.
std::string state_name(std::span<const std::string> states, Index state);

/// Of the runs of one recorder.
Calibration judge_calibration(CalibrationRecorder& runs, double confidence);

/// How the factor on P of one part differs between two stacks, or versions, that met the same data.
struct FactorChange {
  std::string part;
  std::string_view on = "P";  ///< what the factor is on; or "S"
  MeanInterval ratio;         ///< of the second's factor to the first's, both means over the units
  double before = 1.0;        ///< the first's factor on the same units: their mean
  double after = 1.0;         ///< the second's
  double p_value = 0.0;       ///< that it is 1: of the differences of the units (paired_p_value)
  double adjusted = 0.0;      ///< Holm over the parts
  double p_middle = 1.0;      ///< that the mean of both factors is 1, so that both are as far from it
};

/// Which of two factors is nearer to 1.
enum class Nearness {
  open,  ///< they do not differ, or are on both sides of 1, as far as these runs tell
  nearer,
  farther,
};

/// Of the second factor: nearer or farther only where both that they differ and that 1 is not in their
/// middle are no chance at this level.
Nearness nearness_of(const FactorChange& change, double level);

/// Factors of one log, unit by unit, as the documents of `check` hold them; of stretches always tenths, so
/// that those of two logs are of the same rows.
struct UnitFactors {
  std::string units;                         ///< "runs" or "stretches"
  std::vector<std::string> names;            ///< of the units
  std::vector<std::string> parts;            ///< "NEES" and those of the state
  std::vector<std::vector<double>> factors;  ///< of each part, unit by unit
};

UnitFactors unit_factors(std::span<const CalibrationRun> runs, std::span<const Block> parts,
                         double memory = kNaN);
inline UnitFactors unit_factors(const CalibrationUnits& units) {
  return unit_factors(units.runs, units.parts, units.memory);
}

/// Of the parts and units that both have; none with fewer than two units in common.
std::vector<FactorChange> compare_factors(const UnitFactors& second, const UnitFactors& first,
                                          double confidence);

}  // namespace credence::internal
