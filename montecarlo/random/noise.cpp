#include "montecarlo/random/noise.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "montecarlo/random/normal_kernel.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kSlots = std::int64_t{1} << 24;
constexpr std::int64_t kNoiseSteps = (std::int64_t{1} << 32) - 3;
constexpr std::uint32_t kEvent = std::uint32_t{1} << 30, kUniform = std::uint32_t{1} << 31;

static_assert(NoiseSource::kLanes == kNoiseLanes);

/// Output function of splitmix64 ([Steele 2014]), a bijection.
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
  require_in_range(step >= 0 && step < kNoiseSteps, "step", step);
  require_in_range(slot >= 0 && slot < kSlots, "slot", slot);
  require_in_range(slots <= kSlots - slot, "number of slots", slots);
}

NoiseBlockKey block_key(std::uint64_t key, std::int64_t run, std::int64_t word1, NoisePurpose purpose) {
  require_in_range(static_cast<std::uint32_t>(purpose) < 64, "purpose", static_cast<std::int64_t>(purpose));
  return {.key = key,
          .run = static_cast<std::uint64_t>(run),
          .word1 = static_cast<std::uint32_t>(word1),
          .purpose = static_cast<std::uint32_t>(purpose) << 24};
}

void check_four_steps(std::int64_t run, std::int64_t first_step, std::int64_t slots,
                      std::span<const double> out) {
  check_key(run, first_step, 0, slots);
  require_in_range(first_step % 4 == 1 && first_step < kNoiseSteps - 3, "first of four steps", first_step);
  require_in_range(slots >= 0, "number of slots", slots);
  require_in_range(std::ssize(out) == 4 * slots, "size of the output", std::ssize(out));
}

void check_runs(std::int64_t first_run, std::int64_t first_step, std::int64_t steps, std::int64_t slots,
                std::span<const double> out) {
  check_key(first_run, first_step, 0, slots);
  require_in_range(first_run <= INT64_MAX - kNoiseLanes, "run", first_run);
  require_in_range(first_step % 4 == 1, "first of four steps", first_step);
  require_in_range(steps >= 0 && steps % 4 == 0 && steps < kNoiseSteps - first_step, "number of steps",
                   steps);
  require_in_range(slots >= 0, "number of slots", slots);
  require_in_range(std::ssize(out) == slots * steps * kNoiseLanes, "size of the output", std::ssize(out));
}

/// The number below which a word of 32 bits means an event.
std::uint64_t threshold_of(double probability) {
  if (!(probability >= 0.0 && probability <= 1.0)) {
    throw std::invalid_argument("noise: probability out of range: " + std::to_string(probability));
  }
  return static_cast<std::uint64_t>(std::ceil(probability * 0x1p32));
}

