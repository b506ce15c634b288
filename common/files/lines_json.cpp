#include "common/files/lines_json.hpp"

#include <nlohmann/json.hpp>

namespace marco::files {

std::string lines_json(const Walls& walls) {
  nlohmann::ordered_json root;
  root["unit"] = "m";
  root["walls"] = nlohmann::ordered_json::array();
  for (const Wall& wall : walls) {
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
  return root.dump(1) + "\n";
}

}  // namespace marco::files
