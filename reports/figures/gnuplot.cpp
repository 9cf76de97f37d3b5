#include "reports/figures/gnuplot.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "core/parallel_tasks.h"
#include "reports/figures/gnuplot_process.h"
#include "reports/figures/gnuplot_script.h"
#include "reports/figures/gnuplot_svg.h"
#include "reports/render/atomic_file.h"

namespace credence {
namespace {

// gnuplot shows the offending line and a caret below it; the last line says what is wrong.
std::string last_line(const std::string& errors) {
  const std::size_t end = errors.find_last_not_of(" \t\r\n");
  if (end == std::string::npos) return "no message";
  const std::size_t start = errors.find_last_of('\n', end);
  const std::string line = errors.substr(start == std::string::npos ? 0 : start + 1, end - start);
  const std::size_t first = line.find_first_not_of(" \t");
  return line.substr(first == std::string::npos ? 0 : first);
}

std::string answer_of(const Figure& figure, GnuplotFormat format, const Gnuplot& gnuplot) {
  const std::string script = gnuplot_script(figure, format);
  // -d: the settings of the user must not change a report.
  ProcessResult result = run_process({gnuplot.program, "-d"}, script, gnuplot.timeout);
  if (result.start_error == ENOENT) {
    throw GnuplotError(
        fmt::format("the program '{}' was not found (Debian package gnuplot-nox)", gnuplot.program));
  }
  if (result.start_error != 0) {
    throw GnuplotError(fmt::format("the program '{}' cannot be started: {}", gnuplot.program,
                                   std::generic_category().message(result.start_error)));
  }
  if (result.timed_out) {
    throw GnuplotError(fmt::format("'{}' did not finish within {} s", gnuplot.program,
                                   static_cast<double>(gnuplot.timeout.count()) / 1000.0));
  }
  if (result.signal != 0) {
    throw GnuplotError(fmt::format("'{}' was ended by signal {}", gnuplot.program, result.signal));
  }
  if (result.exit_status != 0) {
    throw GnuplotError(fmt::format("'{}' failed with status {}: {}", gnuplot.program, result.exit_status,
                                   last_line(result.errors)));
  }
  return std::move(result.output);
}

Drawing draw(const Figure& figure, const std::filesystem::path& pdf_folder, const Gnuplot& gnuplot) {
  Drawing drawing;
  try {
    drawing.svg = render_svg(figure, gnuplot);
    if (pdf_folder.empty()) return drawing;
    const auto pdf = pdf_folder / (figure.name + ".pdf");
    write_file(pdf, render_pdf(figure, gnuplot));
    drawing.pdf = pdf;
  } catch (const GnuplotError& error) {
    drawing = {{}, error.what(), {}};
  }
  return drawing;
}

}  // namespace

std::string render_svg(const Figure& figure, const Gnuplot& gnuplot) {
  const std::string raw = answer_of(figure, GnuplotFormat::svg, gnuplot);
  try {
    return clean_svg(raw, figure.caption.empty() ? figure.name : figure.caption);
  } catch (const std::runtime_error& error) {
    throw GnuplotError(error.what());
  }
}

std::string render_pdf(const Figure& figure, const Gnuplot& gnuplot) {
  std::string pdf = answer_of(figure, GnuplotFormat::pdf, gnuplot);
  const bool complete =
      pdf.starts_with("%PDF-") &&
      pdf.find("%%EOF", pdf.size() - std::min<std::size_t>(pdf.size(), 32)) != std::string::npos;
  if (!complete) throw GnuplotError(fmt::format("'{}' wrote no complete PDF", gnuplot.program));
  return pdf;
}

std::vector<Drawing> draw_all(std::span<const Figure> figures, const std::filesystem::path& pdf_folder,
                              const Gnuplot& gnuplot) {
  std::vector<Drawing> drawings(figures.size());
  for_each_task(static_cast<std::int64_t>(figures.size()), 0, nullptr, [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    drawings[at] = draw(figures[at], pdf_folder, gnuplot);
  });
  return drawings;
}

std::vector<std::string> problems_of(std::span<const Drawing> drawings) {
  std::vector<std::string> problems;
  for (const Drawing& drawing : drawings) {
    if (!drawing.problem.empty()) problems.push_back(drawing.problem);
  }
  return problems;
}

}  // namespace credence
