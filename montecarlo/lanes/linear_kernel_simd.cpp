#include "montecarlo/lanes/linear_kernel_plan.h"

#include "core/simd/kernel_set.h"
#include "montecarlo/random/normal_kernel.h"

namespace credence::internal {
namespace {

#include "montecarlo/random/normal_kernel_pack.inc"
//
#include "montecarlo/random/normal_kernel_body.inc"

// The filter in lanes: noise of a block of steps into a buffer, then the steps. Arrays of a tile are
// [row][kNoiseLanes].

/// Runs of one tile that count: all, or the first few of a last tile.
template <bool kPartial>
struct ActiveLanes {
  alignas(64) double mask[kPartial ? kNoiseLanes : 1];  ///< all bits set or none

  explicit ActiveLanes(std::int64_t active) {
    if constexpr (kPartial) {
      for (int i = 0; i < kNoiseLanes; ++i) {
        const std::uint64_t bits = i < active ? ~std::uint64_t{0} : 0;
        __builtin_memcpy(mask + i, &bits, sizeof bits);
      }
    }
  }
  Pack::D operator()(Pack::D x, int lane) const {
    if constexpr (kPartial) return Pack::mask(x, Pack::load(mask + lane));
    return x;
  }
};

/// Adds one pack of deviations d = NEES − centre, or of NIS, to Σ d and Σ d².
template <bool kPartial>
inline void add_to_sums(Pack::D deviation, const ActiveLanes<kPartial>& active, int lane, double* sums) {
  const Pack::D d = active(deviation, lane);
  double* first = sums + lane % kAccumulators;
  double* second = first + kAccumulators;
  Pack::store(first, Pack::add(Pack::load(first), d));
  Pack::store(second, Pack::fma(d, d, Pack::load(second)));
}

// ---- any linear system
// ------------------------------------------------------------------------------------------

constexpr int kRows = Pack::kLanes == 8 ? 4 : Pack::kLanes == 4 ? 2 : 1;  ///< rows that share what they load
constexpr int kPacks = 4;                                                 ///< packs of lanes side by side
constexpr int kStride = kPacks * Pack::kLanes;

/// y[row] = (add ? y[row] : 0) + M x, for all lanes; the rows of x are `stride` apart.
inline void multiply(const SparseRows& matrix, std::int32_t rows, const double* x, std::int64_t stride,
                     bool add, double* y) {
  for (std::int32_t row = 0; row < rows; ++row) {
    if (add && matrix.row_start[row] == matrix.row_start[row + 1]) continue;
    for (int lane = 0; lane < kNoiseLanes; lane += kStride) {
      double* out = y + row * kNoiseLanes + lane;
      Pack::D sum[kPacks];
      for (int i = 0; i < kPacks; ++i)
        sum[i] = add ? Pack::load(out + i * Pack::kLanes) : Pack::broadcast(0.0);
      for (std::int32_t j = matrix.row_start[row]; j < matrix.row_start[row + 1]; ++j) {
        const Pack::D a = Pack::broadcast(matrix.value[j]);
        const double* in = x + matrix.column[j] * stride + lane;
        for (int i = 0; i < kPacks; ++i) sum[i] = Pack::fma(a, Pack::load(in + i * Pack::kLanes), sum[i]);
      }
      for (int i = 0; i < kPacks; ++i) Pack::store(out + i * Pack::kLanes, sum[i]);
    }
  }
}

/// sum[r] ± M[row + r] x over the columns begin … end − 1, for kPacks packs of lanes.
template <int kCount, bool kMinus>
inline void add_columns(const DenseRows& matrix, std::int32_t row, std::int32_t begin, std::int32_t end,
                        const double* x, Pack::D (*sum)[kPacks]) {
  const double* value = matrix.value + std::int64_t{row} * matrix.columns;
  for (std::int32_t j = begin; j < end; ++j) {
    Pack::D in[kPacks];
    for (int i = 0; i < kPacks; ++i) in[i] = Pack::load(x + std::int64_t{j} * kNoiseLanes + i * Pack::kLanes);
    for (int r = 0; r < kCount; ++r) {
      const Pack::D a = Pack::broadcast(value[std::int64_t{r} * matrix.columns + j]);
      for (int i = 0; i < kPacks; ++i) {
        sum[r][i] = kMinus ? Pack::fnma(a, in[i], sum[r][i]) : Pack::fma(a, in[i], sum[r][i]);
      }
    }
  }
}

/// kCount rows at once: what they have in common together, what sticks out row by row.
template <int kCount, bool kMinus>
inline void add_rows(const DenseRows& matrix, std::int32_t row, const double* x, Pack::D (*sum)[kPacks]) {
  std::int32_t begin = matrix.begin[row], end = matrix.end[row];
  for (int r = 1; r < kCount; ++r) {
    begin = matrix.begin[row + r] > begin ? matrix.begin[row + r] : begin;
    end = matrix.end[row + r] < end ? matrix.end[row + r] : end;
  }
  if (kCount == 1 || begin >= end) begin = end = 0;
  if (begin == end) {
    for (int r = 0; r < kCount; ++r) {
      add_columns<1, kMinus>(matrix, row + r, matrix.begin[row + r], matrix.end[row + r], x, sum + r);
    }
    return;
  }
  for (int r = 0; r < kCount; ++r) {
    add_columns<1, kMinus>(matrix, row + r, matrix.begin[row + r], begin, x, sum + r);
  }
  add_columns<kCount, kMinus>(matrix, row, begin, end, x, sum);
  for (int r = 0; r < kCount; ++r) {
    add_columns<1, kMinus>(matrix, row + r, end, matrix.end[row + r], x, sum + r);
  }
}

template <int kCount>
inline void subtract_rows(const DenseRows& matrix, std::int32_t row, const double* x, double* y) {
  Pack::D sum[kCount][kPacks];
  for (int r = 0; r < kCount; ++r) {
    for (int i = 0; i < kPacks; ++i) sum[r][i] = Pack::load(y + (row + r) * kNoiseLanes + i * Pack::kLanes);
  }
  add_rows<kCount, true>(matrix, row, x, sum);
  for (int r = 0; r < kCount; ++r) {
    for (int i = 0; i < kPacks; ++i) Pack::store(y + (row + r) * kNoiseLanes + i * Pack::kLanes, sum[r][i]);
  }
}

/// y −= M x, for all lanes.
inline void subtract_product(const DenseRows& matrix, const double* x, double* y) {
  for (int lane = 0; lane < kNoiseLanes; lane += kStride) {
    std::int32_t row = 0;
    for (; row + kRows <= matrix.rows; row += kRows) subtract_rows<kRows>(matrix, row, x + lane, y + lane);
    for (; row < matrix.rows; ++row) subtract_rows<1>(matrix, row, x + lane, y + lane);
  }
}

template <int kCount>
inline void add_squares(const DenseRows& matrix, std::int32_t row, const double* x,
                        Pack::D (&square)[kPacks]) {
  Pack::D sum[kCount][kPacks];
  for (int r = 0; r < kCount; ++r) {
    for (int i = 0; i < kPacks; ++i) sum[r][i] = Pack::broadcast(0.0);
  }
  add_rows<kCount, false>(matrix, row, x, sum);
  for (int r = 0; r < kCount; ++r) {
    for (int i = 0; i < kPacks; ++i) square[i] = Pack::fma(sum[r][i], sum[r][i], square[i]);
  }
}

/// run_sum += scale d, for one pack of lanes.
inline void add_to_runs(Pack::D scale, Pack::D deviation, double* run_sum) {
  Pack::store(run_sum, Pack::fma(scale, deviation, Pack::load(run_sum)));
}

/// ‖M x‖² − centre of all lanes, added to the sums, and if kOfRuns times `scale` to those of the runs.
template <bool kOfRuns, bool kPartial>
inline void add_squared_norm(const DenseRows& matrix, const double* x, double centre, double scale,
                             const ActiveLanes<kPartial>& active, double* sums, double* run_sums) {
  for (int lane = 0; lane < kNoiseLanes; lane += kStride) {
    Pack::D square[kPacks];
    for (int i = 0; i < kPacks; ++i) square[i] = Pack::broadcast(-centre);
    std::int32_t row = 0;
    for (; row + kRows <= matrix.rows; row += kRows) add_squares<kRows>(matrix, row, x + lane, square);
    for (; row < matrix.rows; ++row) add_squares<1>(matrix, row, x + lane, square);
    for (int i = 0; i < kPacks; ++i) {
      const int at = lane + i * Pack::kLanes;
      add_to_sums(square[i], active, at, sums);
      if constexpr (kOfRuns) add_to_runs(Pack::broadcast(scale), square[i], run_sums + at);
    }
  }
}

/// Steps `begin` … `begin` + `count` − 1 (0 is the first) of a tile. noise[slot][step][lane], process noises
/// first.
template <bool kPartial>
inline void general_steps(const LinearPlan& plan, std::int64_t begin, std::int64_t count, std::int64_t drawn,
                          const double* noise, const ActiveLanes<kPartial>& active, double* e,
                          double* scratch, double* sums, double* run_sums) {
  const std::int32_t q = plan.process_noises, m = plan.measurements;
  double* prior = scratch;
  double* nu = scratch + plan.states * kNoiseLanes;
  const std::int64_t stride = drawn * kNoiseLanes;
  for (std::int64_t k = 0; k < count; ++k) {
    const LinearPlanStep& step = plan.step[begin + k];
    const LinearPlanPhase& phase = plan.phase[(begin + k) % plan.period];
    double* sums_of_step = sums + (begin + k) * kSumsOfStep;
    const double* v = noise + k * kNoiseLanes;
    const double* w = v + q * stride;
    double* state = e;
    if (!phase.identity) {
      multiply(phase.F, plan.states, e, kNoiseLanes, false, prior);
      state = prior;
    }
    multiply(phase.noise_input, plan.states, v, stride, true, state);
    multiply(phase.H, m, state, kNoiseLanes, false, nu);
    multiply(phase.measurement_root, m, w, stride, true, nu);
    subtract_product(step.gain, nu, state);
    if (state != e)
      __builtin_memcpy(e, state, static_cast<std::size_t>(plan.states) * kNoiseLanes * sizeof(double));
    add_squared_norm<true>(step.error_whitening, e, step.nees_centre, step.nees_scale, active, sums_of_step,
                           run_sums);
    add_squared_norm<false>(step.innovation_whitening, nu, step.nis_centre, 1.0, active,
                            sums_of_step + 2 * kAccumulators, run_sums);
  }
}

// ---- small systems: the state stays in registers
// ---------------------------------------------------------------

/// Packs of lanes side by side.
constexpr int kSmallPacks = Pack::kLanes == 8 ? 2 : 1;

/// A state, or what is measured of it, in registers.
template <int kSize, int kCount>
using SmallVector = Pack::D[kSize][kCount];

/// ‖W x‖² − centre with W lower triangular, by rows from `w`; its last entry is one.
template <int kSize, int kCount>
inline void squared_norm(const double* w, const SmallVector<kSize, kCount>& x, double centre,
                         Pack::D (&square)[kCount]) {
  for (int i = 0; i < kCount; ++i) square[i] = Pack::broadcast(-centre);
  for (int row = 0, j = 0; row < kSize; j += ++row) {
    Pack::D y[kCount];
    const int end = row + 1 < kSize ? row + 1 : row;
    for (int i = 0; i < kCount; ++i)
      y[i] = x[row][i];  // what stays of a row that is nothing but its last entry
    for (int column = 0; column < end; ++column) {
      const Pack::D a = Pack::broadcast(w[j + column]);
      for (int i = 0; i < kCount; ++i) {
        y[i] = column == 0 ? Pack::mul(a, x[column][i]) : Pack::fma(a, x[column][i], y[i]);
      }
    }
    if (end == row && row > 0) {
      for (int i = 0; i < kCount; ++i) y[i] = Pack::add(y[i], x[row][i]);
    }
    for (int i = 0; i < kCount; ++i) square[i] = Pack::fma(y[i], y[i], square[i]);
  }
}

/// y = M x, M by rows.
template <int kRowCount, int kColumns, int kCount>
inline void small_product(const double* matrix, const SmallVector<kColumns, kCount>& x,
                          SmallVector<kRowCount, kCount>& y) {
  for (int row = 0; row < kRowCount; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Pack::D a = Pack::broadcast(matrix[row * kColumns + column]);
      for (int i = 0; i < kCount; ++i) {
        y[row][i] = column == 0 ? Pack::mul(a, x[column][i]) : Pack::fma(a, x[column][i], y[row][i]);
      }
    }
  }
}

/// y += c x of one x for each lane.
template <int kRowCount, int kCount>
inline void add_column(const double* column, const double* x, SmallVector<kRowCount, kCount>& y) {
  for (int i = 0; i < kCount; ++i) {
    const Pack::D in = Pack::load(x + i * Pack::kLanes);
    for (int row = 0; row < kRowCount; ++row)
      y[row][i] = Pack::fma(Pack::broadcast(column[row]), in, y[row][i]);
  }
}

/// The same steps for kStates states and kMeasurements measurements. kMonobot: of a vehicle and kStates − 1
/// landmarks, kMeasurements − kStates + 1 anchors first.
template <int kStates, int kMeasurements, bool kMonobot, bool kPartial>
[[gnu::noinline]] void small_steps(const LinearPlan& plan, std::int64_t begin, std::int64_t count,
                                   std::int64_t drawn, const double* noise,
                                   const ActiveLanes<kPartial>& active, double* e, double* sums,
                                   double* run_sums) {
  constexpr int n = kStates, m = kMeasurements, anchors = m - n + 1;
  constexpr int packs = kMonobot ? Pack::kInterleave : kSmallPacks;
  constexpr int coefficients = n * m + m * (m + 1) / 2 + n * (n + 1) / 2;
  for (int lane = 0; lane < kNoiseLanes; lane += packs * Pack::kLanes) {
    SmallVector<n, packs> x;
    Pack::D of_run[packs];
    for (int i = 0; i < packs; ++i) of_run[i] = Pack::load(run_sums + lane + i * Pack::kLanes);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < packs; ++i) x[j][i] = Pack::load(e + j * kNoiseLanes + lane + i * Pack::kLanes);
    }
    const double* gain = plan.small_coefficients + begin * coefficients;
    double* sums_of_step = sums + begin * kSumsOfStep;
    std::int64_t of_period = kMonobot ? 0 : begin % plan.period;
    for (std::int64_t k = 0; k < count; ++k, gain += coefficients, sums_of_step += kSumsOfStep) {
      const auto noise_of = [&](std::int64_t slot) {
        return noise + (slot * drawn + k) * kNoiseLanes + lane;
      };
      SmallVector<m, packs> nu;
      if constexpr (kMonobot) {
        for (int i = 0; i < packs; ++i)
          x[0][i] = Pack::add(x[0][i], Pack::load(noise_of(0) + i * Pack::kLanes));
        for (int r = 0; r < m; ++r) {
          const Pack::D root = Pack::broadcast(plan.monobot_roots[r]);
          for (int i = 0; i < packs; ++i) {
            const Pack::D landmark =
                r < anchors ? Pack::broadcast(0.0) : x[r < anchors ? 0 : r - anchors + 1][i];
            const Pack::D w = Pack::load(noise_of(1 + r) + i * Pack::kLanes);
            nu[r][i] = Pack::fma(root, w, Pack::sub(landmark, x[0][i]));
          }
        }
      } else {
        const LinearPlanPhase& phase = plan.phase[of_period];
        of_period = of_period + 1 == plan.period ? 0 : of_period + 1;
        SmallVector<n, packs> prior;
        small_product<n>(phase.dense_F, x, prior);
        for (std::int32_t j = 0; j < plan.process_noises; ++j) {
          add_column<n, packs>(phase.noise_columns + j * n, noise_of(j), prior);
        }
        small_product<m>(phase.dense_H, prior, nu);
        for (int j = 0; j < m; ++j) {
          add_column<m, packs>(phase.dense_H + m * (n + j), noise_of(plan.process_noises + j), nu);
        }
        for (int j = 0; j < n; ++j) {
          for (int i = 0; i < packs; ++i) x[j][i] = prior[j][i];
        }
      }
      for (int j = 0; j < n; ++j) {
        for (int r = 0; r < m; ++r) {
          const Pack::D a = Pack::broadcast(gain[j * m + r]);
          for (int i = 0; i < packs; ++i) x[j][i] = Pack::fnma(a, nu[r][i], x[j][i]);
        }
      }
      // read before the sums are written, which the compiler must take for the same memory
      const double nees_centre = plan.step[begin + k].nees_centre,
                   nis_centre = plan.step[begin + k].nis_centre;
      const Pack::D scale = Pack::broadcast(plan.step[begin + k].nees_scale);
      Pack::D nees[packs], nis[packs];
      squared_norm(gain + n * m, nu, nis_centre, nis);
      squared_norm(gain + n * m + m * (m + 1) / 2, x, nees_centre, nees);
      for (int i = 0; i < packs; ++i) {
        of_run[i] = Pack::fma(scale, nees[i], of_run[i]);
        add_to_sums(nees[i], active, lane + i * Pack::kLanes, sums_of_step);
        add_to_sums(nis[i], active, lane + i * Pack::kLanes, sums_of_step + 2 * kAccumulators);
      }
    }
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < packs; ++i) Pack::store(e + j * kNoiseLanes + lane + i * Pack::kLanes, x[j][i]);
    }
    for (int i = 0; i < packs; ++i) Pack::store(run_sums + lane + i * Pack::kLanes, of_run[i]);
  }
}

