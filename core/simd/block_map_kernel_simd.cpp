#include "core/simd/block_map_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
using Pack = LanePack;

// The passes over the map.

constexpr int kParts = 8 / Pack::kLanes;  ///< packs for eight landmarks

/// 1/√x to 3 ulp for x in [1e-300, 1e300], without a division or a root: the bits of x give 3 %, one step of
/// third and one of fourth order the rest.
inline Pack::D reciprocal_root(Pack::D x) {
  const Pack::D one = Pack::broadcast(1.0), half = Pack::broadcast(0.5),
                three_eighths = Pack::broadcast(0.375);
  Pack::D y = Pack::magic_minus_half(0x5fe6eb50c7b537a9ULL, x);
  Pack::D e = Pack::fnma(Pack::mul(x, y), y, one);
  y = Pack::fma(Pack::mul(y, e), Pack::fma(three_eighths, e, half), y);
  e = Pack::fnma(Pack::mul(x, y), y, one);
  const Pack::D series = Pack::fma(Pack::fma(Pack::broadcast(0.3125), e, three_eighths), e, half);
  return Pack::fma(Pack::mul(y, e), series, y);
}

/// X of one pack of landmarks, the first being `at`.
template <int kVehicle, int kLandmark>
struct MapPack {
  Pack::D x[kVehicle][kLandmark];

  MapPack(const BlockMapArrays& map, std::int64_t at) {
    for (int a = 0; a < kVehicle; ++a) {
      for (int c = 0; c < kLandmark; ++c) {
        x[a][c] = Pack::load(map.rf + (a * kLandmark + c) * map.stride + at);
      }
    }
  }
  /// Component c of Xᵀ g.
  Pack::D along(const Pack::D (&g)[kVehicle], int c) const {
    Pack::D sum = Pack::mul(g[0], x[0][c]);
    for (int a = 1; a < kVehicle; ++a) sum = Pack::fma(g[a], x[a][c], sum);
    return sum;
  }
};

template <int kVehicle>
inline void broadcast_direction(const double* from, Pack::D (&g)[kVehicle]) {
  for (int a = 0; a < kVehicle; ++a) g[a] = Pack::broadcast(from[a]);
}

/// Joins the lanes in their order.
inline BlockMapNorms join_lanes(const Pack::D (&largest)[kParts], const Pack::D (&others)[kParts]) {
  double lane_largest[8], lane_others[8];
  for (int part = 0; part < kParts; ++part) {
    Pack::store(lane_largest + part * Pack::kLanes, largest[part]);
    Pack::store(lane_others + part * Pack::kLanes, others[part]);
  }
  BlockMapNorms out;
  for (int i = 0; i < 8; ++i) {
    const bool larger = lane_largest[i] > out.largest;
    out.others += lane_others[i] + (larger ? out.largest : lane_largest[i]);
    if (larger) out.largest = lane_largest[i];
  }
  return out;
}

/// Directions kFirst … kFirst + kCount − 1. `map` by value: what is stored cannot change it.
template <int kVehicle, int kLandmark, int kFirst, int kCount>
inline void norms_of(const BlockMapArrays map, const BlockMapDirections& directions, double* reciprocals,
                     BlockMapNorms* out) {
  Pack::D g[kCount][kVehicle], largest[kCount][kParts], others[kCount][kParts];
  for (int i = 0; i < kCount; ++i) {
    broadcast_direction<kVehicle>(directions.g[kFirst + i], g[i]);
    for (int part = 0; part < kParts; ++part) largest[i][part] = others[i][part] = Pack::broadcast(0.0);
  }
  const Pack::D tiny = Pack::broadcast(1e-300);
  for (std::int64_t j = 0; j < 8 * map.packs; j += 8) {
    for (int part = 0; part < kParts; ++part) {
      const std::int64_t at = j + part * Pack::kLanes;
      const MapPack<kVehicle, kLandmark> landmarks(map, at);
      for (int i = 0; i < kCount; ++i) {
        const Pack::D first = landmarks.along(g[i], 0);
        Pack::D square = Pack::mul(first, first);
        for (int c = 1; c < kLandmark; ++c) {
          const Pack::D l = landmarks.along(g[i], c);
          square = Pack::fma(l, l, square);
        }
        // The first by multiplications, the second by the unit for roots: both are busy at the same time.
        const Pack::D bounded = Pack::max(tiny, square);
        const Pack::D reciprocal =
            kFirst + i == 0 ? reciprocal_root(bounded) : Pack::div(Pack::broadcast(1.0), Pack::sqrt(bounded));
        Pack::store(reciprocals + (kFirst + i) * map.stride + at, reciprocal);
        const Pack::D norm = Pack::mul(square, reciprocal);
        others[i][part] = Pack::add(others[i][part], Pack::min(largest[i][part], norm));
        largest[i][part] = Pack::max(norm, largest[i][part]);
      }
    }
  }
  for (int i = 0; i < kCount; ++i) out[kFirst + i] = join_lanes(largest[i], others[i]);
}

