#pragma once

/// @file
/// For sources named *_simd.cpp, which are compiled once for each instruction set
/// (cmake/CredenceTarget.cmake), with the flags of the set and one of CREDENCE_SET_SCALAR, CREDENCE_SET_AVX2
/// and CREDENCE_SET_AVX512: what the set needs, and CREDENCE_OF_SET(name), which is name_scalar, name_avx2 or
/// name_avx512.
///
/// Only plain headers and intrinsics there, everything in an anonymous namespace, or the linker could take an
/// inline function of such a source for the portable program.

#include <cstddef>
#include <cstdint>

#if defined(CREDENCE_SET_AVX512)
#if !defined(__clang__)
// g++ 12 warns of its own header (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#define CREDENCE_OF_SET(name) name##_avx512
#elif defined(CREDENCE_SET_AVX2)
#include <immintrin.h>
#define CREDENCE_OF_SET(name) name##_avx2
#else
#include <bit>
#include <cmath>

#include "core/simd/fused_multiply_add.h"
#define CREDENCE_OF_SET(name) name##_scalar
#endif
