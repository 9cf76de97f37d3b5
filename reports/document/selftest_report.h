#pragma once

#include <string>
#include <vector>

#include "analysis/studies/selftest.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// Whether the tests of this build keep their rates and find what is wrong.
ReportAnswer selftest_answer(const SelftestResult& result);

/// The document of `credence selftest` (docs/formats.md).
std::string selftest_json(const SelftestResult& result);

/// False-alarm rates; what is often done instead; wrong filters; what stopping early saves.
std::vector<ReportTable> selftest_tables(const SelftestResult& result);

/// One sentence for each row that fails; empty when all is well.
std::vector<std::string> selftest_failures(const SelftestResult& result);

/// Writes DIR/index.html and the figures as SVG and PDF. Throws OutputError.
void write_selftest_report(const ReportFolder& directory, const SelftestResult& result,
                           const Provenance& provenance = make_provenance());

}  // namespace credence
