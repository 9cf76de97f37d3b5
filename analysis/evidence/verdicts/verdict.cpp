#include "analysis/evidence/verdicts/verdict.h"

#include <ostream>

#include "core/enum_words.h"

namespace credence::internal {

std::optional<Verdict> verdict_named(std::string_view word) { return value_named(word, Verdict::undecided); }

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
  return word_of(verdict, {"consistent", "optimistic", "pessimistic", "mixed", "not Gaussian", "undecided"});
}

std::ostream& operator<<(std::ostream& out, Verdict verdict) { return out << to_string(verdict); }

}  // namespace credence
