#pragma once

#include <string>
#include <vector>

#include "analysis/studies/selftest.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What `credence selftest` says (JSON: docs/formats.md): whether the tests of this build keep their
/// false-alarm rates and find filters that are wrong, what is often done instead, and what stopping early
/// saves.
Document selftest_document(const SelftestResult& result);

/// One sentence for each row that fails; empty when all is well.
std::vector<std::string> selftest_failures(const SelftestResult& result);

}  // namespace credence::internal
