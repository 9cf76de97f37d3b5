#include "montecarlo/lanes/planar_lanes_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
#include "montecarlo/lanes/planar_lane_matrix.inc"

/// 1/√pivot; what is neither positive nor finite spoils `check`.
inline D inverse_root(D pivot, D& check) {
  const D zero = Pack::broadcast(0.0);
  const D inverse = Pack::div(Pack::broadcast(1.0), Pack::sqrt(pivot));
  check = Pack::fma(pivot, zero, Pack::fma(inverse, zero, check));
  return inverse;
}

/// Columns j … j + C − 1 of R rows: those of `source` times L⁻ᵀ, into A, the columns before them done.
template <int R, int C, class Source>
inline void solve_tile(const Source& source, const LaneMatrix& A, std::int64_t i, std::int64_t j) {
  D sum[R][C];
#pragma GCC unroll 8
  for (int c = 0; c < C; ++c) {
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) sum[r][c] = source.load(i + r, j + c);
  }
  for (std::int64_t k = 0; k < j; ++k) {
    D a[R];
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) a[r] = A.load(i + r, k);
#pragma GCC unroll 8
    for (int c = 0; c < C; ++c) {
      const D l = A.load(j + c, k);
#pragma GCC unroll 8
      for (int r = 0; r < R; ++r) sum[r][c] = Pack::fnma(a[r], l, sum[r][c]);
    }
  }
#pragma GCC unroll 8
  for (int k = 0; k < C; ++k) {
    const D inverse = A.load(j + k, j + k);
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) {
      sum[r][k] = Pack::mul(sum[r][k], inverse);
      A.store(i + r, j + k, sum[r][k]);
    }
#pragma GCC unroll 8
    for (int c = k + 1; c < C; ++c) {
      const D l = A.load(j + c, j + k);
#pragma GCC unroll 8
      for (int r = 0; r < R; ++r) sum[r][c] = Pack::fnma(sum[r][k], l, sum[r][c]);
    }
  }
}

/// R rows of the first `end` columns (even), whose triangle is factored: those of `source` times L⁻ᵀ, into A.
template <int R, class Source>
inline void solve_rows(const Source& source, const LaneMatrix& A, std::int64_t i, std::int64_t end) {
  constexpr int C = Pack::kLanes == 8 ? 4 : 2;  // as many sums as there are registers for
  std::int64_t j = 0;
  for (; j + C <= end; j += C) solve_tile<R, C>(source, A, i, j);
  for (; j < end; j += 2) solve_tile<R, 2>(source, A, i, j);
}

/// The R×R block on the diagonal at i, the columns before it done: its factor.
template <int R, class Source>
inline void factor_block(const Source& source, const LaneMatrix& A, std::int64_t i, D& check) {
  D sum[R][R];
#pragma GCC unroll 8
  for (int r = 0; r < R; ++r) {
#pragma GCC unroll 8
    for (int c = 0; c < r; ++c) sum[r][c] = source.load(i + r, i + c);
    sum[r][r] = source.diagonal(i + r);
  }
  for (std::int64_t k = 0; k < i; ++k) {
    D a[R];
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) a[r] = A.load(i + r, k);
#pragma GCC unroll 8
    for (int r = 0; r < R; ++r) {
#pragma GCC unroll 8
      for (int c = 0; c <= r; ++c) sum[r][c] = Pack::fnma(a[r], a[c], sum[r][c]);
    }
  }
#pragma GCC unroll 8
  for (int c = 0; c < R; ++c) {
    const D inverse = inverse_root(sum[c][c], check);
    A.store(i + c, i + c, inverse);
#pragma GCC unroll 8
    for (int r = c + 1; r < R; ++r) {
      sum[r][c] = Pack::mul(sum[r][c], inverse);
      A.store(i + r, i + c, sum[r][c]);
#pragma GCC unroll 8
      for (int k = c + 1; k <= r; ++k) sum[r][k] = Pack::fnma(sum[r][c], sum[k][c], sum[r][k]);
    }
  }
}

