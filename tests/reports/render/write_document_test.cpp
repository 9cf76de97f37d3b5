#include "reports/render/write_document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

#include "reports/document/report_index.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Figure drawable(const std::string& name, std::size_t panels) {
  const Panel panel{.series = {line_series("mean", ColourRole::estimate, {1, 2}, {1, 4})}};
  return {.name = name,
          .caption = "The caption of " + name + ".",
          .cols = static_cast<int>(panels),
          .panels = std::vector<Panel>(panels, panel)};
}

TEST(WriteDocument, WritesThePageItsFiguresAndTheFilesBesideIt) {
  const TemporaryFolder folder;
  Document document("Study");
  document.figure(drawable("one", 1));
  document.paragraph("Between the two.");
  document.figure(drawable("pair", 2));
  document.file("numbers.csv", [](const fs::path& target) { write_file(target, "1,2\n"); });
  write_document(document, folder / "new/report",
                 {.version = "1.2.3", .commit = "", .command = "", .date = "", .machine = ""});

  const std::string page = folder.read("new/report/index.html");
  std::size_t position = 0;
  for (const char* part :
       {"id=\"figure-one\"", "<svg", "The caption of one.", "href=\"figures/one.pdf\"", "Between the two.",
        "id=\"figure-pair\"", "The caption of pair.", "href=\"figures/pair.svg\"", "Credence 1.2.3"}) {
    position = page.find(part, position);
    ASSERT_NE(position, std::string::npos) << part;
  }
  for (const char* file : {"one.svg", "one.pdf", "pair.svg", "pair.pdf", "panels/pair-1.svg"}) {
    EXPECT_TRUE(fs::exists(folder / "new/report/figures" / file)) << file;
  }
  EXPECT_EQ(folder.read("new/report/numbers.csv"), "1,2\n");
}

TEST(WriteDocument, TwoThatWriteIntoOneFolderTakeTurns) {
  const TemporaryFolder folder;
  std::atomic<int> writing = 0;
  const auto write = [&](const std::string& title) {
    Document document(title);
    document.link("The numbers", "numbers.csv");
    document.file("numbers.csv", [&](const fs::path& target) {
      EXPECT_EQ(++writing, 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      write_file(target, title);
      --writing;
    });
    write_document(document, folder / "report");
  };
  std::thread other(write, "one");
  write("two");
  other.join();
  const std::string last = folder.read("report/numbers.csv");
  EXPECT_THAT(folder.read("report/index.html"), HasSubstr("<h1>" + last));
}

TEST(WriteDocument, FiguresThatTakeTimeAreMadeWithThePage) {
  const TemporaryFolder folder;
  Document document("Study");
  int made = 0;
  document.figure("empty", [] { return Figure{.name = "empty"}; });
  document.figure("slow", [&made] {
    ++made;
    return drawable("slow", 1);
  });
  EXPECT_EQ(made, 0);
  write_document(document, folder.path(), {});
  EXPECT_EQ(made, 1);
  EXPECT_THAT(folder.read("index.html"), HasSubstr("<b>Figure A.</b> The caption of slow."));
  EXPECT_FALSE(fs::exists(folder / "figures/empty.svg"));
}

TEST(WriteDocument, WhatWasCutOffCanBeWrittenAgain) {
  const TemporaryFolder folder;
  int writes = 0;
  Document document("Study");
  document.link("numbers", "numbers.csv");
  document.file("numbers.csv", [&](const fs::path& target) {
    write_file(target, "1,2\n");
    if (writes++ == 0) throw OutputError("no space");
  });
  EXPECT_THROW(write_document(document, folder.path(), {}), OutputError);
  EXPECT_NO_THROW(write_document(document, folder.path(), {}));
  EXPECT_EQ(writes, 2);
}

// A file that a page of another command has left is still one of a report, and one of the user is not.
TEST(WriteDocument, TwoCommandsUseAFolderInTurn) {
  const TemporaryFolder folder;
  const auto write = [&folder](const std::string& title, const std::string& name) {
    Document document(title);
    document.link("The numbers", name);
    document.link("What a number is", "https://example.org/number");
    document.file(name, [&](const fs::path& target) { write_file(target, title); });
    write_document(document, folder.path(), {});
  };
  write("one", "one.csv");
  write("two", "two & more.csv");
  EXPECT_THAT(folder.read("index.html"), HasSubstr("Left by earlier reports in this folder"));
  EXPECT_EQ(files_of_page(folder / "index.html"), (std::vector<std::string>{"two & more.csv", "one.csv"}));
  EXPECT_NO_THROW(write("one again", "one.csv"));
  EXPECT_EQ(folder.read("one.csv"), "one again");
  EXPECT_EQ(files_of_page(folder / "index.html"), (std::vector<std::string>{"one.csv", "two & more.csv"}));
  folder.write("mine.csv", "1,2");
  EXPECT_THROW(write("three", "mine.csv"), OutputError);
  EXPECT_EQ(folder.read("mine.csv"), "1,2");
}

TEST(WriteDocument, ThePageIsWhatHtmlPageMakes) {
  const TemporaryFolder folder;
  Document document("Study");
  document.paragraph("All is well.");
  write_document(document, folder.path(), {});
  EXPECT_EQ(folder.read("index.html"), html_page(document, {}, {}, folder.path()));
}

TEST(WriteDocument, FiguresTakeTheStyleOfTheFolder) {
  const TemporaryFolder folder;
  Document document("Study");
  document.figure(drawable("one", 1));
  write_document(document, {folder.path(), {.svg = false, .pdf = false, .pgf = true}}, {});
  EXPECT_TRUE(fs::exists(folder / "figures/one.pgf"));
  EXPECT_FALSE(fs::exists(folder / "figures/one.pdf"));
}

TEST(WriteDocument, AFolderThatCannotBeMadeIsNamed) {
  const TemporaryFolder folder;
  folder.write("taken", "a file");
  Document document("Study");
  document.figure(drawable("one", 1));
  try {
    write_document(document, folder / "taken/report", {});
    FAIL() << "expected an error";
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("taken/report"));
  }
  EXPECT_EQ(folder.entries(), 1);
  EXPECT_EQ(folder.read("taken"), "a file");
}

