#include "montecarlo/lanes/planar_nees_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
#include "montecarlo/lanes/planar_lane_matrix.inc"

/// Three numbers, and a symmetric matrix of them by its lower triangle.
struct Triple {
  D of[3];
};
struct Symmetric {
  D of[6];
  const D& at(int r, int c) const { return r >= c ? of[r * (r + 1) / 2 + c] : of[c * (c + 1) / 2 + r]; }
  D& at(int r, int c) { return r >= c ? of[r * (r + 1) / 2 + c] : of[c * (c + 1) / 2 + r]; }
};

inline Triple load_triple(const double* p) {
  return {{load_lanes(p, 0), load_lanes(p, 1), load_lanes(p, 2)}};
}
inline void store_triple(double* p, const Triple& x) {
  for (int c = 0; c < 3; ++c) store_lanes(p, c, x.of[c]);
}
inline Symmetric load_symmetric(const double* p) {
  Symmetric S;
  for (int i = 0; i < 6; ++i) S.of[i] = load_lanes(p, i);
  return S;
}
inline void store_symmetric(double* p, const Symmetric& S) {
  for (int i = 0; i < 6; ++i) store_lanes(p, i, S.of[i]);
}

inline D dot(const Triple& a, const Triple& b) {
  return Pack::fma(a.of[2], b.of[2], Pack::fma(a.of[1], b.of[1], Pack::mul(a.of[0], b.of[0])));
}
inline Triple times(const D (&M)[3][3], const Triple& x) {
  Triple y;
  for (int r = 0; r < 3; ++r) {
    y.of[r] = Pack::fma(M[r][2], x.of[2], Pack::fma(M[r][1], x.of[1], Pack::mul(M[r][0], x.of[0])));
  }
  return y;
}
inline Triple times(const Symmetric& S, const Triple& x) {
  Triple y;
  for (int r = 0; r < 3; ++r) {
    y.of[r] = Pack::fma(S.at(r, 2), x.of[2], Pack::fma(S.at(r, 1), x.of[1], Pack::mul(S.at(r, 0), x.of[0])));
  }
  return y;
}
/// y += a x.
inline void add(Triple& y, D a, const Triple& x) {
  for (int c = 0; c < 3; ++c) y.of[c] = Pack::fma(a, x.of[c], y.of[c]);
}

/// The three numbers of a state in A.
inline double* row_of(const PlanarNeesData& d, int lane, std::int64_t i) {
  return d.A + 3 * i * kPlanarLanes + lane;
}

void move_lanes(const PlanarNeesData& d, const double* F_lanes, const double* Q_lanes) {
  for_packs([&](int lane) {
    D F[3][3], T[3][3];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) F[r][c] = load_lanes(F_lanes + lane, 3 * r + c);
    }
    Symmetric S = load_symmetric(d.Sigma + lane);
    for (int c = 0; c < 3; ++c) {
      const Triple column = times(F, {{S.at(0, c), S.at(1, c), S.at(2, c)}});
      for (int r = 0; r < 3; ++r) T[r][c] = column.of[r];
    }
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) {
        D sum = load_lanes(Q_lanes + lane, r * (r + 1) / 2 + c);
        for (int k = 0; k < 3; ++k) sum = Pack::fma(T[r][k], F[c][k], sum);
        S.at(r, c) = sum;
      }
    }
    store_symmetric(d.Sigma + lane, S);
    for (std::int64_t i = 3; i < d.states; ++i) {
      double* row = row_of(d, lane, i);
      store_triple(row, times(F, load_triple(row)));
    }
  });
}

