#pragma once

/// @file
/// What most sources of the tests include, compiled once; as library.h for the libraries. With Eigen's
/// decompositions declared before any test asks for one, none is instantiated in a unit of tests again: that
/// is a third of what those of core/ cost.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "cmake/precompiled/library.h"
#include "core/linear_algebra/decompositions.h"
