// What this machine can do at most, so that every other figure reads as a share of it: multiply-adds from
// registers, and reading and writing memory in place.

#include <benchmark/benchmark.h>

#include <new>

#include "core/simd/cpu_dispatch.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace credence::internal {
namespace {

constexpr std::int64_t kRounds = 4096;

// More chains than latency times throughput of any machine so far, and no more than there are registers.
#if defined(__x86_64__)
__attribute__((target("avx512f"))) std::int64_t multiply_adds_avx512(double* out) {
  constexpr int kChains = 16;
  __m512d x[kChains];
  for (int i = 0; i < kChains; ++i) x[i] = _mm512_set1_pd(i);
  const __m512d a = _mm512_set1_pd(0.999), b = _mm512_set1_pd(1e-3);
  for (std::int64_t k = 0; k < kRounds; ++k) {
    for (int i = 0; i < kChains; ++i) x[i] = _mm512_fmadd_pd(x[i], a, b);
  }
  for (int i = 0; i < kChains; ++i) _mm512_storeu_pd(out + 8 * i, x[i]);
  return kRounds * kChains * 8;
}

__attribute__((target("avx2,fma"))) std::int64_t multiply_adds_avx2(double* out) {
  constexpr int kChains = 12;
  __m256d x[kChains];
  for (int i = 0; i < kChains; ++i) x[i] = _mm256_set1_pd(i);
  const __m256d a = _mm256_set1_pd(0.999), b = _mm256_set1_pd(1e-3);
  for (std::int64_t k = 0; k < kRounds; ++k) {
    for (int i = 0; i < kChains; ++i) x[i] = _mm256_fmadd_pd(x[i], a, b);
  }
  for (int i = 0; i < kChains; ++i) _mm256_storeu_pd(out + 4 * i, x[i]);
  return kRounds * kChains * 4;
}

__attribute__((target("avx512f"))) void scale_avx512(double* x, std::int64_t count) {
  const __m512d a = _mm512_set1_pd(1.0000001);
  for (std::int64_t i = 0; i < count; i += 16) {
    _mm512_store_pd(x + i, _mm512_mul_pd(_mm512_load_pd(x + i), a));
    _mm512_store_pd(x + i + 8, _mm512_mul_pd(_mm512_load_pd(x + i + 8), a));
  }
}

__attribute__((target("avx2"))) void scale_avx2(double* x, std::int64_t count) {
  const __m256d a = _mm256_set1_pd(1.0000001);
  for (std::int64_t i = 0; i < count; i += 16) {
    for (int j = 0; j < 16; j += 4) {
      _mm256_store_pd(x + i + j, _mm256_mul_pd(_mm256_load_pd(x + i + j), a));
    }
  }
}
#endif

/// Items are multiply-adds of doubles.
void multiply_adds(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  double out[128];
  std::int64_t done = 0;
  for (auto _ : state) {
#if defined(__x86_64__)
    done += set == InstructionSet::avx512 ? multiply_adds_avx512(out) : multiply_adds_avx2(out);
#endif
    benchmark::DoNotOptimize(out);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(done);
}
BENCHMARK_CAPTURE(multiply_adds, avx2, InstructionSet::avx2);
BENCHMARK_CAPTURE(multiply_adds, avx512, InstructionSet::avx512);

/// Reads and writes so many doubles in place; those of one triangle of P for N landmarks in the plane.
void stream_triangle(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const std::int64_t n = 3 + 2 * state.range(0);
  const std::int64_t count = (n * (n + 1) / 2 + 15) / 16 * 16;
  auto* x = static_cast<double*>(::operator new (static_cast<std::size_t>(count) * 8, std::align_val_t{64}));
  for (std::int64_t i = 0; i < count; ++i) x[i] = 1.0;
  for (auto _ : state) {
#if defined(__x86_64__)
    set == InstructionSet::avx512 ? scale_avx512(x, count) : scale_avx2(x, count);
#endif
    benchmark::DoNotOptimize(x);
    benchmark::ClobberMemory();
  }
  ::operator delete (x, std::align_val_t{64});
  state.SetItemsProcessed(state.iterations() * count);
  state.SetBytesProcessed(state.iterations() * count * 16);
}
BENCHMARK_CAPTURE(stream_triangle, avx2, InstructionSet::avx2)->Arg(100)->Arg(500)->Arg(1000);
BENCHMARK_CAPTURE(stream_triangle, avx512, InstructionSet::avx512)->Arg(100)->Arg(500)->Arg(1000);

}  // namespace
}  // namespace credence::internal