/// The first `columns` (even) rows of `source` are a symmetric matrix; those of A become its Cholesky factor
/// L with the inverse of its diagonal, and the rows below those of `below` times L⁻ᵀ. Both may be A.
template <class Source, class Below>
inline D factor(const Source& source, const Below& below, const LaneMatrix& A, std::int64_t columns) {
  constexpr int R = Pack::kLanes > 1 ? 4 : 2;
  D check = Pack::broadcast(0.0);
  std::int64_t i = 0;
  for (; i + R <= columns; i += R) {
    solve_rows<R>(source, A, i, i);
    factor_block<R>(source, A, i, check);
  }
  for (; i < columns; i += 2) {
    solve_rows<2>(source, A, i, i);
    factor_block<2>(source, A, i, check);
  }
  for (i = columns; i + 4 <= A.rows; i += 4) solve_rows<4>(below, A, i, columns);
  for (; i < A.rows; ++i) solve_rows<1>(below, A, i, columns);
  return check;
}

void predict_lanes(const PlanarLanesData& d, const double* F_lanes, const double* Q_lanes) {
  for_packs([&](int lane) {
    const LaneMatrix P{d.P + lane, d.padded};
    D F[3][3], T[3][3];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) F[r][c] = load_lanes(F_lanes + lane, 3 * r + c);
    }
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        T[r][c] = Pack::mul(F[r][0], P.symmetric(0, c));
        T[r][c] = Pack::fma(F[r][1], P.symmetric(1, c), T[r][c]);
        T[r][c] = Pack::fma(F[r][2], P.symmetric(2, c), T[r][c]);
      }
    }
    for (int r = 0, q = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c, ++q) {
        D sum = load_lanes(Q_lanes + lane, q);
        for (int k = 0; k < 3; ++k) sum = Pack::fma(T[r][k], F[c][k], sum);
        P.store(r, c, sum);
      }
    }
    for (std::int64_t i = 3; i < d.states; ++i) {
      const D p0 = P.load(i, 0), p1 = P.load(i, 1), p2 = P.load(i, 2);
      for (int r = 0; r < 3; ++r) {
        P.store(i, r, Pack::fma(F[r][2], p2, Pack::fma(F[r][1], p1, Pack::mul(F[r][0], p0))));
      }
    }
  });
}

void decorrelate_lanes(const PlanarLanesData& d) {
  for_packs([&](int lane) {
    const LaneMatrix P{d.P + lane, d.padded};
    const D zero = Pack::broadcast(0.0), one = Pack::broadcast(1.0);
    const auto add = [&P](std::int64_t i, std::int64_t j, D x) { P.store(i, j, Pack::add(P.load(i, j), x)); };
    for (std::int64_t k = 3; k + 1 < d.states; k += 2) {
      for (std::int64_t i = k + 2; i + 1 < d.states; i += 2) {
        const D a = P.load(i, k), b = P.load(i, k + 1), c = P.load(i + 1, k), e = P.load(i + 1, k + 1);
        // The orthogonal polar factor U of C = [a b; c e] is [p q; −s q, s p], s the sign of det C.
        const D minus = Pack::broadcast(-1.0);
        const D s = Pack::select(Pack::less(Pack::mul(a, e), Pack::mul(b, c)), minus, one);
        D p = Pack::fma(s, e, a), q = Pack::fnma(s, c, b);
        const D norm = Pack::sqrt(Pack::fma(p, p, Pack::mul(q, q)));
        const D inverse = Pack::select(Pack::less(zero, norm), Pack::div(one, norm), zero);
        p = Pack::mul(p, inverse);
        q = Pack::mul(q, inverse);
        const D r = Pack::mul(Pack::sub(zero, s), q), t = Pack::mul(s, p);
        add(i, i, Pack::fma(b, q, Pack::mul(a, p)));  // C Uᵀ
        add(i + 1, i, Pack::fma(e, q, Pack::mul(c, p)));
        add(i + 1, i + 1, Pack::fma(e, t, Pack::mul(c, r)));
        add(k, k, Pack::fma(r, c, Pack::mul(p, a)));  // Uᵀ C
        add(k + 1, k, Pack::fma(t, c, Pack::mul(q, a)));
        add(k + 1, k + 1, Pack::fma(t, e, Pack::mul(q, b)));
        for (std::int64_t u = i; u < i + 2; ++u) {
          P.store(u, k, zero);
          P.store(u, k + 1, zero);
        }
      }
    }
  });
}

