#pragma once

namespace credence::internal {

/// The power with which the runs that settle a case would settle it (settle_nees and settle_nis of
/// Judgement).
inline constexpr double kSettlingPower = 0.9;

}  // namespace credence::internal
