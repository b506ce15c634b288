#include "common/files/lines_json.hpp"

#include <nlohmann/json.hpp>

#include "lcm_tools/base/check.hpp"

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

Walls parse_lines_json(const std::string& text) {
  try {
    const nlohmann::json root = nlohmann::json::parse(text);
    Walls walls;
    for (const nlohmann::json& entry : root.at("walls")) {
      Wall& wall = walls.emplace_back();
      wall.id = entry.at("id").get<int64_t>();
      for (std::size_t i = 0; i < 2; ++i) {
        wall.start_m(static_cast<Eigen::Index>(i)) = entry.at("start_m").at(i).get<double>();
        wall.end_m(static_cast<Eigen::Index>(i)) = entry.at("end_m").at(i).get<double>();
      }
      for (std::size_t k = 0; k < 16; ++k) {
        wall.covariance(static_cast<Eigen::Index>(k / 4), static_cast<Eigen::Index>(k % 4)) =
            entry.at("covariance_m2").at(k / 4).at(k % 4).get<double>();
      }
      wall.existence = entry.at("existence").get<double>();
      wall.times_seen = entry.at("times_seen").get<int64_t>();
      wall.start_seen = entry.at("start_seen").get<bool>();
      wall.end_seen = entry.at("end_seen").get<bool>();
    }
    return walls;
  } catch (const nlohmann::json::exception& wrong) {
    throw std::invalid_argument(std::string("lines.json: ") + wrong.what());
  }
}

}  // namespace marco::files
