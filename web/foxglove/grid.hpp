#pragma once

#include <string>

#include "common/grid_map.hpp"
#include "lcm_tools/schema/tree.hpp"

namespace marco::foxglove {

/// The fields of a foxglove.Grid after its stamp and frame: free is white, occupied black, unknown
/// transparent.
std::string floor_plan_json(const GridMap& map);

constexpr uint64_t kMbotGrid = 0xd5447e494a66cc92;  ///< mbot_lcm_msgs.occupancy_grid_t
/// The same for a message of that type: one field of log odds. "" when it contradicts itself.
std::string mbot_grid_json(const lcm_schema::Tree& tree);

}  // namespace marco::foxglove
