#include "reports/document/report_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "reports/render/atomic_file.h"
#include "reports/render/write_document.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

void write_report(const std::filesystem::path& folder, const std::string& title, const std::string& answer) {
  Document document(title);
  document.answer = {CellTone::good, answer};
  write_document(
      document, folder,
      {.version = "1.0", .commit = "", .command = "credence run", .date = "2026-01-01", .machine = ""});
}

TEST(ReportIndex, FindsReportsWithTheirAnswers) {
  const TemporaryFolder folder;
  write_report(folder / "a & b", "First", "\"a\" < 'b' & all is well");
  write_report(folder / "c/d", "Second", "Not so");
  write_report(folder / ".hidden", "Hidden", "No");
  std::filesystem::create_directories(folder / "other");
  folder.write("other/index.html", "<html><head><title>Somebody else's</title></head></html>");
  const auto reports = find_reports(folder.path());
  ASSERT_EQ(reports.size(), 2u);
  EXPECT_EQ(reports[0].page, "a & b/index.html");
  EXPECT_EQ(reports[0].title, "First");
  EXPECT_EQ(reports[0].answer, "\"a\" < 'b' & all is well.");
  EXPECT_EQ(reports[1].command, "credence run");
  EXPECT_EQ(reports[1].date, "2026-01-01");
}

TEST(ReportIndex, APageTellsWhatMadeIt) {
  const TemporaryFolder folder;
  write_report(folder.path(), "First", "All is well");
  EXPECT_EQ(command_of_page(folder / "index.html"), "credence run");
  folder.write("other.html", "<meta name=\"credence-command\" content=\"rm\">");
  EXPECT_EQ(command_of_page(folder / "other.html"), "");
  EXPECT_EQ(command_of_page(folder / "none.html"), "");
}

TEST(ReportIndex, IsAPageThatLeadsToThem) {
  const TemporaryFolder folder;
  write_report(folder / "a b", "First", "All is well");
  EXPECT_EQ(write_report_index(folder.path()), 1u);
  EXPECT_THAT(folder.read("reports.html"), HasSubstr("<a href=\"a%20b/index.html\">a b</a>"));
  EXPECT_THAT(folder.read("reports.html"), HasSubstr("All is well."));
  EXPECT_EQ(write_report_index(folder.path()), 1u) << "the index itself is no report";
}

// One folder in another, each of which is held open.
TEST(ReportIndex, AFolderThatCannotBeReadDoesNotEndItWithoutAWord) {
  const TemporaryFolder folder;
  std::filesystem::path deep = folder.path();
  for (int i = 0; i < 64; ++i) deep /= "d";
  write_report(deep, "First", "All is well");
  ASSERT_EQ(find_reports(folder.path()).size(), 1u);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit few = before;
  few.rlim_cur = 32;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  EXPECT_THROW(find_reports(folder.path()), OutputError);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
}

TEST(ReportIndex, APageKeepsWhatAuthorsOfScenariosSay) {
  const TemporaryFolder folder;
  Document document("Two");
  document.descriptions = {{"a", "Says \"a\" & <b>."}, {"a & b", "Of both."}};
  write_document(document, folder.path());
  EXPECT_EQ(description_of_page(folder / "index.html", "a"), "Says \"a\" & <b>.");
  EXPECT_EQ(description_of_page(folder / "index.html", "a & b"), "Of both.");
  EXPECT_EQ(description_of_page(folder / "index.html", "b"), "");
  EXPECT_EQ(description_of_page(folder / "none.html", "a"), "");
}

TEST(ReportIndex, NamesAFolderThatIsNotThere) { EXPECT_THROW(find_reports("/no such folder"), OutputError); }

}  // namespace
}  // namespace credence::internal
