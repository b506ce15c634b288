#include "common/files/line_map_files.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/files/metre_svg.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::files {
namespace {

std::string attributes_of(double existence) {
  return format("class=\"wall\" opacity=\"%.2f\"", std::clamp(existence, 0.2, 1.0));
}

}  // namespace

std::string lines_json(const LineMap& map) {
  nlohmann::ordered_json root;
  root["unit"] = "m";
  root["walls"] = nlohmann::ordered_json::array();
  for (const Wall& wall : map.walls) {
    nlohmann::ordered_json entry;
    entry["id"] = wall.id;
    entry["start_m"] = {wall.start_m.x(), wall.start_m.y()};
    entry["end_m"] = {wall.end_m.x(), wall.end_m.y()};
    for (Eigen::Index i = 0; i < 4; ++i) {
      entry["covariance_m2"].push_back({wall.covariance(i, 0), wall.covariance(i, 1),
                                        wall.covariance(i, 2), wall.covariance(i, 3)});
    }
    entry["existence"] = wall.existence;
    entry["times_seen"] = wall.times_seen;
    entry["start_seen"] = wall.start_seen;
    entry["end_seen"] = wall.end_seen;
    root["walls"].push_back(std::move(entry));
  }
  root["round_walls"] = nlohmann::ordered_json::array();
  for (const RoundWall& wall : map.round_walls) {
    nlohmann::ordered_json entry;
    entry["id"] = wall.id;
    entry["centre_m"] = {wall.centre_m.x(), wall.centre_m.y()};
    entry["radius_m"] = wall.radius_m;
    for (Eigen::Index i = 0; i < 3; ++i) {
      entry["covariance_m2"].push_back(
          {wall.covariance(i, 0), wall.covariance(i, 1), wall.covariance(i, 2)});
    }
    entry["from_inside"] = wall.from_inside;
    entry["from_rad"] = wall.from_rad;
    entry["span_rad"] = wall.span_rad;
    entry["existence"] = wall.existence;
    entry["times_seen"] = wall.times_seen;
    root["round_walls"].push_back(std::move(entry));
  }
  root["corners"] = nlohmann::ordered_json::array();
  for (const CornerPoint& corner : map.corners) {
    nlohmann::ordered_json entry;
    entry["at_m"] = {corner.at_m.x(), corner.at_m.y()};
    for (Eigen::Index i = 0; i < 2; ++i) {
      entry["covariance_m2"].push_back({corner.covariance(i, 0), corner.covariance(i, 1)});
    }
    entry["walls"] = corner.wall_ids;
    entry["convex"] = corner.convex;
    root["corners"].push_back(std::move(entry));
  }
  return root.dump(1) + "\n";
}

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

std::string lines_dxf(const LineMap& map) {
  std::string dxf =
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n"
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n3\n"
      "0\nLAYER\n2\nWALLS\n70\n0\n62\n3\n6\nCONTINUOUS\n"
      "0\nLAYER\n2\nPOSTS\n70\n0\n62\n5\n6\nCONTINUOUS\n"
      "0\nLAYER\n2\nCORNERS\n70\n0\n62\n1\n6\nCONTINUOUS\n0\nENDTAB\n0\nENDSEC\n"
      "0\nSECTION\n2\nENTITIES\n";
  for (const Wall& wall : map.walls) {
    dxf += format("0\nLINE\n8\nWALLS\n10\n%.6f\n20\n%.6f\n30\n0.0\n11\n%.6f\n21\n%.6f\n31\n0.0\n",
                  wall.start_m.x(), wall.start_m.y(), wall.end_m.x(), wall.end_m.y());
  }
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  for (const RoundWall& wall : map.round_walls) {
    dxf += format("0\n%s\n8\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n40\n%.6f\n",
                  wall.is_whole() ? "CIRCLE" : "ARC",
                  wall.is_whole() && !wall.from_inside ? "POSTS" : "WALLS", wall.centre_m.x(),
                  wall.centre_m.y(), wall.radius_m);
    if (wall.is_whole()) continue;
    dxf += format("50\n%.6f\n51\n%.6f\n", wall.from_rad * kDegrees,
                  (wall.from_rad + wall.span_rad) * kDegrees);
  }
  for (const CornerPoint& corner : map.corners) {
    dxf += format("0\nPOINT\n8\nCORNERS\n10\n%.6f\n20\n%.6f\n30\n0.0\n", corner.at_m.x(),
                  corner.at_m.y());
  }
  return dxf + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace marco::files
