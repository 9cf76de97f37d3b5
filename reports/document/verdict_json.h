#pragma once

#include "analysis/evidence/consistency.h"
#include "analysis/evidence/word.h"
#include "reports/render/json_numbers.h"

namespace credence {

/// A verdict with everything it rests on, as docs/formats.md describes `nees` and `nis`. Internal to the
/// writers of JSON.
Json verdict_json(const ConsistencyVerdict& verdict);

/// The object `word`: the verdict over everything, and what it joins.
Json word_json(const Word& word);

}  // namespace credence
