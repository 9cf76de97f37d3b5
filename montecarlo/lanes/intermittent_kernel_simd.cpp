#include "montecarlo/lanes/intermittent_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
using Pack = LanePack;

// One Riccati step a lane: the same operations in the same order for every Pack, hence the same bits.
//
// Measurements are taken one by one, each with v = P h, s = hᵀ v + r and k = v seen/s, in Joseph's form:
//   A = P − k vᵀ,  P ← A − ½ (b kᵀ + k bᵀ) with b = A h − r k,  e ← e − k ν,
// which is the joint update of those that were seen, since R is diagonal; what was not seen has k = 0 and
// changes nothing. NIS = Σ seen ν²/s for the ν of the turn. NEES by P = L D Lᵀ.

using D = Pack::D;

/// Rows of one pack of lanes, in registers.
template <int kRows>
struct Held {
  D row[kRows];
  D get(int i) const { return row[i]; }
  void set(int i, D x) { row[i] = x; }
};

/// The same in memory.
struct InMemory {
  double* row;
  D get(int i) const { return Pack::load(row + std::int64_t{i} * Pack::kLanes); }
  void set(int i, D x) { Pack::store(row + std::int64_t{i} * Pack::kLanes, x); }
};

constexpr int triangle(int n) { return n * (n + 1) / 2; }
/// Of the element i, j of a symmetric matrix in its lower triangle by rows.
constexpr int element(int i, int j) { return i >= j ? triangle(i) + j : triangle(j) + i; }

inline D magnitude(D x) {
  const std::uint64_t bits = 0x7fffffffffffffff;
  double all_but_sign;
  __builtin_memcpy(&all_but_sign, &bits, sizeof bits);
  return Pack::mask(x, Pack::broadcast(all_but_sign));
}

/// P before the update: noise of the step, and what is added to it.
template <class Covariance>
inline void predict(const IntermittentPlan& plan, int n, Covariance& P) {
  P.set(0, Pack::add(P.get(0), Pack::broadcast(plan.process_variance)));
  if (plan.constant) {
    for (int i = 0; i < triangle(n); ++i) P.set(i, Pack::add(P.get(i), Pack::broadcast(plan.constant[i])));
  }
  for (int i = plan.first_decorrelated; i < n; ++i) {
    for (int j = plan.first_decorrelated; j < i; ++j) {
      const D c = magnitude(P.get(element(i, j)));
      P.set(element(i, i), Pack::add(P.get(element(i, i)), c));
      P.set(element(j, j), Pack::add(P.get(element(j, j)), c));
      P.set(element(i, j), Pack::broadcast(0.0));
    }
  }
}

/// One measurement, of a landmark (state l) or of an anchor (l = 0); returns seen ν²/s. v, k and b take n
/// rows each.
template <class Error, class Covariance, class Work>
inline D take(const IntermittentPlan& plan, int n, int l, D noise, D seen, Error& e, Covariance& P, Work& v,
              Work& k, Work& b) {
  const D zero = Pack::broadcast(0.0), half = Pack::broadcast(0.5);
  const D r = Pack::broadcast(plan.measurement_variance);
  for (int j = 0; j < n; ++j) {
    v.set(j, Pack::sub(l > 0 ? P.get(element(l, j)) : zero, P.get(element(j, 0))));
  }
  const D v_0 = v.get(0), v_l = l > 0 ? v.get(l) : zero;
  const D g = Pack::div(seen, Pack::add(Pack::sub(v_l, v_0), r));
  const D nu =
      Pack::fma(Pack::broadcast(plan.measurement_std), noise, Pack::sub(l > 0 ? e.get(l) : zero, e.get(0)));
  const D k_l = Pack::mul(v_l, g);
  for (int i = 0; i < n; ++i) {
    const D v_i = v.get(i), k_i = Pack::mul(v_i, g);
    // A_ij = P_ij − k_i v_j for i >= j, to the same bits as below
    const D A_i0 = Pack::fnma(k_i, v_0, P.get(element(i, 0)));
    const D A_il = l == 0   ? zero
                   : i >= l ? Pack::fnma(k_i, v_l, P.get(element(i, l)))
                            : Pack::fnma(k_l, v_i, P.get(element(i, l)));
    k.set(i, k_i);
    b.set(i, Pack::mul(half, Pack::fnma(r, k_i, Pack::sub(A_il, A_i0))));
    e.set(i, Pack::fnma(k_i, nu, e.get(i)));
  }
  for (int i = 0; i < n; ++i) {
    const D k_i = k.get(i), b_i = b.get(i);
    for (int j = 0; j <= i; ++j) {
      const D A_ij = Pack::fnma(k_i, v.get(j), P.get(element(i, j)));
      P.set(element(i, j), Pack::fnma(b_i, k.get(j), Pack::fnma(b.get(j), k_i, A_ij)));
    }
  }
  return Pack::mul(Pack::mul(g, nu), nu);
}

/// NEES, and the check of IntermittentValue. A takes the Schur complements of P, y those of e.
template <class Error, class Covariance, class Work>
inline D nees_of(int n, const Error& e, const Covariance& P, Covariance& A, Work& y, D& check) {
  for (int i = 0; i < triangle(n); ++i) A.set(i, P.get(i));
  for (int i = 0; i < n; ++i) y.set(i, e.get(i));
  D nees = Pack::broadcast(0.0);
  check = nees;
  for (int j = 0; j < n; ++j) {
    const D d = A.get(element(j, j)), y_j = y.get(j), inverse = Pack::div(Pack::broadcast(1.0), d);
    nees = Pack::fma(Pack::mul(y_j, y_j), inverse, nees);
    check = Pack::add(check, Pack::sub(d, magnitude(d)));
    for (int i = j + 1; i < n; ++i) {
      const D l = Pack::mul(A.get(element(i, j)), inverse);
      for (int k = j + 1; k <= i; ++k) {
        A.set(element(i, k), Pack::fnma(l, A.get(element(k, j)), A.get(element(i, k))));
      }
      y.set(i, Pack::fnma(l, y_j, y.get(i)));
    }
  }
  return nees;
}