/// The function for these sizes, null where there is none.
template <bool kPartial>
inline decltype(&small_steps<1, 1, false, kPartial>) small_steps_of(const LinearPlan& plan) {
  if (!plan.small_coefficients) return nullptr;
  const int n = plan.states, m = plan.measurements;
  if (plan.monobot_roots) {
    if (n == 2 && m == 1) return small_steps<2, 1, true, kPartial>;
    if (n == 2 && m == 2) return small_steps<2, 2, true, kPartial>;
    if (n == 3 && m == 2) return small_steps<3, 2, true, kPartial>;
    if (n == 3 && m == 3) return small_steps<3, 3, true, kPartial>;
  }
  if (m == 1) {
    return n == 1   ? small_steps<1, 1, false, kPartial>
           : n == 2 ? small_steps<2, 1, false, kPartial>
           : n == 3 ? small_steps<3, 1, false, kPartial>
                    : small_steps<4, 1, false, kPartial>;
  }
  if (m == 2 && n > 1) {
    return n == 2   ? small_steps<2, 2, false, kPartial>
           : n == 3 ? small_steps<3, 2, false, kPartial>
                    : small_steps<4, 2, false, kPartial>;
  }
  return nullptr;
}

template <bool kPartial>
inline void simulate_steps(const LinearPlan& plan, std::int64_t begin, std::int64_t count, std::int64_t drawn,
                           const double* noise, std::int64_t active_runs, double* e, double* scratch,
                           double* sums, double* run_sums) {
  const ActiveLanes<kPartial> active(active_runs);
  if (const auto steps = small_steps_of<kPartial>(plan)) {
    return steps(plan, begin, count, drawn, noise, active, e, sums, run_sums);
  }
  general_steps(plan, begin, count, drawn, noise, active, e, scratch, sums, run_sums);
}

