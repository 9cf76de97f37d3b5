#include "reports/document/checks/claims_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "reports/render/text_page.h"
#include "reports/render/utf8_text.h"
#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

Claim claim(const std::string& id, ClaimVerdict verdict, const std::string& long_run = "") {
  return {.id = id,
          .source = "eq. (22)",
          .statement = "the paper says " + id,
          .measured = "seen of " + id,
          .long_run = long_run,
          .verdict = verdict};
}

std::vector<Claim> one_of_each() {
  return {claim("a", ClaimVerdict::holds), claim("b", ClaimVerdict::conditional, "grows"),
          claim("c", ClaimVerdict::fails), claim("d", ClaimVerdict::not_measured),
          claim("e", ClaimVerdict::holds)};
}

TEST(ClaimsReport, EveryClaimIsCountedOnce) {
  const ReportAnswer answer = claims_document(one_of_each()).answer;
  EXPECT_EQ(answer.text, "Of 5 claims: 2 hold, 1 holds under a condition, 1 fails, 1 not measured");
  EXPECT_EQ(answer.tone, CellTone::caution);
  EXPECT_EQ(claims_document({claim("a", ClaimVerdict::holds)}).answer.tone, CellTone::good);
}

TEST(ClaimsReport, ClaimsOfWhichNoneWasMeasuredAreNotGood) {
  const Claim not_measured = claim("d", ClaimVerdict::not_measured);
  EXPECT_EQ(claims_document({not_measured, not_measured}).answer.tone, CellTone::plain);
  EXPECT_EQ(claims_document({}).answer.tone, CellTone::plain);
  EXPECT_EQ(claims_document({not_measured, claim("b", ClaimVerdict::conditional)}).answer.tone,
            CellTone::good);
}

TEST(ClaimsReport, TableAndDataHaveEveryClaimWithItsEvidence) {
  const std::vector<Claim> claims = one_of_each();
  const Document document = claims_document(claims);
  const ReportTable table = table_of(document, "Every claim");
  const auto j = nlohmann::json::parse(document.json());
  ASSERT_EQ(table.rows.size(), 5U);
  ASSERT_EQ(j["claims"].size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(j["claims"][i]["id"], claims[i].id);
    EXPECT_EQ(table.rows[i][0].text, claims[i].id) << "by which text and data name it";
    EXPECT_EQ(table.rows[i][1].text, j["claims"][i]["statement"]);
    EXPECT_EQ(table.rows[i][3].text, j["claims"][i]["verdict"]);
    EXPECT_EQ(table.rows[i][4].text, j["claims"][i]["measured"]);
  }
  EXPECT_EQ(j["claims"][1]["long_run"], "grows");
  EXPECT_EQ(table.rows[1][5].text, "grows");
  EXPECT_TRUE(j["claims"][0]["long_run"].is_null());
  EXPECT_FALSE(j["null_reason"].empty());
  EXPECT_EQ(table.rows[2][3].tone, CellTone::alarm);
  EXPECT_EQ(table.rows[3][3].tone, CellTone::muted);
}

TEST(ClaimsReport, LongTextsAreFoldedBetweenWords) {
  Claim one = claim("a", ClaimVerdict::holds);
  one.measured.clear();
  for (int i = 0; i < 60; ++i) one.measured += "rank ΔP ";
  one.measured += std::string(150, 'x');
  const std::string text = text_page(claims_document({one}));
  std::size_t words = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    if (line.find(std::string(150, 'x')) == std::string::npos) EXPECT_LE(display_width(line), 100U) << line;
    for (std::size_t at = line.find("rank"); at != std::string::npos; at = line.find("rank", at + 1)) ++words;
    begin = end + 1;
  }
  EXPECT_EQ(words, 60U);
  EXPECT_THAT(text, HasSubstr("a: holds (eq. (22))"));
}

}  // namespace
}  // namespace credence::internal
