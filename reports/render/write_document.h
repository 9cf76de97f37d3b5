#pragma once

#include "reports/document/document.h"
#include "reports/document/provenance.h"
#include "reports/figures/paper_style.h"

namespace credence::internal {

/// Writes DIR/index.html, DIR/figures in the formats of the folder's style, and the files beside the page;
/// makes the folder where there is none, and waits for another process that writes a report there. The page
/// is the last that is written. Throws OutputError when a file cannot be written, and std::invalid_argument
/// for an invalid figure.
void write_document(const Document& document, const ReportFolder& directory,
                    const Provenance& provenance = make_provenance());

}  // namespace credence::internal
