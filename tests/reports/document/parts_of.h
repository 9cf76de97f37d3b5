#pragma once

#include <stdexcept>
#include <string>
#include <variant>

#include "reports/document/document.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {

/// As whoever reads the document has it: null where a number is not finite.
inline Json as_read(const Json& written) { return Json::parse(text_of_json(written)); }

/// The first table of a page whose title holds these words.
inline ReportTable table_of(const Document& document, const std::string& words) {
  for (const DocumentPart& part : document.parts()) {
    const auto* table = std::get_if<ReportTable>(&part);
    if (table != nullptr && table->title.find(words) != std::string::npos) return *table;
  }
  throw std::out_of_range("no table: " + words);
}

/// The figure of a page that has this name.
inline Figure figure_of(const Document& document, const std::string& name) {
  for (const DocumentPart& part : document.parts()) {
    const auto* drawn = std::get_if<part::DrawnFigure>(&part);
    if (drawn == nullptr) continue;
    if (Figure figure = drawn->make(); figure.name == name) return figure;
  }
  throw std::out_of_range("no figure: " + name);
}

}  // namespace credence::internal
