#pragma once

#include <vector>

#include "analysis/evidence/sweep_analysis.h"
#include "reports/document/document.h"
#include "reports/document/study/comparison_report.h"

/// @file
/// What `credence compare` says of sweeps: each configuration beside the one with the same swept values.

namespace credence::internal {

/// The configurations of a sweep that have results.
std::vector<ComparedStudy> compared(const SweepAnalysis& sweep);

/// Whether any of these is a configuration of a sweep.
bool are_of_sweeps(const std::vector<ComparedStudy>& studies);

/// Configuration by configuration what differs from the first sweep by more than chance, Holm over all of
/// them. JSON as that of comparison_document.
Document sweep_comparison_document(const std::vector<ComparedStudy>& studies, double confidence);

}  // namespace credence::internal
