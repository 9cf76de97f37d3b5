#include "analysis/evidence/verdicts/verdict.h"

#include <ostream>

namespace credence::internal {

std::optional<Verdict> verdict_named(std::string_view word) {
  for (const Verdict verdict : {Verdict::consistent, Verdict::optimistic, Verdict::pessimistic,
                                Verdict::mixed, Verdict::not_gaussian, Verdict::undecided}) {
    if (to_string(verdict) == word) return verdict;
  }
  return std::nullopt;
}

Verdict direction_of(bool optimistic, bool pessimistic) {
  return optimistic && pessimistic ? Verdict::mixed
         : optimistic              ? Verdict::optimistic
         : pessimistic             ? Verdict::pessimistic
                                   : Verdict::consistent;
}

}  // namespace credence::internal

namespace credence {

using namespace internal;

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent: return "consistent";
    case Verdict::optimistic: return "optimistic";
    case Verdict::pessimistic: return "pessimistic";
    case Verdict::not_gaussian: return "not Gaussian";
    case Verdict::mixed: return "mixed";
    case Verdict::undecided: return "undecided";
  }
  return "undecided";
}

std::ostream& operator<<(std::ostream& out, Verdict verdict) { return out << to_string(verdict); }

}  // namespace credence