// ---- runs
// -------------------------------------------------------------------------------------------------------

/// e = L n of one tile; the normals of step 0 are the second ones of the second half of the blocks of word 1
/// = 0.
inline void initial_errors(const LinearPlan& plan, const RunLanes& lanes, const RoundKeys& keys,
                           double* noise, double* e) {
  constexpr std::int32_t kSlots = 8;
  alignas(64) std::uint64_t block[2 * kNoiseLanes], bits[kSlots * kNoiseLanes];
  alignas(64) double pairs[2 * kSlots * kNoiseLanes];
  for (std::int32_t first = 0; first < plan.states; first += kSlots) {
    const std::int32_t slots = plan.states - first < kSlots ? plan.states - first : kSlots;
    for (std::int32_t i = 0; i < slots; ++i) {
      blocks_of_runs(lanes, keys, 0, 1, kInitialPurpose + static_cast<std::uint32_t>(first + i), block);
      __builtin_memcpy(bits + i * kNoiseLanes, block + kNoiseLanes, kNoiseLanes * sizeof(double));
    }
    normals_of_blocks(bits, slots, pairs);
    for (std::int32_t i = 0; i < slots; ++i) {
      __builtin_memcpy(noise + (first + i) * kNoiseLanes, pairs + (2 * i + 1) * kNoiseLanes,
                       kNoiseLanes * sizeof(double));
    }
  }
  multiply(plan.initial_root, plan.states, noise, kNoiseLanes, false, e);
}

