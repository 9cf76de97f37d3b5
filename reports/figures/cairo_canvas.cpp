#include "reports/figures/cairo_canvas.h"

#include <cairo-pdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "reports/figures/figure_text.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

constexpr double kPngDotsPerPoint = 300.0 / 72.0;
constexpr double kPointsPerUnit = kPaperFontPoints / kLabelFont;

void require_success(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(std::string("cairo cannot draw the figure: ") + cairo_status_to_string(status));
  }
}

cairo_status_t append_bytes(void* target, const unsigned char* bytes, unsigned length) {
  static_cast<std::string*>(target)->append(reinterpret_cast<const char*>(bytes), length);
  return CAIRO_STATUS_SUCCESS;
}

void set_colour(cairo_t* cr, std::uint32_t rgb, double opacity) {
  const auto channel = [rgb](unsigned shift) { return static_cast<double>((rgb >> shift) & 0xFFu) / 255.0; };
  cairo_set_source_rgba(cr, channel(16), channel(8), channel(0), opacity);
}

void trace(cairo_t* cr, std::span<const CanvasPath> paths, bool close) {
  cairo_new_path(cr);
  for (const CanvasPath& path : paths) {
    if (path.empty()) continue;
    cairo_move_to(cr, path[0].x, path[0].y);
    for (std::size_t i = 1; i < path.size(); ++i) cairo_line_to(cr, path[i].x, path[i].y);
    if (close || path.size() == 1) cairo_close_path(cr);
  }
}

double font_size(TextLevel level) { return level == TextLevel::base ? kLabelFont : kScriptFont; }

double advance_width(cairo_t* cr, const std::vector<TextRun>& runs) {
  double width = 0.0;
  for (const TextRun& run : runs) {
    cairo_text_extents_t extents;
    cairo_set_font_size(cr, font_size(run.level));
    cairo_text_extents(cr, run.words.c_str(), &extents);
    width += extents.x_advance;
  }
  return width;
}

}  // namespace

struct CairoCanvas::Page {
  struct SurfaceDeleter {
    void operator()(cairo_surface_t* owned) const { cairo_surface_destroy(owned); }
  };
  struct ContextDeleter {
    void operator()(cairo_t* owned) const { cairo_destroy(owned); }
  };

  void open_pdf(double width, double height, std::string_view description) {
    surface.reset(cairo_pdf_surface_create_for_stream(append_bytes, &bytes, scale * width, scale * height));
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_SUBJECT,
                                   printable_line(description).c_str());
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATOR, "Credence");
    // Without a date the same figure has the same bytes.
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "");
  }
  void open_png(double width, double height) {
    constexpr double kMostDots = 32000.0;  // that cairo takes on a side
    scale = std::min(scale, kMostDots / std::max(width, height));
    const auto dots = [&](double length) { return static_cast<int>(std::ceil(scale * length)); };
    surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, dots(width), dots(height)));
  }
  cairo_t* cr() const { return context.get(); }

  Options options;
  double scale = kPointsPerUnit * (options.format == Format::png ? kPngDotsPerPoint : 1.0);
  std::string bytes{};
  std::unique_ptr<cairo_surface_t, SurfaceDeleter> surface{};
  std::unique_ptr<cairo_t, ContextDeleter> context{};
};

CairoCanvas::CairoCanvas(double width, double height, std::string_view description, const Options& options)
    : page_(new Page{.options = options}) {
  if (options.format == Format::pdf) {
    page_->open_pdf(width, height, description);
  } else {
    page_->open_png(width, height);
  }
  page_->context.reset(cairo_create(page_->surface.get()));
  cairo_t* cr = page_->cr();
  if (options.format == Format::png) {
    cairo_set_source_rgb(cr, 1.0, 1.0, 1.0);
    cairo_paint(cr);
  }
  cairo_scale(cr, page_->scale, page_->scale);
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
  require_success(cairo_status(cr));
}

CairoCanvas::~CairoCanvas() = default;

void CairoCanvas::stroke(std::span<const CanvasPath> lines, const Pen& pen) {
  cairo_t* cr = page_->cr();
  set_colour(cr, pen.rgb, 1.0);
  cairo_set_line_width(cr, pen.width);
  cairo_set_line_cap(cr, pen.dots ? CAIRO_LINE_CAP_ROUND : CAIRO_LINE_CAP_BUTT);
  const Dashes dashes = dashes_of(pen.stroke, pen.width);
  const std::array<double, 2> lengths{dashes.on, dashes.off};
  cairo_set_dash(cr, lengths.data(), pen.stroke == StrokeStyle::solid ? 0 : 2, 0.0);
  trace(cr, lines, false);
  cairo_stroke(cr);
  require_success(cairo_status(cr));
}

void CairoCanvas::fill(std::span<const CanvasPath> outlines, const Brush& brush) {
  cairo_t* cr = page_->cr();
  set_colour(cr, brush.rgb, brush.opacity);
  trace(cr, outlines, true);
  cairo_fill(cr);
  require_success(cairo_status(cr));
}

void CairoCanvas::write(const FigureText& text, CanvasPoint at, const Lettering& lettering) {
  constexpr double kQuarterTurn = -1.5707963267948966;
  cairo_t* cr = page_->cr();
  cairo_save(cr);
  set_colour(cr, lettering.rgb, 1.0);
  cairo_select_font_face(cr, page_->options.serif ? "Times" : "Helvetica", CAIRO_FONT_SLANT_NORMAL,
                         lettering.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_translate(cr, at.x, at.y);
  if (lettering.upright) cairo_rotate(cr, kQuarterTurn);
  const std::vector<TextRun> runs = text_runs(text);
  const double before = lettering.anchor == TextAnchor::start    ? 0.0
                        : lettering.anchor == TextAnchor::middle ? 0.5
                                                                 : 1.0;
  double x = before == 0.0 ? 0.0 : -before * advance_width(cr, runs);
  for (const TextRun& run : runs) {
    const double lift = run.level == TextLevel::superscript ? kSuperscript
                        : run.level == TextLevel::subscript ? -kSubscript
                                                            : 0.0;
    cairo_set_font_size(cr, font_size(run.level));
    cairo_move_to(cr, x, -lift);
    cairo_show_text(cr, run.words.c_str());
    cairo_text_extents_t extents;
    cairo_text_extents(cr, run.words.c_str(), &extents);
    x += extents.x_advance;
  }
  cairo_restore(cr);
  require_success(cairo_status(cr));
}

std::string CairoCanvas::finish() && {
  page_->context.reset();
  cairo_surface_t* surface = page_->surface.get();
  if (page_->options.format == Format::png) {
    require_success(cairo_surface_write_to_png_stream(surface, append_bytes, &page_->bytes));
  }
  cairo_surface_finish(surface);
  require_success(cairo_surface_status(surface));
  return std::move(page_->bytes);
}

}  // namespace credence::internal
