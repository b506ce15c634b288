#include "slam/plan/sheet/sheet.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/format.hpp"
#include "slam/plan/bulge.hpp"

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

// The stretches of a path: from a point to the next; of a closed path back to the first one, too,
// if that is bent.
struct Stretch {
  Eigen::Vector2d from, to;
  double bulge;
};
std::vector<Stretch> stretches_of(const Sheet::Path& path) {
  std::vector<Stretch> stretches;
  const std::size_t count = path.points.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double bulge = i < path.bulges.size() ? path.bulges[i] : 0.0;
    const bool last = i + 1 == count;
    if (!last || (path.closed && bulge != 0.0)) {
      stretches.push_back({path.points[i], path.points[(i + 1) % count], bulge});
    }
  }
  return stretches;
}

std::string svg_path(const Sheet::Path& path, double height_mm) {
  std::string out = "<path ";
  if (!path.layer.empty()) out += "class=\"" + escaped_xml(path.layer) + "\" ";
  out += "d=\"";
  if (!path.points.empty()) {
    out += format("M%.3f %.3f", path.points[0].x(), height_mm - path.points[0].y());
  }
  for (const Stretch& part : stretches_of(path)) {
    if (part.bulge == 0.0) {
      out += "L";
    } else {
      const double radius = bulge_arc(part.from, part.to, part.bulge).radius;
      out += format("A%.3f %.3f 0 %d %d ", radius, radius, std::abs(part.bulge) > 1 ? 1 : 0,
                    part.bulge > 0 ? 0 : 1);
    }
    out += format("%.3f %.3f", part.to.x(), height_mm - part.to.y());
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

// Bezier curves of a quarter turn at most: off a circle by less than 0.03 % of its radius.
std::string pdf_arc(const Stretch& part) {
  std::string out;
  const BulgeArc arc = bulge_arc(part.from, part.to, part.bulge);
  const int pieces = static_cast<int>(std::ceil(std::abs(arc.turn_rad) / (std::numbers::pi / 2)));
  const double reach = 4.0 / 3.0 * std::tan(arc.turn_rad / pieces / 4);
  for (int i = 0; i < pieces; ++i) {
    const Eigen::Vector2d from = arc.at(static_cast<double>(i) / pieces);
    const Eigen::Vector2d to = arc.at(static_cast<double>(i + 1) / pieces);
    const Eigen::Vector2d a = from - arc.centre, b = to - arc.centre;
    const Eigen::Vector2d first = from + reach * Eigen::Vector2d(-a.y(), a.x());
    const Eigen::Vector2d second = to - reach * Eigen::Vector2d(-b.y(), b.x());
    for (const Eigen::Vector2d& at : {first, second, to}) {
      out += format("%.4f %.4f ", at.x() * kPointsPerMm, at.y() * kPointsPerMm);
    }
    out += "c\n";
  }
  return out;
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
  const auto put = [&out](const Eigen::Vector2d& at, const char* how) {
    out += format("%.4f %.4f %s\n", at.x() * kPointsPerMm, at.y() * kPointsPerMm, how);
  };
  if (!path.points.empty()) put(path.points[0], "m");
  for (const Stretch& part : stretches_of(path)) {
    if (part.bulge == 0.0) {
      put(part.to, "l");
    } else {
      out += pdf_arc(part);
    }
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
