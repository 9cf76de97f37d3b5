#pragma once

/// @file
/// What most sources of the tests include, compiled once; as library.h for the libraries.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cmake/precompiled/library.h"
