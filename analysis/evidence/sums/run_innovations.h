#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "analysis/evidence/sums/evidence.h"
#include "analysis/laws/gate_rejection.h"
#include "core/record/normalised_step.h"
#include "core/record/run_layout.h"

namespace credence::internal {

/// The normalised innovations of one sensor over a run, which are looked at once it has ended: whether they
/// are white, of their law, and cut by a gate can only then be seen.
class RunInnovations {
 public:
  /// Another run, which has no step yet.
  void begin_run();
  /// The next step, which has an innovation or none.
  void begin_step() { begins_.push_back(values_.size()); }
  /// That of the step. change: of log det P over the step, from `before`; NaN where not known.
  void add(const Sensor& sensor, const NormalisedInnovation& innovation, double change, double before);

  std::size_t steps() const { return begins_.size(); }
  /// The whitened innovation of a step; empty where there was none.
  std::span<const double> at(std::size_t k) const;

  /// Adds it to the sums of the sensor. seen: of each step what ChangesOfRun::add takes.
  void add_to(const Sensor& sensor, std::span<const std::size_t> seen, SensorSums& sums) const;

 private:
  struct Nis {
    double value = 0.0;
    Index dof = 0;
    double noise_share = 0.0;
    double change = 0.0, before = 0.0;  ///< of log det P, and it
  };

  /// Innovations of the first fifth of the run.
  std::size_t early() const;
  /// The steps looked at for whiteness: every so many from the first on.
  struct Settled {
    std::size_t first = 0, interval = 1;
  };
  Settled settled() const;
  void add_law(std::span<const std::size_t> seen, SensorSums& sums) const;
  /// The changes of log det P at all innovations but so many early ones, which may be compared.
  ChangesOfRun::Comparable comparable_changes(std::span<const std::size_t> seen, std::size_t early) const;
  void add_scalars(const Sensor& sensor, const Settled& settled, SensorSums& sums) const;
  void add_pieces(const Sensor& sensor, const Settled& settled, SensorSums& sums) const;
  void add_components(const Settled& settled, SensorSums& sums) const;
  /// Of each component, and then of each pair, of the pieces of an innovation.
  void add_squares(const Sensor& sensor, const NormalisedInnovation& innovation);

  std::vector<Nis> nis_;        ///< of the steps with a measurement
  std::vector<double> values_;  ///< whitened, one after the other
  /// Of each piece, where they can be taken apart: ν_i²/S_ii of its components, then the squares of its pairs
  /// (SensorSums::pairs); NaN for a pair that S holds for one.
  std::vector<double> squares_;
  std::vector<std::size_t> begins_;  ///< of each step in `values_`
  bool pieces_ = true;               ///< all of them can be taken apart
};

inline constexpr Index kMostPairedSensors = 64;  ///< of more no pairs are looked at

/// Adds the innovations of all sensors of a run, and of every two of them together.
void add_innovations_of_run(std::span<const RunInnovations> sensors, const RunLayout& layout, Evidence& sums);

}  // namespace credence::internal
