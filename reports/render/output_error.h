#pragma once

#include <stdexcept>

namespace credence {

/// An output file cannot be written; the message names the path and the reason.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace credence
