#include <cairo-pdf.h>
#include <pango/pangocairo.h>

#include <memory>
#include <set>
#include <stdexcept>

#include "plan/bulge.hpp"
#include "plan/sheet/sheet.hpp"

namespace marco::plan {
namespace {

constexpr double kPointsPerMm = 72.0 / 25.4;  // PDF's unit
// The first that is installed; for letters that it lacks, any other.
constexpr const char* kFonts = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans";

template <auto kFree>
struct Freed {
  void operator()(auto* what) const { kFree(what); }
};
template <class T, auto kFree>
using Owned = std::unique_ptr<T, Freed<kFree>>;
using Font = Owned<PangoFontDescription, pango_font_description_free>;
using TextLayout = Owned<PangoLayout, g_object_unref>;

cairo_status_t append(void* bytes, const unsigned char* data, unsigned count) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), count);
  return CAIRO_STATUS_SUCCESS;
}

void set_grey(cairo_t* page, double grey) { cairo_set_source_rgb(page, grey, grey, grey); }

void draw(cairo_t* page, const Sheet::Path& path) {
  if (path.points.empty()) return;
  cairo_move_to(page, path.points[0].x(), path.points[0].y());
  for (const Sheet::Stretch& part : path.stretches()) {
    if (part.bulge == 0.0) {
      cairo_line_to(page, part.to.x(), part.to.y());
      continue;
    }
    const BulgeArc arc = bulge_arc(part.from, part.to, part.bulge);
    const auto draw_arc = arc.turn_rad > 0 ? cairo_arc : cairo_arc_negative;
    draw_arc(page, arc.centre.x(), arc.centre.y(), arc.radius, arc.from_rad,
             arc.from_rad + arc.turn_rad);
  }
  if (path.closed) cairo_close_path(page);
  const Sheet::Style& style = path.style;
  if (style.fill >= 0) {
    set_grey(page, style.fill);
    cairo_fill_preserve(page);
  }
  if (style.width_mm > 0) {
    set_grey(page, style.grey);
    cairo_set_line_width(page, style.width_mm);
    cairo_set_dash(page, style.dash_mm.data(), static_cast<int>(style.dash_mm.size()), 0);
    cairo_stroke_preserve(page);
  }
  cairo_new_path(page);
}

TextLayout layout_of(cairo_t* page, const Sheet::Text& text) {
  const Font font(pango_font_description_from_string(kFonts));
  pango_font_description_set_absolute_size(font.get(), text.height_mm * PANGO_SCALE);
  if (text.bold) pango_font_description_set_weight(font.get(), PANGO_WEIGHT_BOLD);
  TextLayout layout(pango_cairo_create_layout(page));
  pango_context_set_round_glyph_positions(pango_layout_get_context(layout.get()), FALSE);
  pango_layout_set_font_description(layout.get(), font.get());
  pango_layout_set_single_paragraph_mode(layout.get(), TRUE);
  pango_layout_set_text(layout.get(), text.text.c_str(), -1);
  return layout;
}

void add_missing(std::set<gunichar>& missing, const PangoLayoutLine& line) {
  for (const GSList* run = line.runs; run != nullptr; run = run->next) {
    const PangoGlyphString& glyphs = *static_cast<PangoGlyphItem*>(run->data)->glyphs;
    for (int i = 0; i < glyphs.num_glyphs; ++i) {
      const PangoGlyph glyph = glyphs.glyphs[i].glyph;
      if ((glyph & PANGO_GLYPH_UNKNOWN_FLAG) != 0)
        missing.insert(glyph & ~PANGO_GLYPH_UNKNOWN_FLAG);
    }
  }
}

void draw(cairo_t* page, const Sheet::Text& text, std::set<gunichar>& missing) {
  cairo_save(page);
  set_grey(page, 0);
  cairo_translate(page, text.at.x(), text.at.y());
  cairo_rotate(page, text.angle_rad);
  cairo_scale(page, 1, -1);  // letters stand upright
  const TextLayout layout = layout_of(page, text);
  PangoLayoutLine* line = pango_layout_get_line_readonly(layout.get(), 0);
  PangoRectangle box;
  pango_layout_line_get_extents(line, nullptr, &box);
  const double share = text.anchor == Sheet::Anchor::start ? 0.0
                       : text.anchor == Sheet::Anchor::end ? 1.0
                                                           : 0.5;
  cairo_move_to(page, -share * pango_units_to_double(box.width), 0);
  cairo_set_dash(page, nullptr, 0, 0);  // of boxes
  const Owned<PangoFont, g_object_unref> font(pango_context_load_font(
      pango_layout_get_context(layout.get()), pango_layout_get_font_description(layout.get())));
  if (font) pango_cairo_show_layout_line(page, line);  // without any, boxes cover the sheet
  add_missing(missing, *line);
  cairo_restore(page);
}

}  // namespace

SheetPdf sheet_pdf(const Sheet& sheet) {
  SheetPdf pdf;
  std::set<gunichar> missing;
  const Owned<cairo_surface_t, cairo_surface_destroy> surface(cairo_pdf_surface_create_for_stream(
      append, &pdf.bytes, sheet.width_mm * kPointsPerMm, sheet.height_mm * kPointsPerMm));
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, sheet.title.c_str());
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "");
  const Owned<cairo_t, cairo_destroy> page(cairo_create(surface.get()));
  cairo_scale(page.get(), kPointsPerMm, -kPointsPerMm);
  cairo_translate(page.get(), 0, -sheet.height_mm);
  cairo_set_line_cap(page.get(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(page.get(), CAIRO_LINE_JOIN_ROUND);
  for (const Sheet::Path& path : sheet.paths) draw(page.get(), path);
  for (const Sheet::Text& text : sheet.texts) draw(page.get(), text, missing);
  cairo_surface_finish(surface.get());
  const cairo_status_t status = cairo_status(page.get());
  if (status != CAIRO_STATUS_SUCCESS) throw std::runtime_error(cairo_status_to_string(status));
  for (const gunichar letter : missing) {
    char bytes[6];
    pdf.missing.append(bytes, static_cast<std::size_t>(g_unichar_to_utf8(letter, bytes)));
  }
  return pdf;
}

}  // namespace marco::plan