// Of a block D of the map: w = D⁻¹ e, Aᵀ = −P_rl D⁻¹, and Σ = P_rr + Σ_l Aᵀ P_lr.
void start_lanes(const PlanarNeesData& d, const PlanarLanesData& filter, double* determinants) {
  for_packs([&](int lane) {
    const LaneMatrix P{filter.P + lane, filter.padded};
    const D zero = Pack::broadcast(0.0), one = Pack::broadcast(1.0);
    Symmetric S;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) S.at(r, c) = P.load(r, c);
    }
    for (std::int64_t i = 3; i + 1 < d.states; i += 2) {
      const D a = P.load(i, i), b = P.load(i + 1, i), c = P.load(i + 1, i + 1);
      const D determinant = Pack::fnma(b, b, Pack::mul(a, c));
      const auto there = Pack::less(zero, determinant);
      const D inverse = Pack::select(there, Pack::div(one, determinant), zero);
      store_lanes(determinants + lane, (i - 3) / 2, Pack::select(there, determinant, one));
      const D e = load_lanes(d.error + lane, i), f = load_lanes(d.error + lane, i + 1);
      store_lanes(d.w + lane, i, Pack::mul(inverse, Pack::fnma(b, f, Pack::mul(c, e))));
      store_lanes(d.w + lane, i + 1, Pack::mul(inverse, Pack::fnma(b, e, Pack::mul(a, f))));
      Triple x, y;
      const D minus = Pack::sub(zero, inverse);
      for (int r = 0; r < 3; ++r) {
        const D p = P.load(i, r), q = P.load(i + 1, r);
        x.of[r] = Pack::mul(minus, Pack::fnma(b, q, Pack::mul(c, p)));
        y.of[r] = Pack::mul(minus, Pack::fnma(b, p, Pack::mul(a, q)));
      }
      store_triple(row_of(d, lane, i), x);
      store_triple(row_of(d, lane, i + 1), y);
      for (int r = 0; r < 3; ++r) {
        for (int k = 0; k <= r; ++k) {
          S.at(r, k) = Pack::fma(y.of[r], P.load(i + 1, k), Pack::fma(x.of[r], P.load(i, k), S.at(r, k)));
        }
      }
    }
    store_symmetric(d.Sigma + lane, S);
  });
}

void correct_lanes(const PlanarNeesData& d, const PlanarLanesData& filter) {
  for_packs([&](int lane) {
    const D zero = Pack::broadcast(0.0), one = Pack::broadcast(1.0);
    const Triple prior = load_triple(d.prior + lane);
    Triple q = prior;
    for (std::int64_t i = 3; i < d.states; ++i) {
      add(q, load_lanes(d.error + lane, i), load_triple(row_of(d, lane, i)));
    }
    Symmetric S = load_symmetric(d.Sigma + lane);
    D C[3][3];  // of the rows of A, transposed
    Triple t{{zero, zero, zero}};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) C[r][c] = r == c ? one : zero;
    }
    for (std::int64_t b = 0; b < filter.measured; ++b) {
      const Jacobian J = load_jacobian(filter.H + 10 * b * kPlanarLanes + lane);
      const std::int64_t at = filter.offset[b];
      const D v[5] = {prior.of[0], prior.of[1], prior.of[2], at < 0 ? zero : load_lanes(d.error + lane, at),
                      at < 0 ? zero : load_lanes(d.error + lane, at + 1)};
      for (int i = 0; i < 2; ++i) {
        const std::int64_t row = 2 * b + i;
        const D tells = Pack::add(apply(J, i, v, at < 0), load_lanes(filter.nu + lane, row));
        store_lanes(d.tells + lane, row, tells);
        const Triple h{{J.r[i][0], J.r[i][1], J.r[i][2]}}, g = times(S, h);
        const D s = Pack::add(load_lanes(filter.R + lane, row), dot(h, g)), inverse = Pack::div(one, s);
        store_lanes(d.scalars + lane, row, s);
        const D gain = Pack::mul(Pack::sub(dot(h, q), tells), inverse);
        Triple Ch;
        for (int r = 0; r < 3; ++r) {
          Ch.of[r] = Pack::fma(C[2][r], h.of[2], Pack::fma(C[1][r], h.of[1], Pack::mul(C[0][r], h.of[0])));
        }
        add(t, gain, Ch);
        add(q, Pack::sub(zero, gain), g);
        for (int r = 0; r < 3; ++r) {
          const D part = Pack::mul(g.of[r], inverse);
          for (int c = 0; c < 3; ++c) C[r][c] = Pack::fnma(part, Ch.of[c], C[r][c]);
          for (int c = 0; c <= r; ++c) S.at(r, c) = Pack::fnma(part, g.of[c], S.at(r, c));
        }
      }
    }
    for (std::int64_t i = 3; i < d.states; ++i) {
      double* row = row_of(d, lane, i);
      const Triple a = load_triple(row);
      store_lanes(d.w + lane, i, Pack::add(load_lanes(d.w + lane, i), dot(a, t)));
      store_triple(row, times(C, a));
    }
    for (std::int64_t b = 0; b < filter.measured; ++b) {
      const std::int64_t at = filter.offset[b];
      if (at < 0) continue;
      const Jacobian J = load_jacobian(filter.H + 10 * b * kPlanarLanes + lane);
      for (int i = 0; i < 2; ++i) {
        const Triple h{{J.r[i][0], J.r[i][1], J.r[i][2]}}, g = times(S, h);
        const D inverse = Pack::div(one, load_lanes(filter.R + lane, 2 * b + i));
        const D rest = Pack::sub(load_lanes(d.tells + lane, 2 * b + i), dot(h, q));
        for (int c = 0; c < 2; ++c) {
          const D l = Pack::mul(J.l[i][c], inverse);
          store_lanes(d.w + lane, at + c, Pack::fma(l, rest, load_lanes(d.w + lane, at + c)));
          double* row = row_of(d, lane, at + c);
          Triple a = load_triple(row);
          add(a, l, g);
          store_triple(row, a);
        }
      }
    }
    store_symmetric(d.Sigma + lane, S);
  });
}

