#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "reports/document/document.h"
#include "reports/document/provenance.h"
#include "reports/figures/draw_figures.h"

namespace credence::internal {

/// A document as one HTML file that needs nothing else: no files, no fonts, no network. Its one script makes
/// figures answer to the mouse and tables sort; without it everything can still be read and printed. Words of
/// the glossary link to their explanation, at the end of the page, where they are first used.
///
/// `drawings`: of the document's figures, in their order; an empty one where nothing is to be seen. Links to
/// their files are relative to `link_base`, the folder of the page.
std::string html_page(const Document& document, std::span<const Drawing> drawings, const Provenance& from,
                      const std::filesystem::path& link_base = {});

}  // namespace credence::internal
