#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "montecarlo/engine/experiment.h"

/// @file
/// What can be wrong with a plugged world or filter, and would otherwise be taken for an inconsistency.

namespace credence::internal {

/// What a world or filter shows does not have the dimensions of the layout: a mistake of the plug, and no
/// failure of the filter.
struct PlugMisfit : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// What was thrown in a run, and whether it was a PlugMisfit.
struct PlugThrown {
  std::string said;
  bool misfit = false;
};

/// Throws PlugMisfit naming the numbers where error, P or the innovations of a step do not have the
/// dimensions of the layout.
void require_fit(const RunLayout& layout, const TraceStep& step);

/// Throws PlugMisfit where an estimate has not as many states as it should.
void require_size(Index estimate, Index expected);

/// Throws PlugMisfit for a state that the layout has not, or that is there twice.
void require_states(const RunLayout& layout, const std::vector<Index>& states);

/// Plays the first runs, fewer of many steps, and tells, in sentences: a run that is not the same twice, of
/// its first 10,000 steps; a P or S that is not symmetric, a P that is not positive semidefinite, an S that
/// is not positive definite; an error or innovation of an angle beyond half a turn; a filter that throws at
/// once in every one of them, or a misfit at any step, with what was `thrown`.
std::vector<std::string> plug_problems(const Experiment& experiment,
                                       const std::function<PlugThrown(std::int64_t run)>& thrown = {});

/// Whether two plays of a step show the same bits.
bool same_step(const TraceStep& a, const TraceStep& b);

/// Adds a sentence unless minus(plus(x, d), x), which is `back`, is d.
void report_plus(const Vector& d, const Vector& back, std::vector<std::string>& problems);

/// Adds a sentence: two filters that are at work by turns change each other, from this step on.
void report_shared_state(std::int64_t step, std::vector<std::string>& problems);

/// Adds a sentence where two predictions of half a step give far more variance than one of the whole:
/// `once` and `twice` are the diagonals of P, from P = 0. A process noise of white noise in continuous time
/// gives the same.
void report_time_step(const Vector& once, const Vector& twice, std::vector<std::string>& problems);

/// The sentences as one std::invalid_argument, if there are any.
void require_sound(const std::vector<std::string>& problems);

}  // namespace credence::internal
