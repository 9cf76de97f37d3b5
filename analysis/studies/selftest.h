#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/evidence/causes/advice_cause.h"
#include "analysis/evidence/verdicts/judgement.h"
#include "analysis/laws/mean/student.h"
#include "analysis/laws/shape/coverage.h"

/// @file
/// Calibration is the proof: every test that the product makes, on exact and on deliberately wrong synthetic
/// filters.
///
/// The false-alarm rate of a test is the share of studies of an exact filter that it rejects. All rows are
/// judged together: each rate has the interval of Clopper and Pearson at a confidence of 1 − 0.001 / rows,
/// and a row fails when the whole interval lies above the level of the test, or for one that is not
/// conservative, below. With calibrated tests any row of a selftest fails with at most 0.1 % probability.

namespace credence::internal {

class Ranks;

/// What to run.
struct SelftestOptions {
  std::int64_t studies = 2000;  ///< for each false-alarm rate; a tenth of it for each wrong filter
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one for each processor; the result does not depend on it
  const std::atomic<bool>* stop = nullptr;
  /// Called with the parts done and all parts, by one thread at a time.
  std::function<void(std::int64_t done, std::int64_t total)> progress{};
  Ranks* ranks =
      nullptr;  ///< share the studies among these; on others than rank 0 the result is not complete
};

/// A share of studies with its interval.
struct StudyShare {
  CoverageCount count = {};
  ProportionInterval interval = {};  ///< at interval_confidence of the selftest
};

/// The false-alarm rate of one test at one level.
struct CalibrationRow {
  std::string name;
  Exactness exactness = Exactness::exact;
  double nominal = 0.0;
  StudyShare measured = {};
  bool ok = false;
};

/// What is often done instead, with its false-alarm rate: shown, not used.
struct NaiveRow {
  std::string name, instead;
  double nominal = 0.0;
  StudyShare measured = {};
};

/// The share of studies of a wrong filter that a test rejects.
struct PowerRow {
  std::string test;
  StudyShare measured = {};
};

/// A cause and the share of studies in which the advice named it first.
struct CauseShare {
  Cause cause = Cause::outliers;
  double share = 0.0;
};

/// A filter that is wrong on purpose.
struct WrongFilterResult {
  std::string name;
  StudyShare caught = {};  ///< by the word
  double caught_wanted = 0.0;
  double caught_most = 1.0;               ///< below 1: P is right, and only so many may be accused
  std::optional<Verdict> direction = {};  ///< where there is only one
  StudyShare direction_right = {};        ///< of the studies caught
  std::vector<PowerRow> power = {};       ///< of every test, at the same level
  Cause expected = Cause::outliers;
  StudyShare named = {};  ///< studies in which the advice names the right cause first
  double named_wanted = 0.0;
  std::vector<CauseShare> causes = {};  ///< all that were named first, the most frequent first
  bool ok = false;
};

/// What stopping by verdict saves on a filter that is clearly wrong.
struct SavingResult {
  std::string name;
  std::int64_t max_runs = 0;  ///< of the fixed plan
  MeanInterval runs;          ///< when it stopped
  StudyShare caught = {};
};

struct SelftestResult {
  std::uint64_t seed = 0;
  std::int64_t studies = 0, wrong_filter_studies = 0;
  int runs = 0, wrong_filter_runs = 0;  ///< of each study
  int steps = 0;
  double family_level = 0.0;         ///< P(any row fails) when all is well, at most
  double interval_confidence = 0.0;  ///< of each interval
  double power_level = 0.05;
  bool complete = false;  ///< false: stopped, and nothing below can be used
  bool ok = false;        ///< every row is
  std::vector<CalibrationRow> calibration = {};
  std::vector<NaiveRow> naive = {};
  std::vector<WrongFilterResult> wrong_filters = {};
  std::vector<SavingResult> savings = {};
};

/// Fills in the intervals, `ok` of every row and of the whole, and what they rest on, from the counts.
void judge_selftest(SelftestResult& result);

/// Runs the calibration; rows come in a fixed order. Throws std::invalid_argument unless studies ≥ 100 and
/// threads ≥ 0. Cost: about 0.1 s of one core for each of `studies`, played for every kind of test and
/// filter.
SelftestResult run_selftest(const SelftestOptions& options);

}  // namespace credence::internal