/// LinearKernel::simulate. All tiles of a batch go through a block of steps before any enters the next block.
inline void simulate_runs(const LinearPlan& plan, std::uint64_t noise_key, std::uint64_t first_run,
                          std::int64_t runs, const LinearWorkspace& workspace) {
  const RoundKeys keys = round_keys(noise_key);
  const std::int64_t state_size = std::int64_t{plan.states} * kNoiseLanes;
  const std::int64_t runs_of_batch = workspace.runs_of_batch, steps_of_block = 4 * workspace.groups;
  const Slots slots{kProcessPurpose, plan.process_noises, kMeasurementPurpose, plan.measurements};
  double* noise = workspace.noise;
  for (std::int64_t batch = 0; batch < runs; batch += runs_of_batch) {
    const std::int64_t end = batch + runs_of_batch < runs ? batch + runs_of_batch : runs;
    for (std::int64_t begin = 0; begin < plan.steps; begin += steps_of_block) {
      const std::int64_t count = begin + steps_of_block < plan.steps ? steps_of_block : plan.steps - begin;
      const std::int64_t needed = (count + 3) / 4, drawn = 4 * needed;
      const auto word1 = static_cast<std::uint32_t>(1 + begin / 4);
      for (std::int64_t tile = batch; tile < end; tile += kNoiseLanes) {
        double* e = workspace.errors + (tile - batch) / kNoiseLanes * state_size;
        RunLanes lanes;
        set_run_lanes(first_run + static_cast<std::uint64_t>(tile), keys, lanes);
        if (begin == 0) initial_errors(plan, lanes, keys, noise, e);
        normals_of_lanes(lanes, keys, word1, needed, slots, noise);
        if (end - tile >= kNoiseLanes) {
          simulate_steps<false>(plan, begin, count, drawn, noise, kNoiseLanes, e, workspace.scratch,
                                workspace.sums, workspace.run_sums + tile);
        } else {
          simulate_steps<true>(plan, begin, count, drawn, noise, end - tile, e, workspace.scratch,
                               workspace.sums, workspace.run_sums + tile);
        }
      }
    }
  }
}

}  // namespace

const LinearKernel* CREDENCE_OF_SET(linear_kernel)() {
  static constexpr LinearKernel kernel{&simulate_runs};
  return &kernel;
}

}  // namespace credence::internal
