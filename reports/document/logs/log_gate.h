#pragma once

#include <string>
#include <string_view>

#include "analysis/calibration/calibration.h"
#include "reports/document/logs/log_report.h"
#include "reports/render/json_numbers.h"

/// @file
/// What a continuous integration wants of `credence check`: whether it fails, and the files that its tools
/// read.

namespace credence::internal {

/// Judges logs against the document of an earlier `check --format json`. A factor is worse that moved away
/// from 1, by more than `margin`, and not by chance (Holm over the parts; nearness_of), and so are a word
/// that was none of optimistic and mixed and is, and a larger share of failed runs, of rejected rows, or of
/// rows with an error where P claims certainty. Where one of the two has no factors of runs or stretches, as
/// of few runs of a map, the mean NEES and NIS of its parts are compared, as those of independent logs;
/// nothing is compared where states or blocks differ. Throws std::invalid_argument for a text that is no such
/// document.
LogGate gate_against(const CheckedLogs& logs, const std::string& baseline, std::string_view document,
                     double margin);

/// "more optimistic in yaw: the factor on P is 1.8 (1.3 … 2.4) times what it was, p = 0.003"
std::string change_text(const FactorChange& change, double level);

/// {"part", "ratio", "lower", "upper", "p_value", "adjusted_p_value", "middle_p_value"}.
Json change_json(const FactorChange& change);

/// What the baseline says, in a sentence or several.
std::string gate_sentence(const LogGate& gate);

Json gate_json(const LogGate& gate);

/// JUnit XML of one suite: the word, every test of the suite, and what the baseline says. Failures are there
/// exactly where --fail-on-inconsistent fails.
std::string junit_xml(const CheckedLogs& logs, double confidence);

/// A summary for a pull request.
std::string markdown_summary(const CheckedLogs& logs);

/// Whether runs failed, rows were rejected, or states err where P claims certainty, with a baseline that can
/// be compared a larger share than there.
bool lost_any(const CheckedLogs& logs);

/// Whether --fail-on-inconsistent fails: with a baseline that can be compared where something is worse, else
/// where the word is inconsistent.
bool fails(const CheckedLogs& logs);

}  // namespace credence::internal
