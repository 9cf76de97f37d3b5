#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "analysis/evidence/verdicts/verdict.h"
#include "reports/render/output_error.h"

namespace credence::internal {

struct Judged;

}  // namespace credence::internal

namespace credence {

/// Is told of how many runs, or bytes of logs, how many are done: by one thread at a time, and not for long,
/// as others may wait for it.
using JudgeProgress = std::function<void(std::int64_t done, std::int64_t total)>;

/// A factor on a covariance with its interval; NaN, and a reason, where it is not known.
struct Factor {
  double value = 0.0, lower = 0.0, upper = 0.0;
  std::string reason;
};

/// What most likely is wrong, and what speaks for it.
struct NamedCause {
  std::string name, why;
};

/// A run that did not end well: when, how, and what its filter said, if it threw.
struct FailedRun {
  std::int64_t run = 0, step = 0;
  std::string outcome, said;
};

/// A filter that was judged by its runs, wherever they came from: the answer, and all forms of telling it.
class JudgedFilter {
 public:
  explicit JudgedFilter(internal::Judged judged);

  /// The one word over NEES, NIS and every block of the state.
  Verdict verdict() const;
  /// Of everything together: the verdict is optimistic, pessimistic or mixed only where it is at most
  /// 1 − confidence; of an undecided one says() tells why. That of a stop rule is valid at any look.
  double p_value() const;
  /// What is wrong, where and when, in a few words; of a consistent filter what was seen.
  const std::string& says() const;
  /// On P: the true covariance over the claimed one, on average over steps.
  const Factor& factor() const;
  /// The most specific first; a hint, not a proof.
  const std::vector<NamedCause>& causes() const;
  const std::vector<FailedRun>& failures() const;
  /// What seems wrong with the numbers themselves, as a P that holds standard deviations (docs/logs.md).
  const std::vector<std::string>& mistakes() const;
  /// False after an interruption: fewer runs than asked for.
  bool complete() const;

  /// What `credence run` or `credence check` prints on a terminal.
  std::string text() const;
  /// What `--format json` prints (docs/formats.md): every number there is.
  std::string json() const;
  /// What `--out DIR` writes: DIR/index.html, figures, and every step as CSV. Throws OutputError.
  void write_report(const std::filesystem::path& directory) const;

  const internal::Judged& judged() const { return *judged_; }

 private:
  std::shared_ptr<const internal::Judged> judged_;
};

}  // namespace credence
