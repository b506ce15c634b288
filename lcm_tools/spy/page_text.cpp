#include "lcm_tools/spy/page_text.hpp"

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

namespace {

struct Line {
  int indent;
  std::string text;
  Style style;
};

// Breaks at blanks where it can; what follows the first line stands two cells further in.
void wrap(std::string_view text, int indent, int width, Style style, std::vector<Line>& lines) {
  int further = 0;
  while (true) {
    const auto room = static_cast<std::size_t>(std::max(10, width - indent - further - 1));
    if (text.size() <= room) {
      lines.push_back({indent + further, std::string(text), style});
      return;
    }
    const std::size_t blank = text.rfind(' ', room);
    const std::size_t end = blank == std::string_view::npos || blank == 0 ? room : blank;
    lines.push_back({indent + further, std::string(text.substr(0, end)), style});
    text.remove_prefix(end == blank ? end + 1 : end);
    further = 2;
  }
}

std::vector<Line> finding_lines(const Surroundings& around, int width, Problems problems) {
  std::vector<Line> lines;
  for (const Finding& finding : around.findings) {
    wrap("! " + finding.text, 1, width, Style::warn, lines);
    // A command is for copying: it stays in one line.
    if (!finding.command.empty()) lines.push_back({5, finding.command, Style::bold});
  }
  std::size_t shown = 0;
  for (const std::string& problem : around.problems) {
    if (problems == Problems::first_three && ++shown > 3) break;
    wrap("! " + problem, 1, width, Style::warn, lines);
  }
  return lines;
}

}  // namespace

int rows_of_findings(const Surroundings& around, int width, Problems problems) {
  return static_cast<int>(finding_lines(around, width, problems).size());
}

int draw_findings(Canvas& canvas, const Surroundings& around, int y, Problems problems) {
  for (const Line& line : finding_lines(around, canvas.width(), problems)) {
    if (y + 1 >= canvas.height()) break;
    canvas.text(line.indent, y++, line.text, line.style);
  }
  return y;
}

}  // namespace marco::spy
