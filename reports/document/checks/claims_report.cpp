#include "reports/document/checks/claims_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/append_item.h"
#include "reports/render/json_numbers.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

CellTone tone_of(ClaimVerdict verdict) {
  switch (verdict) {
    case ClaimVerdict::holds: return CellTone::good;
    case ClaimVerdict::conditional: return CellTone::caution;
    case ClaimVerdict::fails: return CellTone::alarm;
    case ClaimVerdict::not_measured: return CellTone::muted;
  }
  return CellTone::plain;
}

ReportAnswer claims_answer(const std::vector<Claim>& claims) {
  std::string text;
  for (const ClaimVerdict verdict :
       {ClaimVerdict::holds, ClaimVerdict::conditional, ClaimVerdict::fails, ClaimVerdict::not_measured}) {
    const auto count = std::ranges::count(claims, verdict, &Claim::verdict);
    const char* const s = count == 1 ? "s" : "";
    append_item(text, verdict == ClaimVerdict::holds ? fmt::format("{} hold{}", count, s)
                      : verdict == ClaimVerdict::conditional
                          ? fmt::format("{} hold{} under a condition", count, s)
                      : verdict == ClaimVerdict::fails ? fmt::format("{} fail{}", count, s)
                                                       : fmt::format("{} not measured", count));
  }
  const auto any = [&](ClaimVerdict verdict) {
    return std::ranges::find(claims, verdict, &Claim::verdict) != claims.end();
  };
  // Claims of which none was measured are as if there were none.
  const CellTone tone = any(ClaimVerdict::fails)                                     ? CellTone::caution
                        : any(ClaimVerdict::holds) || any(ClaimVerdict::conditional) ? CellTone::good
                                                                                     : CellTone::plain;
  return {tone, fmt::format("Of {} claims: {}", claims.size(), text)};
}

/// The text in lines of at most 100 columns, each begun with `indent` blanks.
std::vector<std::string> claim_lines(std::string_view text, std::size_t indent) {
  constexpr std::size_t kWidth = 100;
  std::vector<std::string> lines = wrapped_lines(text, kWidth - indent);
  for (std::string& line : lines) line.insert(0, indent, ' ');
  return lines;
}

ReportTable claims_table(const std::vector<Claim>& claims) {
  using enum ColumnAlign;
  ReportTable table{.title = "Every claim with its evidence",
                    .columns = {{"id", words},
                                {"claim", words},
                                {"source", words},
                                {"verdict", words},
                                {"measured", words},
                                {"beyond that", words}}};
  for (const Claim& c : claims) {
    table.add({c.id, c.statement, c.source, TableCell(std::string(to_string(c.verdict)), tone_of(c.verdict)),
               c.measured, c.long_run});
  }
  return table;
}

std::string claims_json(const std::vector<Claim>& claims) {
  Json list = json_list(claims, [](const Claim& c) -> Json {
    return {{"id", c.id},
            {"source", c.source},
            {"statement", c.statement},
            {"measured", c.measured},
            {"long_run", text_or_null(c.long_run)},
            {"verdict", to_string(c.verdict)}};
  });
  return text_of_json({{"schema", kSchema},
                       {"claims", std::move(list)},
                       {"null_reason", "long_run: nothing changes beyond the paper's 100 steps"}});
}

}  // namespace

Document claims_document(const std::vector<Claim>& claims) {
  Document document("What the paper claims",
                    "T. Vidal-Calleja, J. Andrade-Cetto, A. Sanfeliu, “Conditions for Suboptimal Filter "
                    "Stability in SLAM”, IROS 2004; measured by Credence");
  document.answer = claims_answer(claims);
  document.json = [claims] { return claims_json(claims); };

  document.show_answer();
  for (const Claim& c : claims) {
    document.show({fmt::format("{}: {} ({})", c.id, to_string(c.verdict), c.source)});
    document.show(claim_lines(c.statement, 2));
    document.show(claim_lines("measured: " + c.measured, 4));
    if (!c.long_run.empty()) document.show(claim_lines("beyond that: " + c.long_run, 4));
    document.show({""});
  }

  document.section("Claims");
  document.table(claims_table(claims));
  return document;
}

}  // namespace credence::internal