template <int kVehicle, int kLandmark>
void norms_pass(const BlockMapArrays& map, const BlockMapDirections& directions, double* reciprocals,
                BlockMapNorms* out) {
  if constexpr (Pack::kLanes == 8) {
    if (directions.count == 2) return norms_of<kVehicle, kLandmark, 0, 2>(map, directions, reciprocals, out);
  }
  // Sixteen registers do not hold two directions at once.
  if (directions.count >= 1) norms_of<kVehicle, kLandmark, 0, 1>(map, directions, reciprocals, out);
  if (directions.count == 2) norms_of<kVehicle, kLandmark, 1, 1>(map, directions, reciprocals, out);
}

/// The eight parts of a sum, joined in their order.
inline double join_sum(const Pack::D (&parts)[kParts]) {
  double lane[8], sum = 0.0;
  for (int part = 0; part < kParts; ++part) Pack::store(lane + part * Pack::kLanes, parts[part]);
  for (const double x : lane) sum += x;
  return sum;
}

/// Adds to every block of D what `add(at, square)` asks for, by square(g, s): s (Xᵀ g)(Xᵀ g)ᵀ. Returns tr D.
template <int kVehicle, int kLandmark, typename Add>
inline double change_blocks(const BlockMapArrays map, Add add) {
  constexpr int kBlockEntries = kLandmark * (kLandmark + 1) / 2;
  Pack::D trace[kParts];
  for (int part = 0; part < kParts; ++part) trace[part] = Pack::broadcast(0.0);
  for (std::int64_t j = 0; j < 8 * map.packs; j += 8) {
    for (int part = 0; part < kParts; ++part) {
      const std::int64_t at = j + part * Pack::kLanes;
      const MapPack<kVehicle, kLandmark> landmarks(map, at);
      Pack::D block[kBlockEntries];
      for (int b = 0; b < kBlockEntries; ++b) block[b] = Pack::load(map.blocks + b * map.stride + at);
      add(
          at, [&](const Pack::D(&g)[kVehicle], Pack::D s) __attribute__((always_inline)) {
            const Pack::D x = landmarks.along(g, 0), sx = Pack::mul(s, x);
            block[0] = Pack::fma(sx, x, block[0]);
            if constexpr (kLandmark == 2) {
              const Pack::D y = landmarks.along(g, 1);
              block[1] = Pack::fma(sx, y, block[1]);
              block[2] = Pack::fma(Pack::mul(s, y), y, block[2]);
            }
          });
      for (int b = 0; b < kBlockEntries; ++b) Pack::store(map.blocks + b * map.stride + at, block[b]);
      trace[part] = Pack::add(trace[part], block[0]);
      if constexpr (kLandmark == 2) trace[part] = Pack::add(trace[part], block[2]);
    }
  }
  return join_sum(trace);
}

/// Adds the shares of the directions `which`, kCount of them, to D.
template <int kVehicle, int kLandmark, int kCount>
inline double inflate_by(const BlockMapArrays& map, const BlockMapDirections& directions,
                         const int (&which)[kMaxDirections], const double* excess,
                         const double* reciprocals) {
  Pack::D g[kCount][kVehicle], share[kCount];
  const double* reciprocal[kCount];
  for (int i = 0; i < kCount; ++i) {
    broadcast_direction<kVehicle>(directions.g[which[i]], g[i]);
    share[i] = Pack::broadcast(excess[which[i]]);
    reciprocal[i] = reciprocals + which[i] * map.stride;
  }
  return change_blocks<kVehicle, kLandmark>(
      map, [&](std::int64_t at, auto square) __attribute__((always_inline)) {
        for (int i = 0; i < kCount; ++i) {
          square(g[i], Pack::mul(share[i], Pack::load(reciprocal[i] + at)));
        }
      });
}

template <int kVehicle, int kLandmark>
double inflate_pass(const BlockMapArrays& map, const BlockMapDirections& directions, const double* excess,
                    const double* reciprocals) {
  int which[kMaxDirections] = {};
  int count = 0;
  for (int i = 0; i < directions.count; ++i) {
    if (excess[i] != 0.0) which[count++] = i;
  }
  if (count == 2) return inflate_by<kVehicle, kLandmark, 2>(map, directions, which, excess, reciprocals);
  if (count == 1) return inflate_by<kVehicle, kLandmark, 1>(map, directions, which, excess, reciprocals);
  return inflate_by<kVehicle, kLandmark, 1>(map, BlockMapDirections{}, which, excess, reciprocals);
}

