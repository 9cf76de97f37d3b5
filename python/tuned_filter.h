#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "python/told.h"

namespace credence::internal {

/// What the innovations of each run score with some factors, from Python: values, Σ NIS and Σ lag-one
/// products of each run; steps and components of all; whether they mean anything, and whether sensors of one
/// step are scored apart.
using PlayedScores = std::tuple<pybind11::array_t<double>, pybind11::array_t<double>,
                                pybind11::array_t<double>, double, double, bool, bool>;

/// Tunes a filter of which Python plays `runs` runs with given factors: the same noise whatever they are. An
/// exception of `play` is thrown on. Told without verdict and report.
Told tune_filter(const std::vector<std::pair<std::string, double>>& factors, std::int64_t runs,
                 double confidence, const pybind11::function& play);

}  // namespace credence::internal
