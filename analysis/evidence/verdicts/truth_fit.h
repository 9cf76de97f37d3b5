#pragma once

namespace credence::internal {

/// How the truth of a log came to its place and time.
enum class TruthFit {
  none,        ///< as it was given, or by so little of the errors that they are as they were
  least_nees,  ///< where the mean NEES is least, which makes errors smaller by an unknown part
  not_found,   ///< it was to be fitted and could not be: where it belongs is not known
};

}  // namespace credence::internal
