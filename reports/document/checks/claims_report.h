#pragma once

#include <vector>

#include "analysis/studies/claims.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence claims` says (JSON: docs/formats.md): every claim with its evidence, and how many hold.
Document claims_document(const std::vector<Claim>& claims);

}  // namespace credence::internal