/// Step k of one pack of lanes, from `lane` on. v, k and b take n rows, A as many as P.
template <class Error, class Covariance, class Work>
inline void step_of_pack(const IntermittentPlan& plan, int n, int anchors, std::int64_t step, int lane,
                         const IntermittentData& data, Error& e, Covariance& P, Covariance& A, Work& v,
                         Work& k, Work& b) {
  double* values = data.values + step * kIntermittentValues * kNoiseLanes + lane;
  const auto put = [&](int value, D x) { Pack::store(values + value * kNoiseLanes, x); };
  const D motion = Pack::load(data.process + step * kNoiseLanes + lane);
  e.set(0, Pack::fma(Pack::broadcast(plan.process_std), motion, e.get(0)));
  predict(plan, n, P);
  D trace = P.get(0);
  for (int i = 1; i < n; ++i) trace = Pack::add(trace, P.get(element(i, i)));
  put(kTracePriorValue, trace);

  D nis = Pack::broadcast(0.0);
  for (int r = 0; r < n - 1 + anchors; ++r) {
    const std::int64_t at = (r * data.drawn + step) * kNoiseLanes + lane;
    nis = Pack::add(nis, take(plan, n, r < anchors ? 0 : r - anchors + 1, Pack::load(data.measurement + at),
                              Pack::load(data.seen + at), e, P, v, k, b));
  }
  put(kNisValue, nis);

  D check;
  put(kNeesValue, nees_of(n, e, P, A, v, check));
  put(kCheckValue, check);
  D landmarks = Pack::broadcast(0.0);
  for (int i = 1; i < n; ++i) landmarks = Pack::add(landmarks, P.get(element(i, i)));
  put(kLandmarksValue, landmarks);
  put(kVehicleValue, P.get(0));
  put(kTraceValue, Pack::add(P.get(0), landmarks));
}

/// A small state stays in registers during a step; packs of lanes are independent and overlap.
template <int kStates, int kAnchors>
[[gnu::noinline]] void steps_in_registers(const IntermittentPlan& plan, std::int64_t count,
                                          const IntermittentData& data) {
  for (std::int64_t step = 0; step < count; ++step) {
    for (int lane = 0; lane < kNoiseLanes; lane += Pack::kLanes) {
      InMemory errors{data.errors + lane * kStates}, covariance{data.covariance + lane * triangle(kStates)};
      Held<kStates> e, v, k, b;
      Held<triangle(kStates)> P, A;
      for (int i = 0; i < kStates; ++i) e.set(i, errors.get(i));
      for (int i = 0; i < triangle(kStates); ++i) P.set(i, covariance.get(i));
      step_of_pack(plan, kStates, kAnchors, step, lane, data, e, P, A, v, k, b);
      for (int i = 0; i < kStates; ++i) errors.set(i, e.get(i));
      for (int i = 0; i < triangle(kStates); ++i) covariance.set(i, P.get(i));
    }
  }
}

/// IntermittentKernel::steps.
inline void intermittent_steps(const IntermittentPlan& plan, std::int64_t count,
                               const IntermittentData& data) {
  const int n = plan.states, anchors = plan.anchors;
  if (n == 2 && anchors == 0) return steps_in_registers<2, 0>(plan, count, data);
  if (n == 2 && anchors == 1) return steps_in_registers<2, 1>(plan, count, data);
  if (n == 3 && anchors == 0) return steps_in_registers<3, 0>(plan, count, data);
  if (n == 3 && anchors == 1) return steps_in_registers<3, 1>(plan, count, data);
  for (int lane = 0; lane < kNoiseLanes; lane += Pack::kLanes) {
    const auto rows = [&](int i) { return InMemory{data.work + (triangle(n) + i * n) * Pack::kLanes}; };
    InMemory e{data.errors + lane * n}, P{data.covariance + lane * triangle(n)}, A{data.work};
    InMemory v = rows(0), k = rows(1), b = rows(2);
    for (std::int64_t step = 0; step < count; ++step) {
      step_of_pack(plan, n, anchors, step, lane, data, e, P, A, v, k, b);
    }
  }
}

/// Σ over all lanes: as eight sums, so that lanes of any width add them in the same order.
template <class Term>
inline double sum_of_lanes(Term term) {
  double sums[8];
  for (int i = 0; i < 8; i += Pack::kLanes) {
    Pack::store(sums + i, Pack::add(Pack::add(term(i), term(i + 8)), Pack::add(term(i + 16), term(i + 24))));
  }
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

/// IntermittentKernel::moments.
void moments_of_rows(const double* x, std::int64_t rows, double* mean, double* m2) {
  for (std::int64_t row = 0; row < rows; ++row, x += kNoiseLanes) {
    mean[row] = sum_of_lanes([&](int lane) { return Pack::load(x + lane); }) * (1.0 / kNoiseLanes);
    const D centre = Pack::broadcast(mean[row]);
    m2[row] = sum_of_lanes([&](int lane) {
      const D d = Pack::sub(Pack::load(x + lane), centre);
      return Pack::mul(d, d);
    });
  }
}

constexpr IntermittentKernel kIntermittentKernel{&intermittent_steps, &moments_of_rows, Pack::kLanes};

}  // namespace

const IntermittentKernel* CREDENCE_OF_SET(intermittent_kernel)() { return &kIntermittentKernel; }

}  // namespace credence::internal