/// Part by part, so that the sums stay in registers.
template <int kVehicle, int kLandmark>
void moments_pass(const BlockMapArrays& map, const BlockMapFrame& frame, double* reciprocals,
                  BlockMapMoments* out) {
  constexpr int kSquares = kVehicle * (kVehicle + 1) / 2;
  Pack::D norms[kParts], squares[kSquares][kParts];
  for (int part = 0; part < kParts; ++part) {
    Pack::D g[kVehicle][kVehicle], norm_sum = Pack::broadcast(0.0), sums[kSquares];
    for (int i = 0; i < kVehicle; ++i) broadcast_direction<kVehicle>(frame.g[i], g[i]);
    for (Pack::D& sum : sums) sum = Pack::broadcast(0.0);
    for (std::int64_t at = part * Pack::kLanes; at < 8 * map.packs; at += 8) {
      const MapPack<kVehicle, kLandmark> landmarks(map, at);
      Pack::D c[kVehicle][kLandmark], square = Pack::broadcast(0.0);
      for (int i = 0; i < kVehicle; ++i) {
        for (int a = 0; a < kLandmark; ++a) {
          c[i][a] = landmarks.along(g[i], a);
          square = Pack::fma(c[i][a], c[i][a], square);
        }
      }
      const Pack::D reciprocal = reciprocal_root(Pack::max(Pack::broadcast(1e-300), square));
      Pack::store(reciprocals + at, reciprocal);
      norm_sum = Pack::fma(square, reciprocal, norm_sum);
      int entry = 0;
      for (int i = 0; i < kVehicle; ++i) {
        for (int k = 0; k <= i; ++k) {
          Pack::D product = Pack::mul(c[i][0], c[k][0]);
          for (int a = 1; a < kLandmark; ++a) product = Pack::fma(c[i][a], c[k][a], product);
          sums[entry] = Pack::fma(product, reciprocal, sums[entry]);
          ++entry;
        }
      }
    }
    norms[part] = norm_sum;
    for (int entry = 0; entry < kSquares; ++entry) squares[entry][part] = sums[entry];
  }
  out->norms = join_sum(norms);
  for (int entry = 0; entry < kSquares; ++entry) out->squares[entry] = join_sum(squares[entry]);
}

template <int kVehicle, int kLandmark>
double spread_pass(const BlockMapArrays& map, const BlockMapFrame& frame, const double* reciprocals) {
  Pack::D g[kVehicle][kVehicle];
  for (int i = 0; i < kVehicle; ++i) broadcast_direction<kVehicle>(frame.g[i], g[i]);
  return change_blocks<kVehicle, kLandmark>(
      map, [&](std::int64_t at, auto square) __attribute__((always_inline)) {
        const Pack::D reciprocal = Pack::load(reciprocals + at);
        for (int i = 0; i < kVehicle; ++i) square(g[i], reciprocal);
      });
}

template <int kVehicle, int kLandmark>
void transform_pass(const BlockMapArrays& map, const double* T, const double* w, double* shift) {
  Pack::D row[kVehicle][kVehicle], weight[kVehicle];
  for (int a = 0; a < kVehicle; ++a) broadcast_direction<kVehicle>(T + a * kVehicle, row[a]);
  broadcast_direction<kVehicle>(w, weight);
  for (std::int64_t j = 0; j < 8 * map.packs; j += Pack::kLanes) {
    const MapPack<kVehicle, kLandmark> landmarks(map, j);
    for (int c = 0; c < kLandmark; ++c) {
      Pack::store(shift + c * map.stride + j, landmarks.along(weight, c));
      for (int a = 0; a < kVehicle; ++a) {
        Pack::store(map.rf + (a * kLandmark + c) * map.stride + j, landmarks.along(row[a], c));
      }
    }
  }
}

template <int kVehicle, int kLandmark>
const BlockMapKernel* passes() {
  static constexpr BlockMapKernel kernel{&norms_pass<kVehicle, kLandmark>, &inflate_pass<kVehicle, kLandmark>,
                                         &moments_pass<kVehicle, kLandmark>,
                                         &spread_pass<kVehicle, kLandmark>,
                                         &transform_pass<kVehicle, kLandmark>};
  return &kernel;
}

const BlockMapKernel* passes_for(int vehicle, int landmark) {
  if (vehicle == 3 && landmark == 2) return passes<3, 2>();
  if (vehicle == 1 && landmark == 1) return passes<1, 1>();
  if (vehicle == 3 && landmark == 1) return passes<3, 1>();
  if (vehicle == 1 && landmark == 2) return passes<1, 2>();
  return nullptr;
}

}  // namespace

const BlockMapKernel* CREDENCE_OF_SET(block_map_kernel)(int vehicle, int landmark) {
  return passes_for(vehicle, landmark);
}

}  // namespace credence::internal
