#include "reports/document/document.h"

#include <fmt/format.h>

#include <cctype>
#include <cstdint>

namespace credence::internal {

std::string Document::reserve(std::string_view heading) {
  std::string slug;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && std::isalnum(byte)) {
      slug += static_cast<char>(std::tolower(byte));
    } else if (!slug.empty() && slug.back() != '-') {
      slug += '-';
    }
  }
  while (!slug.empty() && slug.back() == '-') slug.pop_back();
  if (slug.empty()) slug = "section";
  std::string anchor = slug;
  for (int i = 2; !anchors_.insert(anchor).second; ++i) anchor = fmt::format("{}-{}", slug, i);
  return anchor;
}

void Document::show_answer() { show({answer.text + ".", ""}); }

void Document::show(const std::vector<std::string>& lines) {
  brief.insert(brief.end(), lines.begin(), lines.end());
}

void Document::show_apart(const std::vector<ReportTable>& tables) {
  for (const ReportTable& table : tables) {
    brief.emplace_back(table);
    brief.emplace_back("");
  }
}

void Document::section(std::string_view heading, std::string anchor) {
  if (anchor.empty()) anchor = reserve(heading);
  parts_.emplace_back(part::Heading{std::string(heading), std::move(anchor)});
}

void Document::folded_section(std::string_view heading, const TableCell& word, std::string_view line,
                              bool open, const std::function<void()>& inside, std::string anchor) {
  if (anchor.empty()) anchor = reserve(heading);
  parts_.emplace_back(part::Fold{{std::string(heading), std::move(anchor)}, word, std::string(line), open});
  inside();
  parts_.emplace_back(part::FoldEnd{});
}

void Document::folded(std::string_view heading, const std::function<void()>& inside) {
  parts_.emplace_back(part::Fold{{std::string(heading), reserve(heading)}, "", "", false, false});
  inside();
  parts_.emplace_back(part::FoldEnd{});
}

void Document::paragraph(std::string_view text) { parts_.emplace_back(part::Paragraph{std::string(text)}); }

void Document::bullets(std::vector<std::string> items) {
  if (!items.empty()) parts_.emplace_back(part::Bullets{std::move(items)});
}

void Document::callout(CellTone tone, std::string_view text) {
  parts_.emplace_back(part::Callout{tone, std::string(text)});
}

void Document::facts(std::vector<std::pair<std::string, std::string>> names_and_values) {
  parts_.emplace_back(part::Facts{std::move(names_and_values)});
}

void Document::verbatim(std::string_view text) { parts_.emplace_back(part::Verbatim{std::string(text)}); }

void Document::table(ReportTable table) { parts_.emplace_back(std::move(table)); }

void Document::figure(Figure figure) {
  if (!has_data(figure)) return;
  const std::string name = figure.name;
  this->figure(name, [drawn = std::move(figure)] { return drawn; });
}

void Document::figure(std::string_view name, std::function<Figure()> make) {
  parts_.emplace_back(part::DrawnFigure{reserve(fmt::format("figure-{}", name)), std::move(make)});
}

void Document::figures(std::vector<Figure> figures) {
  for (Figure& each : figures) figure(std::move(each));
}

void Document::link(std::string_view words, std::string_view address) {
  parts_.emplace_back(part::Link{std::string(words), std::string(address)});
}

void Document::file(std::string name, std::function<void(const std::filesystem::path&)> write) {
  files.push_back({std::move(name), std::move(write)});
}

std::string plain_name(std::string_view name, const char* otherwise) {
  constexpr std::uint32_t kFnvStart = 2166136261U, kFnvPrime = 16777619U;
  std::string result;
  bool other_letters = false;
  std::uint32_t hash = kFnvStart;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    other_letters = other_letters || static_cast<unsigned char>(c) >= 0x80;
    hash = (hash ^ static_cast<unsigned char>(c)) * kFnvPrime;
    const bool begins_letter = (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
    if (plain) {
      result += c;
    } else if (begins_letter) {
      result += '_';
    }
  }
  // Words of other scripts are all underscores: what they are called tells them apart.
  if (other_letters) result += fmt::format("-{:08x}", hash);
  return result.empty() ? otherwise : result;
}

}  // namespace credence::internal
