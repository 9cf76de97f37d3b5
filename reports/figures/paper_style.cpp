#include "reports/figures/paper_style.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace credence::internal {
namespace {

using namespace std::string_view_literals;

constexpr std::array kPaperWords{"svg"sv,        "pdf"sv,         "png"sv,  "pgf"sv,
                                 "one-column"sv, "two-columns"sv, "serif"sv};

}  // namespace

std::span<const std::string_view> paper_words() { return kPaperWords; }

PaperStyle paper_style(std::span<const std::string> words) {
  const auto named = [&](std::string_view word) { return std::ranges::find(words, word) != words.end(); };
  for (const std::string& word : words) {
    if (std::ranges::find(kPaperWords, word) == kPaperWords.end()) {
      throw std::invalid_argument(fmt::format("'{}' is none of {}", word, fmt::join(kPaperWords, ", ")));
    }
  }
  if (named("one-column") && named("two-columns")) {
    throw std::invalid_argument("one-column and two-columns exclude each other");
  }
  PaperStyle style;
  if (named("svg") || named("pdf") || named("png") || named("pgf")) {
    style.svg = named("svg");
    style.pdf = named("pdf");
    style.png = named("png");
    style.pgf = named("pgf");
  }
  if (named("one-column")) style.width = PaperStyle::Width::one_column;
  if (named("two-columns")) style.width = PaperStyle::Width::two_columns;
  style.serif = named("serif");
  return style;
}

}  // namespace credence::internal