void linearise_lanes(const PlanarLanesData& d) {
  for_packs([&](int lane) {
    const D x = load_lanes(d.x + lane, 0), y = load_lanes(d.x + lane, 1);
    const D zero = Pack::broadcast(0.0), one = Pack::broadcast(1.0);
    for (std::int64_t b = 0; b < d.measured; ++b) {
      const D dx = Pack::sub(load_lanes(d.place[b] + lane, 0), x);
      const D dy = Pack::sub(load_lanes(d.place[b] + lane, 1), y);
      const D q = Pack::fma(dx, dx, Pack::mul(dy, dy));
      const D range = Pack::sqrt(q), over_range = Pack::div(one, range), over_q = Pack::div(one, q);
      double* difference = d.difference + 3 * b * kPlanarLanes + lane;
      store_lanes(difference, 0, dx);
      store_lanes(difference, 1, dy);
      store_lanes(difference, 2, range);
      const D c = Pack::mul(dx, over_range), s = Pack::mul(dy, over_range);
      const D u = Pack::mul(dy, over_q), v = Pack::mul(dx, over_q);
      double* H = d.H + 10 * b * kPlanarLanes + lane;
      const D rows[10] = {Pack::sub(zero, c),
                          Pack::sub(zero, s),
                          zero,
                          u,
                          Pack::sub(zero, v),
                          Pack::sub(zero, one),
                          c,
                          s,
                          Pack::sub(zero, u),
                          v};
      for (int i = 0; i < 10; ++i) store_lanes(H, i, rows[i]);
    }
  });
}

void innovate_lanes(const PlanarLanesData& d) {
  const std::int64_t m = 2 * d.measured, last = m + d.padded;
  for_packs([&](int lane) {
    const LaneMatrix P{d.P + lane, d.padded}, A{d.A + lane, last + 1};
    const D zero = Pack::broadcast(0.0);
    for (std::int64_t b = 0; b < d.measured; ++b) {
      const Jacobian J = load_jacobian(d.H + 10 * b * kPlanarLanes + lane);
      const std::int64_t at = d.offset[b];
      const bool anchor = at < 0;
      for (std::int64_t i = 0; i < d.states; ++i) {
        const D v[5] = {P.symmetric(i, 0), P.symmetric(i, 1), P.symmetric(i, 2),
                        anchor ? zero : P.symmetric(i, at), anchor ? zero : P.symmetric(i, at + 1)};
        A.store(m + i, 2 * b, apply(J, 0, v, anchor));
        A.store(m + i, 2 * b + 1, apply(J, 1, v, anchor));
      }
      for (int i = 0; i < 2; ++i) {
        for (std::int64_t p = d.states; p < d.padded; ++p) A.store(m + p, 2 * b + i, zero);
        A.store(last, 2 * b + i, load_lanes(d.nu + lane, 2 * b + i));
      }
    }
    for (std::int64_t b = 0; b < d.measured; ++b) {
      const Jacobian J = load_jacobian(d.H + 10 * b * kPlanarLanes + lane);
      const std::int64_t at = d.offset[b];
      const bool anchor = at < 0;
      for (std::int64_t j = 0; j < 2 * b + 2; ++j) {
        const D v[5] = {A.load(m, j), A.load(m + 1, j), A.load(m + 2, j), anchor ? zero : A.load(m + at, j),
                        anchor ? zero : A.load(m + at + 1, j)};
        A.store(2 * b, j, apply(J, 0, v, anchor));
        A.store(2 * b + 1, j, apply(J, 1, v, anchor));
      }
      for (std::int64_t i = 2 * b; i < 2 * b + 2; ++i) {
        const D variance = Pack::add(A.load(i, i), load_lanes(d.R + lane, i));
        A.store(i, i, variance);
        store_lanes(d.innovation_covariance + lane, 3 * b + i % 2, variance);
      }
      store_lanes(d.innovation_covariance + lane, 3 * b + 2, A.load(2 * b + 1, 2 * b));
    }
    Pack::store(d.check + lane, factor(A, A, A, m));
    D nis = zero;
    for (std::int64_t j = 0; j < m; ++j) {
      const D y = A.load(last, j);
      nis = Pack::fma(y, y, nis);
    }
    Pack::store(d.nis + lane, nis);
  });
}

