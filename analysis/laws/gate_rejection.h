#pragma once

#include <optional>
#include <vector>

#include "montecarlo/engine/moments.h"

/// @file
/// Whether a filter rejects what lies beyond a gate, although its log has it: P then shrinks where NIS is
/// small and does not where it is large.
///
/// Of a filter that uses what it logs, NIS of a step is independent of how log det P changes over that step,
/// which P, H and R of the step alone make; so it is where Q, R or P0 is wrong.

namespace credence::internal {

/// The changes of log det P over the steps, sorted by how far out in its law the NIS of the step lies.
struct ChangesByNis {
  static constexpr int kBinsPerOctave = 4, kBins = 64;

  std::vector<Moments> bins{};  ///< the b-th: survival in (2^{−(b+1)/4}, 2^{−b/4}]; empty, or kBins

  /// survival: P(χ² > NIS).
  void add(double survival, double change);
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
