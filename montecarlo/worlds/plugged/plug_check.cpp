#include "montecarlo/worlds/plugged/plug_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/psd_root.h"
#include "core/linear_algebra/symmetry.h"
#include "core/record/unwrapped_angles.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kRunsLookedAt = 4;
constexpr std::int64_t kStepsLookedAt = 400'000;  // of all runs
constexpr std::size_t kStepsCompared = 10'000;

/// Sentences, each kind once.
class Problems {
 public:
  void add(const std::string& kind, const std::string& sentence) {
    if (seen_.insert(kind).second) sentences_.push_back(sentence);
  }
  std::vector<std::string> take() { return std::move(sentences_); }

 private:
  std::set<std::string> seen_;
  std::vector<std::string> sentences_;
};

void check_symmetry(const std::string& name, const Matrix& M, const std::string& where, Problems& problems) {
  if (!M.allFinite()) return problems.add(name, fmt::format("{} is not finite {}", name, where));
  for (Index i = 0; i < M.rows(); ++i) {
    for (Index j = i + 1; j < M.cols(); ++j) {
      const double scale = std::sqrt(std::abs(M(i, i) * M(j, j)));
      if (std::abs(M(i, j) - M(j, i)) <= kMostAsymmetry * scale) continue;
      return problems.add(
          name, fmt::format("{} is not symmetric {}: its entries ({}, {}) and ({}, {}) are {} and {}", name,
                            where, i, j, j, i, M(i, j), M(j, i)));
    }
  }
}

/// P may be singular: of a direction that is known nothing is asked.
void check_covariance(const Matrix& P, const std::string& where, Problems& problems) {
  check_symmetry("P", P, where, problems);
  if (!is_psd(P)) problems.add("P", fmt::format("P is not positive semidefinite {}", where));
}

void check_innovation_covariance(const std::string& name, const Matrix& S, const std::string& where,
                                 Problems& problems) {
  check_symmetry(name, S, where, problems);
  if (Eigen::LLT<Matrix>(S).info() == Eigen::Success) return;
  problems.add(name, fmt::format("{} is not positive definite {}", name, where));
}

void check_step(const RunLayout& layout, const TraceStep& step, const std::string& where,
                Problems& problems) {
  check_covariance(step.P, where, problems);
  for (Index i = 0; i < step.error.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const std::size_t state = step.states.empty() ? at : static_cast<std::size_t>(step.states[at]);
    if (!std::isfinite(step.error[i])) {
      problems.add("finite", fmt::format("the error of '{}' is {} {}: the filter's mean, its prior or what "
                                         "minus() makes of it is not finite",
                                         layout.states[state], step.error[i], where));
    }
    if (!layout.angles[state] || !is_unwrapped(step.error[i])) continue;
    problems.add("angle", fmt::format("the error of the angle '{}' is {} rad {}: minus() does not wrap it",
                                      layout.states[state], step.error[i], where));
  }
  for (std::size_t s = 0; s < step.innovations.size(); ++s) {
    const Innovation& innovation = step.innovations[s];
    const Sensor& sensor = layout.sensors[s];
    if (innovation.nu.size() == 0) continue;
    const std::string name = sensor.name.empty() ? "S" : fmt::format("S of {}", sensor.name);
    if (!innovation.nu.allFinite()) {
      problems.add("finite", fmt::format("the innovation {} is not finite", where));
    }
    check_innovation_covariance(name, innovation.S, where, problems);
    for (Index j = 0; j < innovation.nu.size() && !sensor.angles.empty(); ++j) {
      if (!sensor.angles[static_cast<std::size_t>(j % std::ssize(sensor.angles))]) continue;
      if (!is_unwrapped(innovation.nu[j])) continue;
      problems.add("innovation",
                   fmt::format("the innovation of an angle is {} rad {}: the filter does not wrap it",
                               innovation.nu[j], where));
    }
  }
}

}  // namespace

bool same_step(const TraceStep& a, const TraceStep& b) {
  // NaN is as NaN: what is not finite is a problem of its own.
  const auto same = [](const auto& x, const auto& y) {
    return x.rows() == y.rows() && x.cols() == y.cols() &&
           ((x.array() == y.array()) || (x.array().isNaN() && y.array().isNaN())).all();
  };
  const auto same_innovation = [&](const Innovation& x, const Innovation& y) {
    return same(x.nu, y.nu) && same(x.S, y.S);
  };
  return a.outcome == b.outcome && a.states == b.states && same(a.error, b.error) && same(a.P, b.P) &&
         std::ranges::equal(a.innovations, b.innovations, same_innovation);
}

void require_size(Index estimate, Index expected) {
  if (estimate == expected) return;
  throw PlugMisfit(fmt::format(
      "an estimate of {} states where {} are expected: a filter whose states change in number has "
      "states(), their numbers in the layout of the world",
      estimate, expected));
}

void require_states(const RunLayout& layout, const std::vector<Index>& states) {
  std::vector<bool> seen(layout.states.size(), false);
  for (const Index state : states) {
    if (state < 0 || state >= std::ssize(seen)) {
      throw PlugMisfit(
          fmt::format("states(): {} is none of the {} states of the layout, which count "
                      "from 0",
                      state, seen.size()));
    }
    if (seen[static_cast<std::size_t>(state)])
      throw PlugMisfit(fmt::format("states(): {} is there twice", state));
    seen[static_cast<std::size_t>(state)] = true;
  }
}

