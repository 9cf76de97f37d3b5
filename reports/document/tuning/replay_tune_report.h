#pragma once

#include "datasets/replay/replay_tuning.h"
#include "reports/document/document.h"

namespace credence::internal {

/// Of the innovations left out, which are tested for their mean, law, whiteness and bias at once: to which
/// side, if the mean tells; else mixed if anything else is wrong.
Verdict left_out_verdict(const ReplayTuning& tuning);

/// What `credence tune` says of a data set that is replayed (JSON: docs/formats.md): the noise that it asks
/// for, and how the filter does on parts that it was not tuned on. `score` is what it was tuned by and must
/// outlive the document: for the figure all is replayed. That takes long, and throws Stopped as the score
/// does.
Document replay_tune_document(const ReplayTuning& tuning, const ReplayScore& score);

}  // namespace credence::internal
