#include "reports/figures/cairo_canvas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <memory>
#include <regex>

#include "reports/render/atomic_file.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

std::string example(const CairoCanvas::Options& options) {
  CairoCanvas canvas(378.0, 240.0, "Errors (m²) \\ ) <", options);
  const CanvasPath curve{{10, 10}, {100, 50}, {300, 20}};
  const CanvasPath dot{{20, 20}};
  canvas.stroke({&curve, 1}, {.width = 1.4, .stroke = StrokeStyle::dashed});
  canvas.stroke({&dot, 1}, {.width = 4.0, .dots = true});
  canvas.fill({&curve, 1}, {0x0072B2, 0.15});
  canvas.write("Vehicle error", {10, 10}, {.bold = true});
  canvas.write("2×10 m² …", {100, 100}, {.anchor = TextAnchor::middle});
  canvas.write("σ Δθ − µ", {20, 200}, {.anchor = TextAnchor::end, .upright = true});
  canvas.write(figure_markup("K_{f1}^{2}"), {200, 200}, {});
  return std::move(canvas).finish();
}

std::string example_pdf() { return example({}); }

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

// What a program of poppler-utils says of a PDF, or nothing where it is not installed.
std::string told_by(const char* program, const std::string& pdf) {
  const TemporaryFolder folder;
  const std::string file = (folder / "figure.pdf").string();
  write_file(file, pdf);
  const std::string command = std::string(program) + " '" + file + "' - 2>/dev/null";
  const std::string plain = std::string(program) + " '" + file + "' 2>/dev/null";
  const bool to_stdout = std::string(program).starts_with("pdftotext");
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen((to_stdout ? command : plain).c_str(), "r"), pclose);
  std::string answer;
  for (int c = 0; pipe && (c = std::fgetc(pipe.get())) != EOF;) answer += static_cast<char>(c);
  return answer;
}

TEST(CairoCanvas, IsACompletePdf) {
  const std::string pdf = example_pdf();
  EXPECT_TRUE(pdf.starts_with("%PDF-"));
  EXPECT_THAT(pdf.substr(pdf.size() - 10), HasSubstr("%%EOF"));
}

// A date would be the same in both, but for one second in a while.
TEST(CairoCanvas, TheSameDrawingHasTheSameBytes) {
  EXPECT_EQ(example_pdf(), example_pdf());
  EXPECT_THAT(example_pdf(), ::testing::Not(HasSubstr("/CreationDate")));
}

TEST(CairoCanvas, HasTheSizeOfAColumn) {
  const std::string info = told_by("pdfinfo", example_pdf());
  if (info.empty()) GTEST_SKIP() << "pdfinfo (poppler-utils) is not installed";
  EXPECT_THAT(info, HasSubstr("Page size:       252 x 160 pts")) << "3.5 in; 8 pt for 12 units";
  EXPECT_THAT(info, HasSubstr("Subject:         Errors (m²) \\ ) <"));
  EXPECT_THAT(info, HasSubstr("Pages:           1\n"));
}

TEST(CairoCanvas, EmbedsItsFonts) {
  const std::string fonts = told_by("pdffonts", example_pdf());
  if (fonts.empty()) GTEST_SKIP() << "pdffonts (poppler-utils) is not installed";
  // name, type, encoding, emb, sub, uni, object
  const std::regex row(R"(\n\S+ .* (yes|no) +(yes|no) +(yes|no) +\d+ +\d+)");
  int rows = 0;
  for (std::sregex_iterator it(fonts.begin(), fonts.end(), row), end; it != end; ++it, ++rows) {
    EXPECT_EQ((*it)[1], "yes") << fonts;
  }
  EXPECT_GE(rows, 2) << "regular and bold\n" << fonts;
}

TEST(CairoCanvas, WordsCanBeReadBack) {
  const std::string text = told_by("pdftotext", example_pdf());
  if (text.empty()) GTEST_SKIP() << "pdftotext (poppler-utils) is not installed";
  for (const char* words : {"Vehicle error", "2×10 m² …"}) EXPECT_THAT(text, HasSubstr(words));
}

TEST(CairoCanvas, APngHasThreeHundredDotsPerInch) {
  const std::string png = example({.format = CairoCanvas::Format::png});
  ASSERT_TRUE(png.starts_with("\x89PNG\r\n\x1a\n"));
  EXPECT_EQ(big_endian(png, 16), 1050u) << "3.5 in";
  EXPECT_EQ(big_endian(png, 20), 667u) << "160 pt, and what a dot has left over";
  EXPECT_EQ(example({.format = CairoCanvas::Format::png}), png);
}

TEST(CairoCanvas, APngTooHighForCairoIsDrawnSmaller) {
  const std::string png = CairoCanvas(10.0, 20'000.0, "", {.format = CairoCanvas::Format::png}).finish();
  ASSERT_TRUE(png.starts_with("\x89PNG\r\n\x1a\n"));
  EXPECT_EQ(big_endian(png, 20), 32'000u);
}

TEST(CairoCanvas, LettersWithSerifsAreOthers) { EXPECT_NE(example({.serif = true}), example_pdf()); }

}  // namespace
}  // namespace credence::internal
