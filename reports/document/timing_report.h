#pragma once

#include <string>
#include <vector>

#include "analysis/studies/filter_timing.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/paper_style.h"

namespace credence {

/// How the time of a step grows with the map, and from where on the O(N) filter is the faster one.
ReportAnswer timing_answer(const TimingResult& result);

/// The document of `credence timing --format json` (docs/formats.md).
std::string timing_json(const TimingResult& result);

/// Steps, growth with the map, Monte Carlo, threads.
std::vector<ReportTable> timing_tables(const TimingResult& result);

/// Writes index.html, timing.json and the figures into `directory`. Throws OutputError as AtomicFile does.
void write_timing_report(const ReportFolder& directory, const TimingResult& result,
                         const Provenance& provenance = make_provenance());

}  // namespace credence
