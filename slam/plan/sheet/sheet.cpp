#include "slam/plan/sheet/sheet.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/format.hpp"

namespace marco::slam {
namespace {

constexpr double kPointsPerMm = 72.0 / 25.4;  // PDF's unit

std::string escaped_xml(const std::string& text) {
  std::string out;
  for (const char letter : text) {
    switch (letter) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += letter;
    }
  }
  return out;
}

// UTF-8 to the one-byte set of the PDF's font, and escaped. What the set lacks becomes "?".
std::string escaped_pdf(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x80) {
      if (byte == '(' || byte == ')' || byte == '\\') out += '\\';
      out += static_cast<char>(byte);
    } else if ((byte == 0xC2 || byte == 0xC3) && i + 1 < text.size()) {
      const auto next = static_cast<unsigned char>(text[++i]);
      out += format("\\%03o", static_cast<unsigned>(byte == 0xC2 ? next : next + 0x40));
    } else if (byte >= 0xC0) {
      out += '?';
    }
  }
  return out;
}

std::string svg_colour(double grey) {
  const int level = static_cast<int>(std::lround(255 * grey));
  return format("rgb(%d,%d,%d)", level, level, level);
}

std::string svg_path(const Sheet::Path& path, double height_mm) {
  std::string out = "<path ";
  if (!path.layer.empty()) out += "class=\"" + escaped_xml(path.layer) + "\" ";
  out += "d=\"";
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    out += format("%s%.3f %.3f", i == 0 ? "M" : "L", path.points[i].x(),
                  height_mm - path.points[i].y());
  }
  if (path.closed) out += "Z";
  out += "\" fill=\"" + (path.style.fill < 0 ? "none" : svg_colour(path.style.fill)) + "\"";
  if (path.style.width_mm > 0) {
    out += " stroke=\"" + svg_colour(path.style.grey) + "\"" +
           format(" stroke-width=\"%.3f\" stroke-linecap=\"round\" stroke-linejoin=\"round\"",
                  path.style.width_mm);
    if (!path.style.dash_mm.empty()) {
      out += " stroke-dasharray=\"";
      for (const double dash : path.style.dash_mm) out += format("%.2f ", dash);
      out += "\"";
    }
  }
  return out + "/>\n";
}

std::string pdf_path(const Sheet::Path& path) {
  std::string out;
  const Sheet::Style& style = path.style;
  if (style.fill >= 0) out += format("%.3f g\n", style.fill);
  if (style.width_mm > 0) {
    out += format("%.3f G %.4f w [", style.grey, style.width_mm * kPointsPerMm);
    for (const double dash : style.dash_mm) out += format("%.3f ", dash * kPointsPerMm);
    out += "] 0 d\n";
  }
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    out += format("%.4f %.4f %s\n", path.points[i].x() * kPointsPerMm,
                  path.points[i].y() * kPointsPerMm, i == 0 ? "m" : "l");
  }
  if (path.closed) out += "h ";
  const bool fills = style.fill >= 0, strokes = style.width_mm > 0;
  return out + (fills && strokes ? "B\n" : fills ? "f\n" : strokes ? "S\n" : "n\n");
}

double shift_of(const Sheet::Text& text) {
  return text.anchor == Sheet::Anchor::start    ? 0.0
         : text.anchor == Sheet::Anchor::middle ? -text_width_mm(text) / 2
                                                : -text_width_mm(text);
}

}  // namespace

double text_width_mm(const Sheet::Text& text) {
  double em = 0;
  for (const char letter : text.text) {
    const auto byte = static_cast<unsigned char>(letter);
    if ((byte & 0xC0) == 0x80) continue;
    em += letter == ' ' || letter == '.' || letter == ',' || letter == ':' || letter == 'i' ||
                  letter == 'l'
              ? 0.278
          : byte == 0xC2                   ? 0.36
          : letter == 'm'                  ? 0.833
          : letter >= 'A' && letter <= 'Z' ? 0.68
                                           : 0.54;
  }
  return em * text.height_mm * (text.bold ? 1.06 : 1.0);
}

std::string sheet_svg(const Sheet& sheet) {
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  out += format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.3fmm\" height=\"%.3fmm\" viewBox=\"0 0 "
      "%.3f %.3f\"",
      sheet.width_mm, sheet.height_mm, sheet.width_mm, sheet.height_mm);
  if (sheet.scale > 0) out += format(" data-metres-per-unit=\"%g\"", sheet.scale / 1000);
  out += ">\n";
  out += "<title>" + escaped_xml(sheet.title) +
         "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  for (const Sheet::Path& path : sheet.paths) out += svg_path(path, sheet.height_mm);
  for (const Sheet::Text& text : sheet.texts) {
    const double x = text.at.x(), y = sheet.height_mm - text.at.y();
    const char* anchor = text.anchor == Sheet::Anchor::start    ? "start"
                         : text.anchor == Sheet::Anchor::middle ? "middle"
                                                                : "end";
    out += format(
        "<text x=\"%.3f\" y=\"%.3f\" font-family=\"Helvetica,Arial,sans-serif\" font-size=\"%.2f\" "
        "text-anchor=\"%s\"%s",
        x, y, text.height_mm, anchor, text.bold ? " font-weight=\"bold\"" : "");
    if (text.angle_rad != 0.0)
      out += format(" transform=\"rotate(%.3f %.3f %.3f)\"",
                    -text.angle_rad * 180 / std::numbers::pi, x, y);
    out += ">" + escaped_xml(text.text) + "</text>\n";
  }
  return out + "</svg>\n";
}

std::string sheet_pdf(const Sheet& sheet) {
  std::string content = "1 J 1 j\n";
  for (const Sheet::Path& path : sheet.paths) content += pdf_path(path);
  content += "0 g\n";
  for (const Sheet::Text& text : sheet.texts) {
    const double c = std::cos(text.angle_rad), s = std::sin(text.angle_rad);
    const Eigen::Vector2d at = (text.at + shift_of(text) * Eigen::Vector2d(c, s)) * kPointsPerMm;
    content += format("BT /F%d %.3f Tf %.5f %.5f %.5f %.5f %.4f %.4f Tm (", text.bold ? 2 : 1,
                      text.height_mm * kPointsPerMm, c, s, -s, c, at.x(), at.y());
    content += escaped_pdf(text.text) + ") Tj ET\n";
  }
  const std::array<std::string, 7> objects{
      "<< /Type /Catalog /Pages 2 0 R >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 %.4f %.4f] /Contents 4 0 R /Resources << "
             "/Font << /F1 5 0 R /F2 6 0 R >> >> >>",
             sheet.width_mm * kPointsPerMm, sheet.height_mm * kPointsPerMm),
      format("<< /Length %zu >>\nstream\n", content.size()) + content + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica-Bold /Encoding /WinAnsiEncoding >>",
      "<< /Title (" + escaped_pdf(sheet.title) + ") /Producer (Marco) >>"};
  std::string pdf = "%PDF-1.4\n";
  std::string table = format("xref\n0 %zu\n0000000000 65535 f \n", objects.size() + 1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += format("%010zu 00000 n \n", pdf.size());
    pdf += format("%zu 0 obj\n", i + 1) + objects[i] + "\nendobj\n";
  }
  const std::size_t start = pdf.size();
  return pdf + table +
         format("trailer\n<< /Size %zu /Root 1 0 R /Info 7 0 R >>\nstartxref\n%zu\n%%%%EOF\n",
                objects.size() + 1, start);
}

}  // namespace marco::slam