TEST(WriteDocument, ThePageIsWrittenLastAndWhole) {
  const TemporaryFolder folder;
  bool full = false;
  Document document("Study");
  document.link("numbers", "numbers.csv");
  document.file("numbers.csv", [&](const fs::path& target) {
    if (full) throw OutputError("the disk is full");
    write_file(target, "1,2\n");
  });
  write_document(document, folder.path(),
                 {.version = "1", .commit = "", .command = "", .date = "", .machine = ""});
  const std::string before = folder.read("index.html");
  full = true;
  EXPECT_THAT([&] { write_document(document, folder.path(), {}); },
              testing::ThrowsMessage<OutputError>("the disk is full"));
  EXPECT_EQ(folder.read("index.html"), before);

  fs::create_directories(folder / "other/index.html");
  try {
    write_document(Document("Study"), folder / "other", {});
    FAIL() << "expected an error";
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("other/index.html"));
  }
}

TEST(WriteDocument, ReplacesFilesOfReportsAndNoOthers) {
  const TemporaryFolder folder;
  const Provenance provenance{.version = "1", .commit = "", .command = "", .date = "", .machine = ""};
  const auto write = [&](const std::string& numbers) {
    Document document("Study");
    document.link("the numbers", "numbers.csv");
    document.file("numbers.csv", [&](const fs::path& target) { write_file(target, numbers); });
    write_document(document, folder.path(), provenance);
  };
  write("1\n");
  write("2\n");
  EXPECT_EQ(folder.read("numbers.csv"), "2\n") << "a report made again";

  fs::remove(folder / "index.html");
  EXPECT_THAT([&] { write("3\n"); }, testing::ThrowsMessage<OutputError>(
                                         HasSubstr("numbers.csv: is there already and no file of a report")));
  EXPECT_EQ(folder.read("numbers.csv"), "2\n");

  fs::remove(folder / "numbers.csv");
  folder.write("index.html", "my page");
  EXPECT_THAT([&] { write("3\n"); },
              testing::ThrowsMessage<OutputError>(HasSubstr("index.html: is there already")));
  EXPECT_EQ(folder.read("index.html"), "my page");
}

TEST(WriteDocument, OfAFileThatTheReportThereDoesNotHaveItNamesTheCommand) {
  const TemporaryFolder folder;
  Document check("Logs"), compare("Results side by side");
  check.link("every step", "a.csv");
  check.file("a.csv", [](const fs::path& target) { write_file(target, "1\n"); });
  Provenance provenance = make_provenance("credence compare A B --out X");
  write_document(compare, folder.path(), provenance);
  folder.write("a.csv", "mine");
  provenance.command = "credence check a.csv --out X";
  EXPECT_THAT([&] { write_document(check, folder.path(), provenance); },
              testing::ThrowsMessage<OutputError>(
                  (folder / "a.csv").string() +
                  ": is there already and no file of the report in that folder, which is of `credence "
                  "compare A B --out X`, and would be replaced: name another --out, or move the file away"));
  EXPECT_EQ(folder.read("a.csv"), "mine");
  fs::remove(folder / "a.csv");
  EXPECT_NO_THROW(write_document(check, folder.path(), provenance));
}

TEST(WriteDocument, RefusesAFigureThatCannotBeDrawn) {
  const TemporaryFolder folder;
  Document document("Study");
  document.figure(drawable("no name for a file", 1));
  EXPECT_THROW(write_document(document, folder.path(), {}), std::invalid_argument);
  EXPECT_FALSE(fs::exists(folder / "index.html"));
}

}  // namespace
}  // namespace credence::internal
