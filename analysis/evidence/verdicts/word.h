#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/evidence/causes/advice.h"
#include "analysis/evidence/verdicts/consistency.h"

namespace credence::internal {

/// Shares of the level that NEES, NIS, all blocks together, the directions of P, P by the σ that it claims,
/// NEES of few runs over time, and likewise NIS, have in the word, of those with data.
inline constexpr double kWordNees = 0.4, kWordNis = 0.2, kWordBlocks = 0.4, kWordDirections = 0.1,
                        kWordClaimedSigma = 0.1, kWordOverTime = 0.05;

/// What ends the name of a part that is NEES or NIS over time.
inline constexpr const char *kAtSomeTimes = " at some times", *kAtOthers = " at others";

/// One verdict on its way into the word.
struct WordPart {
  std::string name;                     ///< "NEES", "NIS", or of a block or direction
  const ConsistencyVerdict* verdict{};  ///< its p-values alone; of a direction that is no part of it NaN
  double weight = 1.0;                  ///< its share of the level
  bool says_where = false;              ///< a part of the state, which is named before the whole
  bool of_innovations = false;          ///< it judges S, all others P
  bool named_last = false;              ///< where no other part is
  std::string pessimistic_name{};       ///< that of its pessimistic side, where it is another
};

/// One verdict among those that are joined.
struct JoinedVerdict {
  std::string name;                      ///< of the part
  Verdict verdict = Verdict::undecided;  ///< when all are taken together
  double p_value = 0.0;                  ///< adjusted; NaN without data
};

/// One word over everything: NEES of the whole state, NIS, and the NEES of every block, direction and range
/// of σ.
struct Word {
  Verdict verdict = Verdict::undecided;
  double p_value = 0.0;  ///< the word is not `consistent` iff it is at most 1 − confidence; NaN without data
  std::string says;      ///< what and when: "optimistic in heading from step 40 on"
  std::vector<std::string> named{};  ///< the parts in which it is so
  bool no_factor = false;   ///< none on P mends it: a few runs or rows alone are wrong, or what was logged is
  bool of_S_alone = false;  ///< innovations reject, and nothing that judges P does
  std::vector<JoinedVerdict> joined;
};

/// Joins verdicts so that a consistent filter is called anything else with probability at most 1 −
/// confidence, whatever the dependence between them: weighted Bonferroni, with Holm's steps for the single
/// ones (joint_tests.h); what has no data leaves its part to the others. Optimistic in one part and
/// pessimistic in another is `mixed`. `undecided` where a verdict on the whole state or the innovations is
/// and no other rejects.
Word join_verdicts(std::span<const WordPart> parts, double confidence);

/// NEES, NIS and the blocks, which together have two fifths of the level, as NEES has, and NIS one fifth. Of
/// one block the whole state is that block.
std::vector<WordPart> word_parts(const ConsistencyVerdict& nees, const ConsistencyVerdict& nis,
                                 std::span<const BlockVerdict> blocks);

/// When a verdict rejects, in words: "at step 11", "in steps 1 to 3", "from step 40 on", "throughout".
std::string when_text(const ConsistencyVerdict& verdict, Verdict direction);

}  // namespace credence::internal
