#include "common/files/lines_svg.hpp"

#include <algorithm>

#include "common/files/metre_svg.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::files {
namespace {

std::string attributes_of(double existence) {
  return format("class=\"wall\" opacity=\"%.2f\"", std::clamp(existence, 0.2, 1.0));
}

}  // namespace

std::string lines_svg(const LineMap& map, const Trajectory& path) {
  MetreSvg::Points driven, in_view;
  for (const StampedPose2& pose : path) driven.push_back(pose.world_from_robot.translation_m());
  in_view = driven;
  for (const Wall& wall : map.walls) in_view.insert(in_view.end(), {wall.start_m, wall.end_m});
  std::vector<MetreSvg::Points> outlines;
  for (const RoundWall& wall : map.round_walls) {
    outlines.push_back(outline_of(wall));
    in_view.insert(in_view.end(), outlines.back().begin(), outlines.back().end());
  }
  MetreSvg svg(in_view,
               ".wall{stroke:#0a7d24;stroke-width:0.05;stroke-linecap:round;fill:none}"
               "polyline{fill:none;stroke:#c0281c;stroke-width:0.03}"
               "polyline.wall{stroke:#0a7d24;stroke-width:0.05}"
               ".corner{fill:none;stroke:#1440b0;stroke-width:0.02}");
  if (!driven.empty()) svg.polyline(driven);
  for (const Wall& wall : map.walls) {
    svg.line(attributes_of(wall.existence), wall.start_m, wall.end_m);
  }
  for (std::size_t i = 0; i < map.round_walls.size(); ++i) {
    svg.polyline(outlines[i], attributes_of(map.round_walls[i].existence));
  }
  // As a small square.
  constexpr double kHalfM = 0.06;
  for (const CornerPoint& corner : map.corners) {
    MetreSvg::Points square;
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}}) {
      square.push_back(corner.at_m + kHalfM * Eigen::Vector2d(x, y));
    }
    svg.polyline(square, "class=\"corner\"");
  }
  return svg.finish();
}

}  // namespace marco::files
