#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "core/filters/estimators/slam_estimator.h"

/// @file
/// The list of estimators. A new one is a pair of files and a line in estimators.cpp.

namespace credence::internal {

struct EstimatorKind {
  std::string_view name;     ///< its word in filter.estimator
  std::string_view meaning;  ///< in a few words
  std::unique_ptr<SlamEstimator> (*make)(const EstimatorSettings&);
  /// Makes one of them, of the same settings, what another is.
  void (*assign)(SlamEstimator& to, const SlamEstimator& from);
};

std::span<const EstimatorKind> estimator_kinds();

/// Throws std::invalid_argument for a name that no estimator has.
const EstimatorKind& estimator_kind(std::string_view name);

/// Throws std::invalid_argument for a name that no estimator has, and what its constructor throws.
std::unique_ptr<SlamEstimator> make_estimator(std::string_view name, const EstimatorSettings& settings);

}  // namespace credence::internal
