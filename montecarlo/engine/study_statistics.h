#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "montecarlo/engine/moments.h"
#include "montecarlo/engine/run_averages.h"

/// @file
/// What is accumulated over the runs of one configuration, and nothing else: sums that add up. Verdicts and
/// reports derive the rest.

namespace credence {

/// How a run ended.
enum class Outcome : std::uint32_t {
  ok,
  diverged,               ///< the estimate was not finite, or farther off than the world is wide
  not_positive_definite,  ///< a Cholesky factorisation of P or S failed
  threw,                  ///< the filter under test threw an exception
};

/// "ok", "diverged", "not_positive_definite" or "threw".
std::string_view to_string(Outcome outcome);

/// A run that did not end well, and the step (from 1) at which that was seen; it counts up to the step
/// before.
struct RunFailure {
  std::int64_t run = 0;
  std::int64_t step = 0;
  Outcome outcome = Outcome::ok;

  bool operator==(const RunFailure&) const = default;
};

/// A run in which an iteration of the filter ended before it had settled (UpdateResult::converged).
struct RunNotConverged {
  std::int64_t run = 0;
  std::int64_t steps = 0;  ///< in so many of those that count

  bool operator==(const RunNotConverged&) const = default;
};

/// A number that every run has at every step.
enum class Quantity : std::size_t {
  nees,                    ///< eᵀ P⁻¹ e after the update
  nis,                     ///< νᵀ S⁻¹ ν
  vehicle_nees,            ///< of the vehicle's block
  trace_prior,             ///< tr P before the update, after the inflation
  trace,                   ///< tr P after the update
  trace_vehicle,           ///< its position part
  trace_landmarks,         ///< its map part
  position_error_squared,  ///< m²
  heading_error_squared,   ///< rad²
  landmark_error_squared,  ///< m², mean over the landmarks in the state
  heading_variance,        ///< rad², of P
  landmark_variance,       ///< m², of P, mean over the landmarks in the state
  count_,
};

/// One step over all runs. Dimensions may vary from run to run, so their sums are kept.
struct StepStatistics {
  std::array<Moments, static_cast<std::size_t>(Quantity::count_)> quantities;
  std::int64_t nees_dof = 0;  ///< sum over runs
  std::int64_t nis_dof = 0;

  Moments& operator[](Quantity q) { return quantities[static_cast<std::size_t>(q)]; }
  const Moments& operator[](Quantity q) const { return quantities[static_cast<std::size_t>(q)]; }
  void merge(const StepStatistics& other);

  bool operator==(const StepStatistics&) const = default;
};

/// All runs of a chunk, or of a whole configuration.
struct StudyStatistics {
  std::vector<StepStatistics> steps;             ///< step k is steps[k − 1]
  internal::RunAverages nees_of_runs;            ///< of the whole state
  internal::RunAverages vehicle_nees_of_runs;    ///< of the pose, where the world has one
  std::vector<RunFailure> failures;              ///< in order of the run
  std::vector<RunNotConverged> not_converged{};  ///< in order of the run; those with such steps
  std::int64_t runs = 0;                         ///< started, failed ones included

  /// Adds the runs of `other`, which come after the runs here. Throws std::invalid_argument if the number of
  /// steps differs.
  void merge(const StudyStatistics& other);

  /// Memory for the averages of so many runs.
  void reserve_runs(std::int64_t count) {
    nees_of_runs.reserve(count);
    vehicle_nees_of_runs.reserve(count);
  }

  std::int64_t count(Outcome outcome) const;

  /// The moments of one quantity at every step.
  std::vector<Moments> series(Quantity quantity) const;

  /// The dof of all runs together at every step, of nees or nis; throws std::invalid_argument for another.
  std::vector<double> dofs(Quantity quantity) const;

  bool operator==(const StudyStatistics&) const = default;
};

/// What is summed over one run on its way: NEES of the whole state, and of the vehicle where there is one.
struct RunTotals {
  internal::RunSum whole, vehicle;
  std::int64_t not_converged = 0;  ///< steps

  /// Adds run `run`; one that failed has no averages.
  void add_to(StudyStatistics& statistics, std::int64_t run, bool failed) const {
    if (not_converged > 0) statistics.not_converged.push_back({run, not_converged});
    if (failed) return;
    whole.add_to(statistics.nees_of_runs);
    vehicle.add_to(statistics.vehicle_nees_of_runs);
  }
};

}  // namespace credence

namespace credence::internal {

inline constexpr std::array kOutcomes = {Outcome::ok, Outcome::diverged, Outcome::not_positive_definite,
                                         Outcome::threw};

/// "2 of 6 runs failed", or "the only run failed".
std::string failed_text(std::int64_t failed, std::int64_t all);

/// In what those that failed count: "It counts up to the step before", or in single steps alone.
std::string what_failed_count_in(std::int64_t failed, std::int64_t all);

/// The one of that name; nothing for another word.
std::optional<Outcome> outcome_named(std::string_view word);

/// Bytes that a result store needs for a chunk of so many steps, at most.
double most_stored_bytes(std::int64_t steps, std::int64_t runs);

/// The bytes that a result store keeps; little-endian, exact.
std::vector<std::byte> to_bytes(const StudyStatistics& statistics);

/// Reads them back; throws std::runtime_error for bytes that are none of ours.
StudyStatistics statistics_from_bytes(std::span<const std::byte> bytes);

}  // namespace credence::internal
