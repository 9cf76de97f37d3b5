#pragma once

#include <span>

#include "reports/document/comparison_report.h"
#include "reports/document/provenance.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// Which of the studies cannot be trusted, and whose factor on P is nearest to one.
ReportAnswer comparison_answer(std::span<const ComparedStudy> studies);

/// Writes DIR/index.html: the answer, the table that sorts, NEES and NIS over their dof step by step for all
/// studies, and the differences of runs that met the same noise; the figures as SVG and PDF in DIR/figures.
/// Throws OutputError when a file cannot be written.
void write_comparison_report(const ReportFolder& directory, std::span<const ComparedStudy> studies,
                             double confidence, const Provenance& provenance);

}  // namespace credence
