#include "common/files/lines_svg.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace marco::files {
namespace {

struct Bounds {
  double x0 = 0.0, y0 = 0.0, x1 = 0.0, y1 = 0.0;
  bool empty = true;
  void add(const Eigen::Vector2d& point) {
    x0 = empty ? point.x() : std::min(x0, point.x());
    y0 = empty ? point.y() : std::min(y0, point.y());
    x1 = empty ? point.x() : std::max(x1, point.x());
    y1 = empty ? point.y() : std::max(y1, point.y());
    empty = false;
  }
};

Bounds bounds_of(const Walls& walls, const Trajectory& path) {
  Bounds bounds;
  for (const Wall& wall : walls) {
    bounds.add(wall.start_m);
    bounds.add(wall.end_m);
  }
  for (const StampedPose2& pose : path) bounds.add(pose.world_from_robot.translation_m());
  return bounds;
}

std::string line(const char* name, double x1, double y1, double x2, double y2, double opacity) {
  char text[200];
  std::snprintf(text, sizeof(text),
                "<line class=\"%s\" x1=\"%.4f\" y1=\"%.4f\" x2=\"%.4f\" y2=\"%.4f\" "
                "opacity=\"%.2f\"/>\n",
                name, x1, -y1, x2, -y2, opacity);
  return text;
}

}  // namespace

std::string lines_svg(const Walls& walls, const Trajectory& path) {
  const Bounds bounds = bounds_of(walls, path);
  const double x0 = std::floor(bounds.x0) - 0.5, y0 = std::floor(bounds.y0) - 0.5;
  const double x1 = std::ceil(bounds.x1) + 0.5, y1 = std::ceil(bounds.y1) + 0.5;
  char head[600];
  std::snprintf(head, sizeof(head),
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"%.3f %.3f %.3f %.3f\" "
                "width=\"%.0f\" height=\"%.0f\">\n"
                "<style>line{stroke-width:0.05;stroke-linecap:round}.wall{stroke:#0a7d24}"
                ".grid{stroke:#ddd;stroke-width:0.01}"
                "polyline{fill:none;stroke:#c0281c;stroke-width:0.03}</style>\n"
                "<rect x=\"%.3f\" y=\"%.3f\" width=\"%.3f\" height=\"%.3f\" fill=\"white\"/>\n",
                x0, -y1, x1 - x0, y1 - y0, 40.0 * (x1 - x0), 40.0 * (y1 - y0), x0, -y1, x1 - x0,
                y1 - y0);
  std::string svg = head;
  for (double x = std::ceil(x0); x <= x1; x += 1.0) svg += line("grid", x, y0, x, y1, 1.0);
  for (double y = std::ceil(y0); y <= y1; y += 1.0) svg += line("grid", x0, y, x1, y, 1.0);
  if (!path.empty()) {
    svg += "<polyline points=\"";
    for (const StampedPose2& pose : path) {
      char point[60];
      std::snprintf(point, sizeof(point), "%.3f,%.3f ", pose.world_from_robot.x_m,
                    -pose.world_from_robot.y_m);
      svg += point;
    }
    svg += "\"/>\n";
  }
  for (const Wall& wall : walls) {
    svg += line("wall", wall.start_m.x(), wall.start_m.y(), wall.end_m.x(), wall.end_m.y(),
                std::clamp(wall.existence, 0.2, 1.0));
  }
  return svg + "</svg>\n";
}

}  // namespace marco::files