/// L⁻¹ x and the inverse of L's diagonal, S = L Lᵀ.
inline Triple whiten(const Symmetric& S, const Triple& x, Triple& inverse) {
  D L[3][3];
  Triple u;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) {
      D sum = S.at(r, c);
      for (int k = 0; k < c; ++k) sum = Pack::fnma(L[r][k], L[c][k], sum);
      L[r][c] = c < r ? Pack::mul(sum, inverse.of[c]) : sum;
    }
    inverse.of[r] = Pack::div(Pack::broadcast(1.0), Pack::sqrt(L[r][r]));
    D sum = x.of[r];
    for (int k = 0; k < r; ++k) sum = Pack::fnma(L[r][k], u.of[k], sum);
    u.of[r] = Pack::mul(sum, inverse.of[r]);
  }
  return u;
}

void judge_lanes(const PlanarNeesData& d, const PlanarLanesData& filter) {
  for_packs([&](int lane) {
    const LaneMatrix P{filter.P + lane, filter.padded};
    const D zero = Pack::broadcast(0.0);
    const Triple error = load_triple(d.error + lane);
    const D one = Pack::broadcast(1.0);
    Triple q = error, inverse;
    D map = zero, trace = zero, dof = zero, map_error = zero, largest = zero, finite = zero;
    for (std::int64_t i = 0; i < d.states; ++i) {
      const D e = load_lanes(d.error + lane, i), p = P.load(i, i);
      trace = Pack::add(trace, p);
      dof = Pack::add(
          dof, Pack::select(Pack::both(Pack::less_equal(zero, p), Pack::less_equal(p, zero)), zero, one));
      largest = Pack::max(largest, Pack::max(e, Pack::sub(zero, e)));
      finite = Pack::fma(zero, e, finite);
      if (i < 3) continue;
      map_error = Pack::add(map_error, Pack::mul(e, e));
      add(q, e, load_triple(row_of(d, lane, i)));
      map = Pack::fma(e, load_lanes(d.w + lane, i), map);
    }
    Pack::store(d.trace + lane, trace);
    Pack::store(d.dof + lane, dof);
    Pack::store(d.map_error + lane, map_error);
    Pack::store(d.largest + lane, largest);
    Pack::store(d.finite + lane, finite);
    const Triple u = whiten(load_symmetric(d.Sigma + lane), q, inverse);
    D doubt = zero;
    for (int r = 0; r < 3; ++r) {
      const D part = Pack::mul(Pack::mul(inverse.of[r], inverse.of[r]), P.load(r, r));
      doubt = Pack::add(doubt, part);  // a sum, which no maximum with what is no number can lose
    }
    Pack::store(d.doubt + lane, doubt);
    Pack::store(d.inverse_root + lane, Pack::mul(inverse.of[0], Pack::mul(inverse.of[1], inverse.of[2])));
    Pack::store(d.map_nees + lane, map);
    Pack::store(d.nees + lane, Pack::add(map, dot(u, u)));
    Symmetric pose;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) pose.at(r, c) = P.load(r, c);
    }
    const Triple own = whiten(pose, error, inverse);
    store_triple(d.vehicle_white + lane, own);
    Pack::store(d.vehicle_nees + lane, dot(own, own));
  });
}

constexpr PlanarNeesKernel kPlanarNeesKernel{&move_lanes, &start_lanes, &correct_lanes, &judge_lanes};

}  // namespace

const PlanarNeesKernel* CREDENCE_OF_SET(planar_nees_kernel)() { return &kPlanarNeesKernel; }

}  // namespace credence::internal
