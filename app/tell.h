#pragma once

#include <string>

#include "app/common_options.h"
#include "reports/document/document.h"

namespace credence::internal {

/// On stdout, as text or as JSON.
void print(const Document& document, const CommonOptions& options);

/// Into the folder of --out, if any, and where it is on stderr. command: that made it; "": this one.
void write_report(const Document& document, const CommonOptions& options, const std::string& command = {});

/// Both: print, and then write.
void tell(const Document& document, const CommonOptions& options);

}  // namespace credence::internal
