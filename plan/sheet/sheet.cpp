#include "plan/sheet/sheet.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/format.hpp"
#include "plan/bulge.hpp"

namespace marco::plan {
namespace {

std::string escaped_xml(const std::string& text) {
  constexpr std::pair<char, const char*> kEntities[] = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string out;
  for (const char letter : text) {
    const auto* entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                      [&](const auto& one) { return one.first == letter; });
    out += entity == std::end(kEntities) ? std::string(1, letter) : entity->second;
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
  if (!path.points.empty()) {
    out += format("M%.3f %.3f", path.points[0].x(), height_mm - path.points[0].y());
  }
  for (const Sheet::Stretch& part : path.stretches()) {
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

}  // namespace

std::vector<Sheet::Stretch> Sheet::Path::stretches() const {
  std::vector<Stretch> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double bulge = i < bulges.size() ? bulges[i] : 0.0;
    const bool last = i + 1 == points.size();
    if (!last || (closed && bulge != 0.0)) {
      all.push_back({points[i], points[(i + 1) % points.size()], bulge});
    }
  }
  return all;
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

}  // namespace marco::plan
