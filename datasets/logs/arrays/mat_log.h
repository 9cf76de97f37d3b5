#pragma once

#include "datasets/logs/log_format.h"

namespace credence::internal {

/// --input mat: arrays (array_log.h) in a MAT-file of version 5, that is of MATLAB's save -v6 and -v7: as
/// variables, or as fields of a variable that is a structure.
///
/// Format: "MAT-File Format", The MathWorks, chapter 1 (level 5). Numbers of any real type, either byte
/// order; packed variables up to 1 GiB each. MATLAB leaves out last dimensions of 1.
LogFormat mat_format();

}  // namespace credence::internal
