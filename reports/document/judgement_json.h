#pragma once

#include "analysis/evidence/judgement.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// The object `battery` of a study or of logs (docs/formats.md).
Json judgement_json(const Judgement& judgement);

}  // namespace credence::internal