void correct_lanes(const PlanarLanesData& d) {
  // As many sums as there are registers for, with those that a column of each side needs.
  constexpr int kRows = Pack::kLanes == 8 ? 4 : 2, kColumns = 4;
  const std::int64_t m = 2 * d.measured, last = m + d.padded;
  for_packs([&](int lane) {
    const LaneMatrix P{d.P + lane, d.padded}, A{d.A + lane, last + 1};
    for (std::int64_t i = 0; i < d.padded; i += kRows) {
      D x[kRows];
#pragma GCC unroll 8
      for (int r = 0; r < kRows; ++r) x[r] = load_lanes(d.x + lane, i + r);
      for (std::int64_t k = 0; k < m; ++k) {
        const D y = A.load(last, k);
#pragma GCC unroll 8
        for (int r = 0; r < kRows; ++r) x[r] = Pack::fma(A.load(m + i + r, k), y, x[r]);
      }
#pragma GCC unroll 8
      for (int r = 0; r < kRows; ++r) store_lanes(d.x + lane, i + r, x[r]);
      // Tiles on the diagonal reach above it, where nobody reads.
      for (std::int64_t j = 0; j < i + kRows; j += kColumns) {
        D sum[kRows][kColumns];
#pragma GCC unroll 8
        for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
          for (int c = 0; c < kColumns; ++c) sum[r][c] = P.load(i + r, j + c);
        }
        for (std::int64_t k = 0; k < m; ++k) {
          D w[kRows];
#pragma GCC unroll 8
          for (int r = 0; r < kRows; ++r) w[r] = A.load(m + i + r, k);
#pragma GCC unroll 8
          for (int c = 0; c < kColumns; ++c) {
            const D v = A.load(m + j + c, k);
#pragma GCC unroll 8
            for (int r = 0; r < kRows; ++r) sum[r][c] = Pack::fnma(w[r], v, sum[r][c]);
          }
        }
#pragma GCC unroll 8
        for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
          for (int c = 0; c < kColumns; ++c) P.store(i + r, j + c, sum[r][c]);
        }
      }
    }
  });
}

/// The squared lengths of columns c … c + C − 1 of L⁻¹, which are diagonal entries of S⁻¹, times R.
template <int C>
inline D add_columns(const PlanarLanesData& d, const LaneMatrix& A, int lane, std::int64_t c, D share) {
  const std::int64_t m = 2 * d.measured;
  const LaneMatrix X{d.columns + lane, C};  // row i of L⁻¹ is column i
  D squares[C];
#pragma GCC unroll 8
  for (int q = 0; q < C; ++q) squares[q] = Pack::broadcast(0.0);
  for (std::int64_t i = c; i < m; ++i) {
    D x[C];
#pragma GCC unroll 8
    for (int q = 0; q < C; ++q) x[q] = Pack::broadcast(i == c + q ? 1.0 : 0.0);
    for (std::int64_t k = c; k < i; ++k) {
      const D l = A.load(i, k);
#pragma GCC unroll 8
      for (int q = 0; q < C; ++q) x[q] = Pack::fnma(l, X.load(q, k), x[q]);
    }
    const D inverse = A.load(i, i);
#pragma GCC unroll 8
    for (int q = 0; q < C; ++q) {
      x[q] = Pack::mul(x[q], inverse);
      X.store(q, i, x[q]);
      squares[q] = Pack::fma(x[q], x[q], squares[q]);
    }
  }
#pragma GCC unroll 8
  for (int q = 0; q < C; ++q) share = Pack::fma(squares[q], load_lanes(d.R + lane, c + q), share);
  return share;
}

void share_noise_lanes(const PlanarLanesData& d) {
  const std::int64_t m = 2 * d.measured;
  for_packs([&](int lane) {
    const LaneMatrix A{d.A + lane, m + d.padded + 1};
    D share = Pack::broadcast(0.0), doubt = share;
    std::int64_t c = 0;
    for (; c + 4 <= m; c += 4) share = add_columns<4>(d, A, lane, c, share);
    for (; c < m; c += 2) share = add_columns<2>(d, A, lane, c, share);
    for (std::int64_t i = 0; i < m; ++i) {
      const D inverse = A.load(i, i);
      D sum = Pack::broadcast(0.0);
      for (std::int64_t k = 0; k < i; ++k) sum = Pack::fma(A.load(i, k), A.load(i, k), sum);
      doubt = Pack::max(doubt, Pack::fma(sum, Pack::mul(inverse, inverse), Pack::broadcast(1.0)));
    }
    Pack::store(d.share + lane, share);
    Pack::store(d.doubt + lane, doubt);
  });
}

/// P with another diagonal.
struct NeesSource {
  LaneMatrix P;
  const double* of_diagonal;

  D load(std::int64_t i, std::int64_t j) const { return P.load(i, j); }
  D diagonal(std::int64_t i) const { return load_lanes(of_diagonal, i); }
};

/// What stands below it: the error and the first three unit vectors.
struct NeesBelow {
  const double* error;
  std::int64_t first;  ///< row

