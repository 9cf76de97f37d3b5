#include "reports/document/claims_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/document/report_table.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"
#include "reports/render/json_numbers.h"
#include "reports/render/utf8_text.h"

namespace credence {
namespace {

CellTone tone_of(ClaimVerdict verdict) {
  switch (verdict) {
    case ClaimVerdict::holds:
      return CellTone::good;
    case ClaimVerdict::conditional:
      return CellTone::caution;
    case ClaimVerdict::fails:
      return CellTone::alarm;
    case ClaimVerdict::not_measured:
      return CellTone::muted;
  }
  return CellTone::plain;
}

std::string summary(std::span<const Claim> claims) {
  std::string text;
  for (const ClaimVerdict verdict :
       {ClaimVerdict::holds, ClaimVerdict::conditional, ClaimVerdict::fails, ClaimVerdict::not_measured}) {
    const auto count = std::ranges::count(claims, verdict, &Claim::verdict);
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count,
                        verdict == ClaimVerdict::holds         ? "hold"
                        : verdict == ClaimVerdict::conditional ? "hold under a condition"
                        : verdict == ClaimVerdict::fails       ? "fail"
                                                               : "not measured");
  }
  return fmt::format("Of {} claims: {}.", claims.size(), text);
}

/// The text in lines of at most 100 columns, each begun with `indent` blanks.
std::string paragraph(std::string_view text, std::size_t indent) {
  constexpr std::size_t kWidth = 100;
  std::string lines, line;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    if (!line.empty() && indent + display_width(line) + 1 + display_width(word) > kWidth) {
      lines += std::string(indent, ' ') + line + "\n";
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  return lines + std::string(indent, ' ') + line + "\n";
}

}  // namespace

std::string claims_json(std::span<const Claim> claims) {
  Json list = Json::array();
  for (const Claim& c : claims) {
    list.push_back({{"id", c.id},
                    {"source", c.source},
                    {"statement", c.statement},
                    {"measured", c.measured},
                    {"long_run", c.long_run.empty() ? Json(nullptr) : Json(c.long_run)},
                    {"verdict", to_string(c.verdict)}});
  }
  return Json{{"schema", kSchema},
              {"claims", std::move(list)},
              {"null_reason", "long_run: nothing changes beyond the paper's 100 steps"}}
      .dump(1);
}

std::string claims_text(std::span<const Claim> claims) {
  std::string text;
  for (const Claim& c : claims) {
    text += fmt::format("{}: {} ({})\n", c.id, to_string(c.verdict), c.source);
    text += paragraph(c.statement, 2);
    text += paragraph("measured: " + c.measured, 4);
    if (!c.long_run.empty()) text += paragraph("in the long run: " + c.long_run, 4);
    text += '\n';
  }
  return summary(claims) + "\n\n" + text;
}

void write_claims_report(const ReportFolder& directory, std::span<const Claim> claims,
                         const Provenance& provenance) {
  make_directories(directory);
  using enum ColumnAlign;
  ReportTable table{.title = "Every claim with its evidence",
                    .columns = {{"claim", words},
                                {"source", words},
                                {"verdict", words},
                                {"measured", words},
                                {"in the long run", words}},
                    .rows = {},
                    .notes = {}};
  for (const Claim& c : claims) {
    table.add({c.statement, c.source, TableCell(std::string(to_string(c.verdict)), tone_of(c.verdict)),
               c.measured, c.long_run});
  }
  HtmlPage page(
      "What the paper claims",
      "T. Vidal-Calleja, J. Andrade-Cetto, A. Sanfeliu, “Conditions for Suboptimal Filter Stability in "
      "SLAM”, IROS 2004; measured by Credence");
  const bool fails = std::ranges::find(claims, ClaimVerdict::fails, &Claim::verdict) != claims.end();
  page.answer(fails ? CellTone::caution : CellTone::good, summary(claims));
  page.section("Claims");
  page.table(table);
  page.provenance(provenance);
  page.write(directory / "index.html");
}

}  // namespace credence
