#pragma once

#include <iosfwd>
#include <optional>
#include <string_view>

namespace credence {

/// What the data say about a covariance.
enum class Verdict {
  consistent,    ///< nothing against it at this confidence
  optimistic,    ///< errors larger than P says: the statistic is too high
  pessimistic,   ///< errors smaller than P says: the statistic is too low
  mixed,         ///< both, at different steps or in different parts of the state
  not_gaussian,  ///< the covariance is right, the law is not χ²: heavy tails
  undecided,     ///< not testable, see the reason
};

/// "consistent", "optimistic", "pessimistic", "mixed", "not Gaussian" or "undecided".
std::string_view to_string(Verdict verdict);
/// Prints this word, also in a message of a test.
std::ostream& operator<<(std::ostream& out, Verdict verdict);

/// Whether the data speak against the covariance, in either direction.
inline bool is_inconsistent(Verdict verdict) {
  return verdict == Verdict::optimistic || verdict == Verdict::pessimistic || verdict == Verdict::mixed;
}

}  // namespace credence

namespace credence::internal {

/// Whether P is too small somewhere, so that whoever trusts it is not safe.
inline bool is_unsafe(Verdict verdict) { return verdict == Verdict::optimistic || verdict == Verdict::mixed; }

/// The verdict of this word, if it is one.
std::optional<Verdict> verdict_named(std::string_view word);

/// The verdict of what each direction rejects.
Verdict direction_of(bool optimistic, bool pessimistic);

}  // namespace credence::internal