  D load(std::int64_t i, std::int64_t j) const {
    return i == first ? load_lanes(error, j) : Pack::broadcast(i - first - 1 == j ? 1.0 : 0.0);
  }
};

void nees_lanes(const PlanarLanesNees& d) {
  for_packs([&](int lane) {
    const LaneMatrix L{d.L + lane, d.padded + d.below};
    const NeesSource source{{const_cast<double*>(d.P) + lane, d.padded}, d.diagonal + lane};
    Pack::store(d.check + lane, factor(source, NeesBelow{d.error + lane, d.padded}, L, d.padded));
    D nees = Pack::broadcast(0.0), doubt = nees;
    for (std::int64_t j = 0; j < d.padded; ++j) {
      const D y = L.load(d.padded, j), inverse = L.load(j, j);
      doubt = Pack::max(doubt, Pack::mul(Pack::mul(inverse, inverse), load_lanes(d.diagonal + lane, j)));
      nees = Pack::fma(y, y, nees);
      if (j == 2) Pack::store(d.vehicle_nees + lane, nees);
    }
    Pack::store(d.nees + lane, nees);
    Pack::store(d.doubt + lane, doubt);
  });
}

/// The least squares of u − G c over c: with G = L⁻¹ [I; 0] the NEES of the states below, their block of P
/// marginal. J = Gᵀ G, y = Gᵀ u.
inline D least_squares(D squares, const D (&J)[3][3], const D (&y)[3]) {
  D l[3][3], x[3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) {
      D sum = J[r][c];
      for (int k = 0; k < c; ++k) sum = Pack::fnma(l[r][k], l[c][k], sum);
      // The inverse on the diagonal.
      l[r][c] = c < r ? Pack::mul(sum, l[c][c]) : Pack::div(Pack::broadcast(1.0), Pack::sqrt(sum));
    }
    D sum = y[r];
    for (int k = 0; k < r; ++k) sum = Pack::fnma(l[r][k], x[k], sum);
    x[r] = Pack::mul(sum, l[r][r]);
    squares = Pack::fnma(x[r], x[r], squares);
  }
  return squares;
}

void normalise_lanes(const PlanarLanesNees& d) {
  for_packs([&](int lane) {
    const LaneMatrix L{d.L + lane, d.padded + d.below};
    const D zero = Pack::broadcast(0.0);
    D J[3][3], y[3];
    for (int r = 0; r < 3; ++r) {
      y[r] = zero;
      for (int c = 0; c < 3; ++c) J[r][c] = zero;
    }
    for (std::int64_t j = 0; j < d.padded; ++j) {
      const D u = L.load(d.padded, j);
      D g[3];
      for (int r = 0; r < 3; ++r) g[r] = L.load(d.padded + 1 + r, j);
      for (int r = 0; r < 3; ++r) {
        y[r] = Pack::fma(g[r], u, y[r]);
        for (int c = 0; c <= r; ++c) J[r][c] = Pack::fma(g[r], g[c], J[r][c]);
      }
    }
    Pack::store(d.map_nees + lane, least_squares(load_lanes(d.nees + lane, 0), J, y));
  });
}

void landmark_nees_lanes(const PlanarLanesData& d, const double* error, double* nees) {
  for_packs([&](int lane) {
    const LaneMatrix P{d.P + lane, d.padded};
    for (std::int64_t i = 3, l = 0; i + 1 < d.states; i += 2, ++l) {
      const D e = load_lanes(error + lane, i), inverse = Pack::div(Pack::broadcast(1.0), P.load(i, i));
      const D ratio = Pack::mul(P.load(i + 1, i), inverse);
      const D rest = Pack::fnma(ratio, P.load(i + 1, i), P.load(i + 1, i + 1));
      const D v = Pack::fnma(ratio, e, load_lanes(error + lane, i + 1));
      store_lanes(nees + lane, l, Pack::fma(Pack::mul(e, e), inverse, Pack::div(Pack::mul(v, v), rest)));
    }
  });
}

constexpr PlanarLanesKernel kPlanarLanesKernel{&predict_lanes,  &decorrelate_lanes, &linearise_lanes,
                                               &innovate_lanes, &correct_lanes,     &share_noise_lanes,
                                               &nees_lanes,     &normalise_lanes,   &landmark_nees_lanes};

}  // namespace

const PlanarLanesKernel* CREDENCE_OF_SET(planar_lanes_kernel)() { return &kPlanarLanesKernel; }

}  // namespace credence::internal