void require_fit(const RunLayout& layout, const TraceStep& step) {
  const bool all = step.states.empty() && step.error.size() > 0;
  const Index n = all ? std::ssize(layout.states) : std::ssize(step.states);
  if (step.error.size() != n || step.P.rows() != n || step.P.cols() != n) {
    throw PlugMisfit(fmt::format("an error of dimension {} and P of {}x{} do not fit a state of {}",
                                 step.error.size(), step.P.rows(), step.P.cols(), n));
  }
  if (step.innovations.size() != layout.sensors.size()) {
    throw PlugMisfit(fmt::format("{} innovations, but the layout has {} sensors", step.innovations.size(),
                                 layout.sensors.size()));
  }
  for (std::size_t s = 0; s < step.innovations.size(); ++s) {
    const Innovation& innovation = step.innovations[s];
    const Index m = innovation.nu.size();
    const Index piece = std::max<Index>(1, layout.sensors[s].piece);
    const bool fits = m <= layout.sensors[s].dim && m % piece == 0;
    if (m == 0 || (fits && innovation.S.rows() == m && innovation.S.cols() == m)) continue;
    throw PlugMisfit(fmt::format("an innovation of dimension {} with S of {}x{} does not fit a sensor of {}",
                                 m, innovation.S.rows(), innovation.S.cols(), layout.sensors[s].dim));
  }
}

namespace {

/// Of those of the first runs that threw: run and step.
void add_thrown(const std::vector<std::pair<std::int64_t, std::int64_t>>& threw,
                const std::function<PlugThrown(std::int64_t run)>& thrown, std::int64_t runs,
                Problems& problems) {
  for (const auto& [run, step] : threw) {
    const PlugThrown what = thrown(run);
    if (what.misfit) {
      return problems.add("throws", fmt::format("run {} ends at step {}: {}", run, step, what.said));
    }
  }
  const bool all_at_once = std::ssize(threw) == runs &&
                           std::ranges::all_of(threw, [](const auto& end) { return end.second <= 1; });
  if (all_at_once) {
    problems.add("throws", fmt::format("all of the first {} runs fail at the first step, run 0 with: {}",
                                       runs, thrown(0).said));
  }
}

}  // namespace

std::vector<std::string> plug_problems(const Experiment& experiment,
                                       const std::function<PlugThrown(std::int64_t run)>& thrown) {
  Problems problems;
  std::vector<TraceStep> first;
  std::vector<std::pair<std::int64_t, std::int64_t>> threw;  // run and step
  std::int64_t steps = 0, runs = 0, of_first = 0;
  for (; runs < kRunsLookedAt && steps < kStepsLookedAt; ++runs) {
    const std::int64_t run = runs;
    experiment.visit(run, [&](const TraceStep& step) {
      if (step.outcome == Outcome::threw) threw.push_back({run, step.step});
      if (step.outcome != Outcome::ok) return;
      ++steps;
      if (run == 0 && first.size() < kStepsCompared) first.push_back(step);
      check_step(experiment.layout(), step, fmt::format("in run {} at step {}", run, step.step), problems);
    });
    if (run == 0) of_first = steps;
  }
  if (thrown) add_thrown(threw, thrown, runs, problems);
  std::int64_t i = 0;
  experiment.visit(0, [&](const TraceStep& step) {
    if (step.outcome != Outcome::ok) return;
    if (i < std::ssize(first) && !same_step(first[static_cast<std::size_t>(i)], step)) {
      problems.add("bits",
                   fmt::format("run 0 is not the same twice, from step {} on: the world or the filter "
                               "draws random numbers of its own, or keeps something from run to run",
                               step.step));
    }
    ++i;
  });
  if (i != of_first) {
    problems.add("bits",
                 fmt::format("run 0 is not the same twice: it has {} steps, and then {}: the world or the "
                             "filter draws random numbers of its own, or keeps something from run to run",
                             of_first, i));
  }
  return problems.take();
}

void report_plus(const Vector& d, const Vector& back, std::vector<std::string>& problems) {
  if (back.size() == d.size() && (back - d).norm() <= 1e-9 * d.norm()) return;
  problems.push_back(fmt::format("minus(plus(x, d), x) is not d: d = ({}) comes back as ({})",
                                 fmt::join(d.begin(), d.end(), ", "),
                                 fmt::join(back.begin(), back.end(), ", ")));
}

void report_shared_state(std::int64_t step, std::vector<std::string>& problems) {
  problems.push_back(
      fmt::format("filters share state: runs 0 and 1, a step of each by turns, are not what each of them is "
                  "alone, from step {} on; filters run in several threads, so each must have all that it "
                  "changes as its own, and none of it static, global or behind a pointer that copies share",
                  step));
}

void report_time_step(const Vector& once, const Vector& twice, std::vector<std::string>& problems) {
  constexpr double kTooMuch = 1.5;  // noise that is the same at each call gives 2 or more
  double least = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < once.size(); ++i) {
    if (once[i] > 0.0) least = std::min(least, twice[i] / once[i]);
  }
  if (!std::isfinite(least) || least < kTooMuch) return;
  problems.push_back(
      fmt::format("Q does not scale with dt: two predictions of half a step give every state at least "
                  "{:.3g} times the variance of one of the whole step",
                  least));
}

void require_sound(const std::vector<std::string>& problems) {
  if (!problems.empty()) throw std::invalid_argument(fmt::format("{}", fmt::join(problems, "; ")));
}

}  // namespace credence::internal
