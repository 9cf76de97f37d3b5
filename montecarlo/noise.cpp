#include "montecarlo/noise.h"

#include <stdexcept>
#include <string>

#include "montecarlo/normal_kernel.h"

namespace credence {
namespace {

constexpr std::int64_t kSlots = std::int64_t{1} << 24;
constexpr std::int64_t kSteps = (std::int64_t{1} << 32) - 3;
constexpr std::uint32_t kUniform = std::uint32_t{1} << 31;

static_assert(NoiseSource::kLanes == kNoiseLanes);

/// Output function of splitmix64 (Steele, Lea, Flood 2014), a bijection.
std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

void require_in_range(bool ok, const char* what, std::int64_t value) {
  if (!ok)
    throw std::invalid_argument(std::string("noise: ") + what + " out of range: " + std::to_string(value));
}

void check_key(std::int64_t run, std::int64_t step, std::int64_t slot, std::int64_t slots) {
  require_in_range(run >= 0, "run", run);
  require_in_range(step >= 0 && step < kSteps, "step", step);
  require_in_range(slot >= 0 && slot < kSlots, "slot", slot);
  require_in_range(slots <= kSlots - slot, "number of slots", slots);
}

NoiseBlockKey block_key(std::uint64_t key, std::int64_t run, std::int64_t word1, NoisePurpose purpose) {
  require_in_range(static_cast<std::uint32_t>(purpose) < 128, "purpose", static_cast<std::int64_t>(purpose));
  return {.key = key,
          .run = static_cast<std::uint64_t>(run),
          .word1 = static_cast<std::uint32_t>(word1),
          .purpose = static_cast<std::uint32_t>(purpose) << 24};
}

}  // namespace

NoiseSource::NoiseSource(std::uint64_t seed, std::uint64_t group, InstructionSet set)
    : key_(splitmix64(splitmix64(seed) ^ group)), kernel_(&normal_kernel(set)), set_(set) {}

void NoiseSource::normals(std::int64_t run, std::int64_t step, NoisePurpose purpose, std::span<double> out,
                          std::int64_t first_slot) const {
  const auto count = static_cast<std::int64_t>(out.size());
  check_key(run, step, first_slot, count);
  kernel_->slots(block_key(key_, run, (step + 3) / 4, purpose), static_cast<unsigned>((step + 3) % 4),
                 static_cast<std::uint32_t>(first_slot), out.data(), count);
}

void NoiseSource::normals_of_four_steps(std::int64_t run, std::int64_t first_step, NoisePurpose purpose,
                                        std::int64_t slots, std::span<double> out) const {
  check_key(run, first_step, 0, slots);
  require_in_range(first_step % 4 == 1 && first_step < kSteps - 3, "first of four steps", first_step);
  require_in_range(slots >= 0, "number of slots", slots);
  require_in_range(std::ssize(out) == 4 * slots, "size of the output", std::ssize(out));
  kernel_->steps(block_key(key_, run, (first_step + 3) / 4, purpose), 0, out.data(), slots);
}

double NoiseSource::normal(std::int64_t run, std::int64_t step, NoisePurpose purpose,
                           std::int64_t slot) const {
  double value;
  normals(run, step, purpose, {&value, 1}, slot);
  return value;
}

void NoiseSource::normals_of_runs(std::int64_t first_run, std::int64_t first_step, std::int64_t steps,
                                  NoisePurpose purpose, std::int64_t slots, std::span<double> out) const {
  check_key(first_run, first_step, 0, slots);
  require_in_range(first_run <= INT64_MAX - kLanes, "run", first_run);
  require_in_range(first_step % 4 == 1, "first of four steps", first_step);
  require_in_range(steps >= 0 && steps % 4 == 0 && steps < kSteps - first_step, "number of steps", steps);
  require_in_range(slots >= 0, "number of slots", slots);
  require_in_range(std::ssize(out) == slots * steps * kLanes, "size of the output", std::ssize(out));
  kernel_->runs(block_key(key_, first_run, (first_step + 3) / 4, purpose), steps / 4, slots, out.data());
}

double NoiseSource::uniform(std::int64_t run, std::int64_t step, NoisePurpose purpose,
                            std::int64_t slot) const {
  check_key(run, step, slot, 1);
  NoiseBlockKey block = block_key(key_, run, step, purpose);
  block.purpose += kUniform;
  std::uint64_t bits[2];
  normal_kernel_scalar()->bits(block, static_cast<std::uint32_t>(slot), bits, 1);
  return static_cast<double>(bits[0] >> 11) * 0x1p-53;
}

}  // namespace credence