/// 1 if the word is below the threshold, else 0.
double event(std::uint64_t word, std::uint64_t threshold) {
  return static_cast<double>(static_cast<std::int32_t>((word - threshold) >> 63));
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

NoiseSource::NoiseSource(std::uint64_t seed, std::uint64_t group, InstructionSet set)
    : key_(splitmix64(splitmix64(seed) ^ group)), kernel_(&normal_kernel(set)), set_(set) {}

NoiseSource NoiseSource::shaped(const NoiseShape& process, const NoiseShape& measurement) const {
  check_noise_shape(process);
  check_noise_shape(measurement);
  NoiseSource result = *this;
  result.process_ = process;
  result.measurement_ = measurement;
  return result;
}

NoiseSource NoiseSource::plain() const {
  NoiseSource result = *this;
  result.process_ = result.measurement_ = {};
  return result;
}

const NoiseShape* NoiseSource::shape_of(NoisePurpose purpose) const {
  if (purpose == NoisePurpose::process && !process_.is_plain()) return &process_;
  if (purpose == NoisePurpose::measurement && !measurement_.is_plain()) return &measurement_;
  return nullptr;
}

void NoiseSource::normals(std::int64_t run, std::int64_t step, NoisePurpose purpose, std::span<double> out,
                          std::int64_t first_slot) const {
  const auto count = static_cast<std::int64_t>(out.size());
  check_key(run, step, first_slot, count);
  if (const NoiseShape* shape = shape_of(purpose)) {
    return shaped_normals(plain(), *shape, run, step, purpose, first_slot, count, out);
  }
  kernel_->slots(block_key(key_, run, (step + 3) / 4, purpose), static_cast<unsigned>((step + 3) % 4),
                 static_cast<std::uint32_t>(first_slot), out.data(), count);
}

void NoiseSource::normals_of_four_steps(std::int64_t run, std::int64_t first_step, NoisePurpose purpose,
                                        std::int64_t slots, std::span<double> out) const {
  check_four_steps(run, first_step, slots, out);
  if (const NoiseShape* shape = shape_of(purpose)) {
    return shaped_normals(plain(), *shape, run, first_step, purpose, 0, slots, out);
  }
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
  check_runs(first_run, first_step, steps, slots, out);
  if (const NoiseShape* shape = shape_of(purpose)) {
    std::vector<double> of_run(static_cast<std::size_t>(slots * steps));
    for (std::int64_t lane = 0; lane < kLanes; ++lane) {
      shaped_normals(plain(), *shape, first_run + lane, first_step, purpose, 0, slots, of_run);
      for (std::int64_t k = 0; k < steps; ++k) {
        for (std::int64_t slot = 0; slot < slots; ++slot) {
          out[static_cast<std::size_t>((slot * steps + k) * kLanes + lane)] =
              of_run[static_cast<std::size_t>(k * slots + slot)];
        }
      }
    }
    return;
  }
  kernel_->runs(block_key(key_, first_run, (first_step + 3) / 4, purpose), steps / 4, slots, out.data());
}

void NoiseSource::events_of_four_steps(std::int64_t run, std::int64_t first_step, NoisePurpose purpose,
                                       double probability, std::int64_t slots, std::span<double> out) const {
  check_four_steps(run, first_step, slots, out);
  const std::uint64_t threshold = threshold_of(probability);
  NoiseBlockKey block = block_key(key_, run, (first_step + 3) / 4, purpose);
  block.purpose += kEvent;
  constexpr std::int64_t kAtOnce = 32;
  std::uint64_t bits[2 * kAtOnce];
  for (std::int64_t first = 0; first < slots; first += kAtOnce) {
    const std::int64_t count = std::min(kAtOnce, slots - first);
    kernel_->bits(block, static_cast<std::uint32_t>(first), bits, count);
    for (std::int64_t i = 0; i < count; ++i) {
      for (std::int64_t quarter = 0; quarter < 4; ++quarter) {
        const std::uint64_t pair = bits[2 * i + quarter / 2];
        const std::uint64_t word = quarter % 2 == 0 ? pair >> 32 : pair & 0xffffffffU;
        out[static_cast<std::size_t>(quarter * slots + first + i)] = event(word, threshold);
      }
    }
  }
}

void NoiseSource::events_of_runs(std::int64_t first_run, std::int64_t first_step, std::int64_t steps,
                                 NoisePurpose purpose, double probability, std::int64_t slots,
                                 std::span<double> out) const {
  check_runs(first_run, first_step, steps, slots, out);
  const std::uint64_t threshold = threshold_of(probability);
  NoiseBlockKey block = block_key(key_, first_run, (first_step + 3) / 4, purpose);
  block.purpose += kEvent;
  constexpr std::int64_t kAtOnce = 8;
  std::uint64_t bits[2 * kAtOnce * kLanes];
  double* to = out.data();
  for (std::int64_t slot = 0; slot < slots; ++slot, ++block.purpose) {
    NoiseBlockKey at = block;
    for (std::int64_t left = steps / 4; left > 0; left -= kAtOnce, at.word1 += kAtOnce) {
      const std::int64_t groups = std::min(kAtOnce, left);
      kernel_->run_bits(at, groups, bits);
      for (std::int64_t pair = 0; pair < 2 * groups; ++pair, to += 2 * kLanes) {
        const std::uint64_t* words = bits + pair * kLanes;
        for (int lane = 0; lane < kLanes; ++lane) to[lane] = event(words[lane] >> 32, threshold);
        for (int lane = 0; lane < kLanes; ++lane) {
          to[kLanes + lane] = event(words[lane] & 0xffffffffU, threshold);
        }
      }
    }
  }
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
