#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/calibration/calibration.h"
#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/verdicts/step_times.h"
#include "core/nan.h"
#include "reports/document/document.h"
#include "reports/render/json_numbers.h"

/// @file
/// What `credence compare` says: several judged studies side by side.

namespace credence::internal {

/// A mean and what it should be; not finite where it is not known.
struct ComparedMean {
  double mean = 0.0, expected = 0.0;
};

/// A study, or the logs of one filter, as far as it can be set beside others.
struct ComparedStudy {
  std::string name;
  std::int64_t runs = 0;
  std::string verdict;
  double p_value = kNaN;  ///< of the word; NaN where not known
  MeanInterval factor{};  ///< on P; mean NaN where not known
  ComparedMean nees{};
  std::optional<ComparedMean> pose{};
  ComparedMean nis{};

  /// What pairs its runs with those of another study: the same noise. Empty where that is not known.
  std::string noise{};
  std::vector<double>
      nees_of_runs{};  ///< NEES over its dof, run by run; empty where not known, or a run failed
  std::vector<double> nees_of_steps{}, nis_of_steps{};  ///< mean over expected value; empty where not known
  std::shared_ptr<const StepTimes> times{};             ///< of those; null where not known
  UnitFactors units{};  ///< of logs: the factors on P of parts of the state, paired by the names of files
  std::string cell{};   ///< of a configuration of a sweep: its swept values; else empty
  std::int64_t of_sweep = 0;  ///< which of the results it is of
  double confidence = kNaN;   ///< of the interval of `factor`
};

/// "filter.inflation = none, world.landmarks = 3" of swept values.
std::string cell_name(const Json& swept);

/// What study i is compared with: the first, of a configuration the one of the first result with the same
/// swept values; null where that is itself, or there is none.
const ComparedStudy* reference_of(std::span<const ComparedStudy> studies, std::size_t i);

/// From sums that are at hand.
ComparedStudy compared(const StudyAnalysis& analysis);

/// From a document of `run`, `check`, or of several studies. Throws std::invalid_argument for another one.
std::vector<ComparedStudy> compared_documents(const std::string& name, std::string_view json);

/// The mean of NEES over dof of one study minus that of another, over their common runs.
struct RunDifference {
  MeanInterval interval;
  double before = kNaN;   ///< that of the other, over these runs
  double after = kNaN;    ///< of the one
  double p_value = 1.0;   ///< that there is none
  double adjusted = 1.0;  ///< Holm over the studies
  double p_middle = 1.0;  ///< that the mean of both is 1, so that both are as far from it
};

/// As of factors, whose means these are.
Nearness nearness_of(const RunDifference& difference, double level);

/// Of `study` minus `reference`: both met the same noise, so that what they share cancels. Nothing where they
/// did not, or fewer than two runs can be paired.
std::optional<RunDifference> paired_difference(const ComparedStudy& study, const ComparedStudy& reference,
                                               double confidence);

/// Of every study minus its reference; nothing for the first itself.
std::vector<std::optional<RunDifference>> differences_from_first(std::span<const ComparedStudy> studies,
                                                                 double confidence);

/// Of factors on P against those of the reference, study by study: of the units of logs, and of
/// configurations of sweeps that cannot be paired run by run from the intervals of both ([Zou 2008], as of
/// independent runs). Holm over all studies and parts.
std::vector<std::vector<FactorChange>> changes_from_first(std::span<const ComparedStudy> studies,
                                                          double confidence);

/// The JSON of a comparison (docs/formats.md).
std::string comparison_json(std::span<const ComparedStudy> studies, double confidence);

/// That of a verdict by its name.
CellTone verdict_tone(const std::string& verdict);

/// "1.06 (1.02 … 1.11)"; a dash where the mean is not known.
std::string mean_interval_text(const MeanInterval& interval);

/// |log| of the factor on P.
double factor_distance(const ComparedStudy& study);

/// What `credence compare` says (JSON: docs/formats.md): which studies cannot be trusted, whose factor on P
/// is nearest to one, NEES and NIS step by step, and what each differs by from the first.
Document comparison_document(const std::vector<ComparedStudy>& studies, double confidence);

}  // namespace credence::internal
