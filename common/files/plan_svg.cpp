#include "common/files/plan_svg.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace marco::files {

std::string plan_svg(const std::vector<std::vector<Eigen::Vector2d>>& chains) {
  Eigen::Vector2d low(0, 0), high(1, 1);
  bool first = true;
  for (const auto& chain : chains) {
    for (const Eigen::Vector2d& point : chain) {
      low = first ? point : Eigen::Vector2d(low.cwiseMin(point));
      high = first ? point : Eigen::Vector2d(high.cwiseMax(point));
      first = false;
    }
  }
  const double x0 = std::floor(low.x()) - 0.5, y0 = std::floor(low.y()) - 0.5;
  const double x1 = std::ceil(high.x()) + 0.5, y1 = std::ceil(high.y()) + 0.5;
  std::array<char, 500> text{};
  std::snprintf(text.data(), text.size(),
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"%.3f %.3f %.3f %.3f\" "
                "width=\"%.0f\" height=\"%.0f\">\n"
                "<style>polyline{fill:none;stroke:#222;stroke-width:0.03;stroke-linejoin:round}"
                "line{stroke:#ddd;stroke-width:0.01}</style>\n"
                "<rect x=\"%.3f\" y=\"%.3f\" width=\"%.3f\" height=\"%.3f\" fill=\"white\"/>\n",
                x0, -y1, x1 - x0, y1 - y0, 40.0 * (x1 - x0), 40.0 * (y1 - y0), x0, -y1, x1 - x0,
                y1 - y0);
  std::string svg = text.data();
  const auto grid = [&](double ax, double ay, double bx, double by) {
    std::snprintf(text.data(), text.size(),
                  "<line x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" y2=\"%.3f\"/>\n", ax, -ay, bx, -by);
    svg += text.data();
  };
  for (double x = std::ceil(x0); x <= x1; x += 1.0) grid(x, y0, x, y1);
  for (double y = std::ceil(y0); y <= y1; y += 1.0) grid(x0, y, x1, y);
  for (const auto& chain : chains) {
    svg += "<polyline points=\"";
    for (const Eigen::Vector2d& point : chain) {
      std::snprintf(text.data(), text.size(), "%.4f,%.4f ", point.x(), -point.y());
      svg += text.data();
    }
    svg += "\"/>\n";
  }
  return svg + "</svg>\n";
}

}  // namespace marco::files
