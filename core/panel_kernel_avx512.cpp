#include "core/panel_kernel.h"

// Compiled with the flags of its instruction set: only intrinsics and plain headers here, everything in an
// anonymous namespace, or the linker could take an inline function of this file for the portable program.

#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512DQ__) && defined(__AVX512VL__)

#include "core/avx512_intrinsics.h"

namespace credence {
namespace {

struct Pack {
  using D = __m512d;
  static constexpr int kTile = 8;

  static D load(const double* p) { return _mm512_loadu_pd(p); }
  static void store(double* p, D x) { _mm512_storeu_pd(p, x); }
  static D broadcast(double x) { return _mm512_set1_pd(x); }
  static D mul(D a, D b) { return _mm512_mul_pd(a, b); }
  static D fma(D a, D b, D c) { return _mm512_fmadd_pd(a, b, c); }
  static D fnma(D a, D b, D c) { return _mm512_fnmadd_pd(a, b, c); }
  static bool not_negative(D x) { return _mm512_cmp_pd_mask(x, _mm512_setzero_pd(), _CMP_GE_OQ) == 0xff; }
  /// p[0], p[8], … p[56]
  static D strided(const double* p) {
    return _mm512_setr_pd(p[0], p[8], p[16], p[24], p[32], p[40], p[48], p[56]);
  }
};

#include "core/panel_kernel_body.inc"

}  // namespace

const PanelKernel* panel_kernel_avx512() {
  static constexpr PanelKernel kernel{&observe, &correct, &downdate};
  return &kernel;
}

}  // namespace credence

#else

namespace credence {

const PanelKernel* panel_kernel_avx512() { return nullptr; }

}  // namespace credence

#endif
