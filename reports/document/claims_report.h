#pragma once

#include <span>
#include <string>

#include "analysis/studies/claims.h"
#include "reports/document/provenance.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// The document of `credence claims` (docs/formats.md).
std::string claims_json(std::span<const Claim> claims);

/// For a terminal: one paragraph a claim, and how many hold.
std::string claims_text(std::span<const Claim> claims);

/// Writes DIR/index.html; OutputError when it cannot be written.
void write_claims_report(const ReportFolder& directory, std::span<const Claim> claims,
                         const Provenance& provenance = make_provenance());

}  // namespace credence
