#pragma once

#include <cstdint>
#include <span>

#include "core/simd/cpu_dispatch.h"
#include "montecarlo/random/noise_shape.h"

/// @file
/// Random numbers as a pure function of what they are for: no state, no order of drawing, no worker.
///
/// A key names one number: (seed, noise group, run, step, purpose, slot). Philox4x32-10 ([Salmon 2011])
/// encrypts it:
///
///   key      64 bits: splitmix64(splitmix64(seed) ^ group), low word first, where splitmix64 is the output
///            function of [Steele 2014], a bijection: no two groups of one seed share a key
///   counter  word 0  run, low 32 bits
///            word 1  (step + 3) / 4 for normals and events, step for uniforms
///            word 2  slot (bits 0-23), purpose (bits 24-29), 1 for events (bit 30), 1 for uniforms (bit 31)
///            word 3  run, high 32 bits
///
/// One block of 128 bits gives two Box–Muller pairs: the normals of the steps 4t − 3 … 4t of one slot. (Pairs
/// over steps and not over slots waste no normal, however few slots a model has.) Of the 64 bits of a pair
/// with the bytes B7 … B0 the radius takes B7 B6 … as a binary fraction of 52 bits, the angle the low half of
/// B0, then B1 B2 …, 52 bits too; bits 7 and 6 of B0 are a sign and the order of the pair. Radius and angle
/// so share only bits that are worth less than 2^−28 in at least one of them.
///
/// The events of the steps 4t − 3 … 4t of one slot are the words 0 … 3 of a block: an event of probability p
/// happens where its word is below p 2^32, rounded up.
///
/// Logarithm, sine and cosine are polynomials with explicit fused multiply-adds, no library function: a
/// number has the same bits on every machine and at every SIMD width. The normals are within 4 ulp of the
/// exact function of their bits, never infinite, and reach 8.57 standard deviations.

namespace credence::internal {

struct NormalKernel;

}  // namespace credence::internal

namespace credence {

/// What a random number is for; part of its key. At most 64 purposes.
enum class NoisePurpose : std::uint32_t {
  initial = 0,      ///< error of the initial state, step 0
  process = 1,      ///< process noise of the step that ends at `step`
  measurement = 2,  ///< measurement noise at `step`
  world = 3,        ///< layout of the world: landmarks, paths
  decision = 4,     ///< what a study decides at random: resampling, permutations
  detection = 5,    ///< whether the sensor sees what it could see at `step`
  tail = 6,         ///< tails and outliers of the noise at `step` (noise_shape.h)
};

/// Standard normals, and uniforms, as a pure function of (seed, noise group, run, step, purpose, slot).
///
/// Process and measurement noise may have another shape than white and Gaussian (noise_shape.h); every way to
/// a number of these purposes then gives the shaped one, slower.
///
/// Cheap to copy, safe to share between threads. All functions throw std::invalid_argument unless
/// 0 <= run, 0 <= step < 2^32 − 3 and 0 <= slot < 2^24.
class NoiseSource {
 public:
  /// `group` names what shares its noise: two filters under test in one noise group see the same noise.
  /// `set` changes the speed alone; throws std::invalid_argument if this machine does not support it.
  NoiseSource(std::uint64_t seed, std::uint64_t group,
              internal::InstructionSet set = internal::best_instruction_set());

  /// The same source with noise of these shapes. Throws std::invalid_argument for a shape that cannot be.
  NoiseSource shaped(const NoiseShape& process, const NoiseShape& measurement) const;

  const NoiseShape& process_shape() const { return process_; }
  const NoiseShape& measurement_shape() const { return measurement_; }
  /// Whether all of its noise is white and Gaussian.
  bool is_plain() const { return process_.is_plain() && measurement_.is_plain(); }

  /// out[i] = the standard normal of slot first_slot + i.
  void normals(std::int64_t run, std::int64_t step, NoisePurpose purpose, std::span<double> out,
               std::int64_t first_slot = 0) const;

  /// Four steps at once, for little more than one: out[(step − first_step) · slots + slot], from slot 0 on.
  /// Throws std::invalid_argument unless first_step mod 4 = 1 and `out` has 4 · slots entries.
  void normals_of_four_steps(std::int64_t run, std::int64_t first_step, NoisePurpose purpose,
                             std::int64_t slots, std::span<double> out) const;

  /// The standard normal of one slot. Several slots are cheaper together.
  double normal(std::int64_t run, std::int64_t step, NoisePurpose purpose, std::int64_t slot) const;

  /// Runs that normals_of_runs does side by side.
  static constexpr int kLanes = 32;

  /// The fastest way to many normals, for runs first_run … first_run + kLanes − 1 and the steps first_step …
  /// first_step + steps − 1: out[(slot · steps + k) · kLanes + lane] = the normal of slot `slot`, step
  /// first_step + k, run first_run + lane. Steps come in fours: throws std::invalid_argument unless
  /// first_step mod 4 = 1, `steps` is a multiple of 4 and `out` has slots · steps · kLanes entries.
  void normals_of_runs(std::int64_t first_run, std::int64_t first_step, std::int64_t steps,
                       NoisePurpose purpose, std::int64_t slots, std::span<double> out) const;

  /// Events of probability `probability` in [0, 1], laid out as normals_of_four_steps does: 1 where one
  /// happens, 0 elsewhere. Independent of all normals and uniforms. Throws as that does, and for another
  /// probability.
  void events_of_four_steps(std::int64_t run, std::int64_t first_step, NoisePurpose purpose,
                            double probability, std::int64_t slots, std::span<double> out) const;

  /// The same events laid out, and with the errors, as normals_of_runs.
  void events_of_runs(std::int64_t first_run, std::int64_t first_step, std::int64_t steps,
                      NoisePurpose purpose, double probability, std::int64_t slots,
                      std::span<double> out) const;

  /// A uniform number in [0, 1), a multiple of 2^−53; independent of the normal that has the same key.
  double uniform(std::int64_t run, std::int64_t step, NoisePurpose purpose, std::int64_t slot) const;

  /// The 64-bit Philox key of seed and group.
  std::uint64_t key() const { return key_; }

  /// The instruction set of its kernels.
  internal::InstructionSet instruction_set() const { return set_; }

 private:
  /// The shape of a purpose that has one which is not plain, else null.
  const NoiseShape* shape_of(NoisePurpose purpose) const;
  NoiseSource plain() const;

  std::uint64_t key_;
  const internal::NormalKernel* kernel_;
  internal::InstructionSet set_;
  NoiseShape process_, measurement_;
};

}  // namespace credence
