#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/logs/conventions/pose_readings.h"
#include "datasets/logs/conventions/reading_fit.h"
#include "datasets/logs/log_sink.h"
#include "datasets/logs/trajectory_errors.h"

namespace credence::internal {

/// Looks whether a log of poses that does not fit its covariance would fit if it were read in another way:
/// in another chart, with one of the mistakes of pose_readings.h undone, or at other times (time_readings.h).
///
/// Keeps at most 4096 of the rows, evenly spread. What is said is a hint and no verdict: a verdict belongs
/// to the chart that was declared, before the log was looked at.
class ConventionCheck {
 public:
  /// charts_asked: the NEES in every chart is to be told, whether they differ or not.
  ConventionCheck(const PoseChart& declared, bool charts_asked)
      : declared_(declared), charts_asked_(charts_asked) {}

  /// Whether an estimate with these components, ascending, has all that are looked at.
  bool takes(std::span<const Index> estimated) const;
  /// Takes one, position first in its covariance, and its truth in the axes of the declared chart.
  void add(const PoseEstimate& estimate, const UncertainPose& truth);

  /// Says what there is to say, with the truth that the samples were compared with.
  void tell(const TruthComparison& truth, LogSink& sink) const;

 private:
  /// A reading of the samples, or of some at other times.
  struct Candidate {
    PoseReading reading;
    std::optional<std::vector<PoseSample>> moved{};
  };
  std::span<const Index> components() const { return estimated_components(declared_.axes); }
  Index dim() const { return std::ssize(components()); }
  const std::vector<PoseSample>& samples_of(const Candidate& candidate) const {
    return candidate.moved ? *candidate.moved : samples_;
  }
  /// What fit_reading asks for; it refers to the candidate.
  ReadingRow rows_of(const Candidate& candidate) const;
  ReadingFit fit(const Candidate& candidate) const;
  std::optional<ReadingFit> fitting(const Candidate& candidate) const;
  ChartFindings charts() const;
  std::string charts_text(const ChartFindings& findings) const;
  std::string mistakes(const ReadingFit& declared, const TruthComparison& truth) const;
  /// Where no reading passes the tests, perhaps as they cannot be made: of a NEES that is a hundred times too
  /// large the likeliest reading in which it is right within a factor of 4.
  std::string likely_mistake(const ReadingFit& declared, std::span<const Candidate> candidates) const;
  std::vector<Candidate> candidates(const TruthComparison& truth) const;
  double spacing() const;

  PoseChart declared_;
  bool charts_asked_;
  std::vector<PoseSample> samples_;
  std::size_t stride_ = 1, seen_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0;
};

}  // namespace credence::internal
