#pragma once

#include "analysis/evidence/verdicts/judgement.h"
#include "reports/document/logs/log_report.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// How the factors on P and S that mean NEES and NIS of each part ask for differ from those of an earlier
/// document of `check`, into `gate`: by the bounds of the means [Zou 2008], as of independent logs; Holm over
/// the parts. Throws Json::exception where the document holds something else under their names.
void compare_means(const Judgement& now, const Json& before, LogGate& gate);

}  // namespace credence::internal
