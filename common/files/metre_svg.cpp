#include "common/files/metre_svg.hpp"

#include "lcm_tools/base/format.hpp"

namespace marco::files {

MetreSvg::MetreSvg(const Points& in_view, const std::string& style) {
  Eigen::Vector2d low(0, 0), high(0, 0);
  if (!in_view.empty()) low = high = in_view.front();
  for (const Eigen::Vector2d& point : in_view) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  low = low.array().floor() - 0.5;
  high = high.array().ceil() + 0.5;
  const Eigen::Vector2d size = high - low;
  svg_ = format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" data-metres-per-unit=\"1\" "
      "viewBox=\"%.3f %.3f %.3f %.3f\" "
      "width=\"%.0f\" height=\"%.0f\">\n"
      "<rect x=\"%.3f\" y=\"%.3f\" width=\"%.3f\" height=\"%.3f\" fill=\"white\"/>\n",
      low.x(), -high.y(), size.x(), size.y(), 40.0 * size.x(), 40.0 * size.y(), low.x(), -high.y(),
      size.x(), size.y());
  svg_ += "<style>.grid{stroke:#ddd;stroke-width:0.01}" + style + "</style>\n";
  const Eigen::Vector2i first = low.array().ceil().cast<int>();
  const Eigen::Vector2i last = high.array().floor().cast<int>();
  for (int x = first.x(); x <= last.x(); ++x) {
    line("class=\"grid\"", {x, low.y()}, {x, high.y()});
  }
  for (int y = first.y(); y <= last.y(); ++y) {
    line("class=\"grid\"", {low.x(), y}, {high.x(), y});
  }
}

void MetreSvg::line(const std::string& attributes,
                    const Eigen::Vector2d& from,
                    const Eigen::Vector2d& to) {
  svg_ += "<line " + attributes +
          format(" x1=\"%.4f\" y1=\"%.4f\" x2=\"%.4f\" y2=\"%.4f\"/>\n", from.x(), -from.y(),
                 to.x(), -to.y());
}

void MetreSvg::circle(const std::string& attributes,
                      const Eigen::Vector2d& middle,
                      double radius_m) {
  svg_ += "<circle " + attributes +
          format(" cx=\"%.4f\" cy=\"%.4f\" r=\"%.4f\"/>\n", middle.x(), -middle.y(), radius_m);
}

void MetreSvg::text(const Eigen::Vector2d& middle, const std::string& plain) {
  svg_ += format("<text x=\"%.4f\" y=\"%.4f\" text-anchor=\"middle\">", middle.x(), -middle.y()) +
          plain + "</text>\n";
}

void MetreSvg::polyline(const Points& points, const std::string& attributes) {
  svg_ += "<polyline " + attributes + (attributes.empty() ? "" : " ") + "points=\"";
  for (const Eigen::Vector2d& point : points) {
    svg_ += format("%.4f,%.4f ", point.x(), -point.y());
  }
  svg_ += "\"/>\n";
}

}  // namespace marco::files
