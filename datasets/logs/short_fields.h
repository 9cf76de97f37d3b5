#pragma once

#include <cstddef>
#include <span>

namespace credence::internal {

/// Reads numbers of a line one after another, sixteen characters at a time where the processor can: fields
/// between commas of at most 15 characters, sign and exponent not counted, by the rule of read_short_number,
/// which gives the nearest double.
///
/// They go to `fields` from `count` on, which is raised. Returns where the first field begins that is left to
/// others, or that `fields` has no room for; `line_end` + 1 where all were read. At `line_end` stands the end
/// of a line; kReadBeyond characters behind it must be readable.
const char* read_short_fields(const char* at, const char* line_end, std::span<double> fields,
                              std::size_t& count);

}  // namespace credence::internal
