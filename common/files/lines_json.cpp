#include "common/files/lines_json.hpp"

#include <nlohmann/json.hpp>

namespace marco::files {

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

}  // namespace marco::files
