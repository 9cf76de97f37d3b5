#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "montecarlo/engine/moments.h"

/// @file
/// Whether a filter rejects what lies beyond a gate, although its log has it: P then shrinks where NIS is
/// small and does not where it is large.
///
/// Of a filter that uses what it logs, NIS of a step is independent of how log det P changes over that step,
/// which P, H and R of the step alone make; so it is where Q, R or P0 is wrong and all steps are alike. Where
/// sensors come and go they are not: after a sensor of a wrong R P is smaller, changes less, and the NIS of
/// the others is larger. Changes are then compared at steps of the same sensors, less what log det P before
/// the step explains of them.

namespace credence::internal {

/// The changes of log det P over the steps of one run at which a sensor speaks.
class ChangesOfRun {
 public:
  /// seen: a number that is the same at steps with as many components of each sensor, and no others.
  void add(std::size_t seen, double before, double change);

  struct Comparable {
    std::vector<double> changes;  ///< of each step in their order
    double variance = 0.0;        ///< of what was taken out of them
  };
  /// The changes as they are where all steps see the same. Else less their mean over the steps that see the
  /// same, and less their regression, over all steps, on log det P before the step less its mean likewise;
  /// NaN where fewer than four steps see the same.
  Comparable comparable() const;

 private:
  struct Step {
    std::size_t seen = 0;
    double before = 0.0, change = 0.0;
  };
  std::vector<Step> steps_;
};

/// The changes of log det P over the steps, sorted by how far out in its law the NIS of the step lies.
struct ChangesByNis {
  static constexpr int kBinsPerOctave = 4, kBins = 64;

  std::vector<Moments> bins{};  ///< the b-th: survival in (2^{−(b+1)/4}, 2^{−b/4}]; empty, or kBins

  /// survival: P(χ² > NIS). taken: a variance that counts as if the change had it still, so that a step is
  /// measured by all that changes vary by.
  void add(double survival, double change, double taken = 0.0);
  void merge(const ChangesByNis& later);
};

/// A gate beyond which innovations are not used.
struct GateRejection {
  double expected = 0.0;  ///< share of the innovations beyond it, by their law
  double share = 0.0;     ///< that lie beyond it
  double p_value = 0.0;   ///< that the changes on its two sides have one mean (Welch's t, Bonferroni)
};

/// The gate that tells most of the changes apart, where log det P falls less beyond it by half a standard
/// deviation of the others or more; none with fewer than eight innovations on either side, and none where a
/// straight line over the bins explains the changes as well as the step at the gate, as of filters whose P
/// grows with NIS (several models, adaptive noise). O(kBins).
std::optional<GateRejection> find_gate_rejection(const ChangesByNis& changes);

}  // namespace credence::internal
