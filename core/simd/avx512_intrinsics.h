#pragma once

/// @file
/// <immintrin.h> for sources that are compiled for AVX-512.

#if !defined(__clang__)
// g++ 12 warns of its own header (GCC bug 105593)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
