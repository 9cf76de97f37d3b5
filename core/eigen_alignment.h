#pragma once

#include <Eigen/Core>

/// @file
/// What the library and a program that links it must agree on, whatever instruction set each is compiled for.
///
/// Eigen takes the alignment of its memory, and with it malloc or an allocator of its own, from the
/// instruction set: a vector that one side allocated could not be freed by the other. The targets of CMake
/// pass these definitions on: dynamic memory is aligned for every instruction set, members of fixed size as
/// they are without AVX.

#if EIGEN_MAX_ALIGN_BYTES != 64 || EIGEN_MAX_STATIC_ALIGN_BYTES != 16 || EIGEN_MALLOC_ALREADY_ALIGNED != 0
#error Credence needs EIGEN_MAX_ALIGN_BYTES=64, EIGEN_MAX_STATIC_ALIGN_BYTES=16 and EIGEN_MALLOC_ALREADY_ALIGNED=0 in \
every source that uses it: link a target Credence::..., or define them before the first header of Eigen
#endif
