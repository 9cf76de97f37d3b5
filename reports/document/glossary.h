#pragma once

#include <span>
#include <string_view>
#include <vector>

/// @file
/// The words of the reports, explained once: on each page where they are used, and by `credence explain`.

namespace credence::internal {

struct GlossaryWord {
  std::string_view word;        ///< as reports write it
  std::string_view also;        ///< other spellings, separated by '|'
  std::string_view short_form;  ///< one line: what it is
  std::string_view says;        ///< what it is good for, a few sentences
  bool everyday = false;        ///< explained, and not marked in texts
};

/// All words, in the order of the alphabet.
std::span<const GlossaryWord> glossary();

/// The word or one of its other spellings, whatever its capitals; null if there is none.
const GlossaryWord* find_glossary_word(std::string_view word);

/// The words of the glossary that stand in a phrase, in any of their spellings, in the order of the glossary.
std::vector<const GlossaryWord*> glossary_words_in(std::string_view phrase);

/// Up to three words that are spelled nearly so or whose explanation has it, nearest first.
std::vector<std::string_view> near_glossary_words(std::string_view word);

/// A use of a word of the glossary in a text.
struct GlossaryUse {
  std::size_t begin = 0, length = 0;
  const GlossaryWord* word = nullptr;
};

/// Where words of the glossary stand in `text`, as whole words with the capitals of the glossary, in order
/// and without overlap; the longest where several fit. Everyday words are no uses.
std::vector<GlossaryUse> glossary_uses(std::string_view text);

}  // namespace credence::internal
