#include "core/panel_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX2__) && defined(__FMA__)

#include <immintrin.h>

namespace credence {
namespace {

struct Pack {
  struct D {
    __m256d low, high;
  };
  static constexpr int kTile = 4;

  static D load(const double* p) { return {_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4)}; }
  static void store(double* p, D x) {
    _mm256_storeu_pd(p, x.low);
    _mm256_storeu_pd(p + 4, x.high);
  }
  static D broadcast(double x) { return {_mm256_set1_pd(x), _mm256_set1_pd(x)}; }
  static D mul(D a, D b) { return {_mm256_mul_pd(a.low, b.low), _mm256_mul_pd(a.high, b.high)}; }
  static D fma(D a, D b, D c) {
    return {_mm256_fmadd_pd(a.low, b.low, c.low), _mm256_fmadd_pd(a.high, b.high, c.high)};
  }
  static D fnma(D a, D b, D c) {
    return {_mm256_fnmadd_pd(a.low, b.low, c.low), _mm256_fnmadd_pd(a.high, b.high, c.high)};
  }
  static bool not_negative(D x) {
    const __m256d zero = _mm256_setzero_pd();
    const __m256d both =
        _mm256_and_pd(_mm256_cmp_pd(x.low, zero, _CMP_GE_OQ), _mm256_cmp_pd(x.high, zero, _CMP_GE_OQ));
    return _mm256_movemask_pd(both) == 0xf;
  }
  /// p[0], p[8], … p[56]
  static D strided(const double* p) {
    return {_mm256_setr_pd(p[0], p[8], p[16], p[24]), _mm256_setr_pd(p[32], p[40], p[48], p[56])};
  }
};

#include "core/panel_kernel_body.inc"

}  // namespace

const PanelKernel* panel_kernel_avx2() {
  static constexpr PanelKernel kernel{&observe, &correct, &downdate};
  return &kernel;
}

}  // namespace credence

#else

namespace credence {

const PanelKernel* panel_kernel_avx2() { return nullptr; }

}  // namespace credence

#endif
