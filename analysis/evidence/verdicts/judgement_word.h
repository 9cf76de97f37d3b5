#pragma once

#include <span>
#include <string_view>

#include "analysis/evidence/verdicts/judgement.h"

/// @file
/// The word over everything that was judged, and what leaves it open.

namespace credence::internal {

/// NEES, NIS of each sensor, its components and pairs of them, which share what NIS has, NEES and NIS over
/// time, the blocks, the directions of P, and P by the σ that it claims.
Word word_of(const Evidence& evidence, const Judgement& judged);

/// A block that the answer names is the one of which more is said.
void follow_word(const Word& word, std::span<const BlockVerdict> blocks, ResponsibleBlock& responsible);

/// Of a truth that was fitted to these errors, where the sum of NEES is least, only one thing is known: that
/// their mean NEES is no larger than where it belongs. Of one that could not be fitted nothing is.
void judge_fitted(TruthFit fit, Judgement& judged);

/// Single rows whose NEES or NIS is too large are no evidence against P where tails are heavy, if nothing
/// else accuses it.
void leave_heavy_open(const Evidence& evidence, Judgement& judged);

/// A run that failed has no rows where the filter was worst. Where many have, the others do not speak for it.
void leave_failed_open(const StudyStatistics& all, Judgement& judged);

/// A rejected row has a P, or an error, that is none. Where many are, the others do not speak for the filter.
void leave_rejected_open(const Evidence& evidence, Judgement& judged);

/// Of a state that P claims to know and that errs it is wrong, of whatever size the error is; of the others
/// the verdict is told. Where it is not estimated, as height by a filter in the plane, it belongs in no log.
void leave_certain_open(const Evidence& evidence, Judgement& judged);

/// Errors, or innovations, that are all exactly zero are a copy of the truth, or a sensor that is off, and no
/// evidence of how large P or S should be: undecided, each by itself.
void open_zero_rows(Judgement& judged);
/// The same of the word.
void leave_zeros_open(Judgement& judged);

/// Whether every NEES is the same, up to rounding: errors of a covariance scatter, and 20 rows that do not
/// are no sample of it. `nees`: of single rows.
bool are_of_one_size(const Moments& nees);
/// A mean of such errors that is right is no evidence; one that is wrong is.
void leave_one_size_open(const Evidence& evidence, Judgement& judged);

/// Without a truth a mean NIS that is right says that S is. Innovations that are not white are those of a
/// gain that is not the best one, and then the P behind it may be anything.
void leave_coloured_open(Judgement& judged);

/// No factor on P mends it, for this reason, which is a literal.
void refuse_factor(std::string_view reason, Judgement& judged);

}  // namespace credence::internal
