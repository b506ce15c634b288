#include "tools/spy/page_text.hpp"

#include <algorithm>
#include <cmath>

namespace marco::spy {

std::string plural(int64_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string age_text(double age_s) {
  if (age_s < 0) age_s = 0;
  if (age_s < 99.95) return plain_number(std::round(age_s * 10) / 10) + " s";
  if (age_s < 5999) return std::to_string(static_cast<int64_t>(age_s / 60)) + " min";
  return std::to_string(static_cast<int64_t>(age_s / 3600)) + " h";
}

std::string loss_text(const Loss& loss) {
  std::string text(loss.estimated ? "~" : "");
  text += short_number(static_cast<double>(loss.count));
  return text;
}

int first_row(int selected, int count, int shown) {
  return std::clamp(selected - shown / 2, 0, std::max(0, count - shown));
}

int draw_findings(Canvas& canvas, const Surroundings& around, int y, Problems problems) {
  for (const Finding& finding : around.findings) {
    if (y + 1 >= canvas.height()) return y;
    canvas.text(1, y++, "! " + finding.text, Style::warn);
    if (!finding.command.empty() && y + 1 < canvas.height())
      canvas.text(5, y++, finding.command, Style::bold);
  }
  std::size_t shown = 0;
  for (const std::string& problem : around.problems) {
    if (y + 1 >= canvas.height() || (problems == Problems::first_three && ++shown > 3)) break;
    canvas.text(1, y++, "! " + problem, Style::warn);
  }
  return y;
}

}  // namespace marco::spy
