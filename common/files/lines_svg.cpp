#include "common/files/lines_svg.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "common/files/metre_svg.hpp"

namespace marco::files {

std::string lines_svg(const Walls& walls, const Trajectory& path) {
  MetreSvg::Points driven, in_view;
  for (const StampedPose2& pose : path) driven.push_back(pose.world_from_robot.translation_m());
  in_view = driven;
  for (const Wall& wall : walls) in_view.insert(in_view.end(), {wall.start_m, wall.end_m});
  MetreSvg svg(in_view,
               ".wall{stroke:#0a7d24;stroke-width:0.05;stroke-linecap:round}"
               "polyline{fill:none;stroke:#c0281c;stroke-width:0.03}");
  if (!driven.empty()) svg.polyline(driven);
  for (const Wall& wall : walls) {
    std::array<char, 60> attributes{};
    std::snprintf(attributes.data(), attributes.size(), "class=\"wall\" opacity=\"%.2f\"",
                  std::clamp(wall.existence, 0.2, 1.0));
    svg.line(attributes.data(), wall.start_m, wall.end_m);
  }
  return svg.finish();
}

}  // namespace marco::files
