#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/say.h"
#include "reports/document/glossary.h"

namespace credence::internal {
namespace {

int explain(const std::vector<std::string>& words) {
  if (words.empty()) {
    for (const GlossaryWord& entry : glossary()) fmt::print("{:<20} {}\n", entry.word, entry.short_form);
    return kDone;
  }
  const std::string word = fmt::format("{}", fmt::join(words, " "));  // "factor on P" needs no quotes
  std::vector<const GlossaryWord*> found;
  if (const GlossaryWord* entry = find_glossary_word(word); entry != nullptr) {
    found = {entry};
  } else {
    found = glossary_words_in(word);  // "NEES of the pose", or a cause that a report names
    const auto everyday = [](const GlossaryWord* entry) { return entry->everyday; };
    if (!std::ranges::all_of(found, everyday)) std::erase_if(found, everyday);
  }
  for (const GlossaryWord* entry : found)
    fmt::print("{}: {}.\n{}\n", entry->word, entry->short_form, entry->says);
  if (!found.empty()) return kDone;
  const std::vector<std::string_view> near = near_glossary_words(word);
  say(fmt::format("credence: \"{}\" is not explained; {}", word,
                  near.empty() ? "credence explain alone lists all words"
                               : fmt::format("did you mean {}?", fmt::join(near, ", "))));
  return kBadInput;
}

}  // namespace

void add_explain_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("explain", "what a word of the reports means");
  auto words = std::make_shared<std::vector<std::string>>();
  command->add_option("word", *words, "NEES, optimistic, factor on P, …; none: all words");
  command->footer("Examples:\n  credence explain NEES\n  credence explain factor on P");
  command->callback([words] { throw ExitStatus{explain(*words)}; });
}

}  // namespace credence::internal
