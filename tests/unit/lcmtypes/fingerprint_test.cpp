#include <gtest/gtest.h>

#include <map>

#include "bot_core/image_metadata_t.hpp"
#include "bot_core/image_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "lcm_tools/schema/built_in_sources.hpp"
#include "marco/grid_map_t.hpp"
#include "marco/imu_t.hpp"
#include "marco/lidar_raw_t.hpp"
#include "marco/loop_closures_t.hpp"
#include "marco/maebot_encoders_t.hpp"
#include "marco/map_request_t.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "marco/mesh_t.hpp"
#include "marco/odometry_t.hpp"
#include "marco/pantilt_state_t.hpp"
#include "marco/pose2_t.hpp"
#include "marco/process_status_t.hpp"
#include "marco/scene_t.hpp"
#include "marco/sensor_info_t.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "marco/trajectory_t.hpp"

namespace marco {
namespace {

// The values other people's programs expect: libbot2's and mbot's own fingerprints.
TEST(Fingerprint, BotCoreTypesAreLibbotsOwn) {
  EXPECT_EQ(static_cast<uint64_t>(bot_core::planar_lidar_t::getHash()), 0xe3d17423180b5e8dU);
  EXPECT_EQ(static_cast<uint64_t>(bot_core::pose_t::getHash()), 0x2e16efb052b0105eU);
  EXPECT_EQ(static_cast<uint64_t>(bot_core::image_t::getHash()), 0x14739ffe13d5f5f0U);
  EXPECT_EQ(static_cast<uint64_t>(bot_core::image_metadata_t::getHash()), 0x9a4b634d0577fb8eU);
}

TEST(Fingerprint, MbotTypesAreMbotsOwn) {
  EXPECT_EQ(static_cast<uint64_t>(lidar_raw_t::getHash()), 0x89dc5b879a5056cfU);
  EXPECT_EQ(static_cast<uint64_t>(mbot_pose2d_t::getHash()), 0x1f317af1246276acU);
  EXPECT_EQ(static_cast<uint64_t>(maebot_encoders_t::getHash()), 0x7d090bfb221d74f9U);
}

template <class Message>
std::pair<std::string, uint64_t> generated() {
  return {std::string("marco.") + Message::getTypeName(),
          static_cast<uint64_t>(Message::getHash())};
}

// The schema reader agrees with lcm-gen about every type that the programs carry as text.
TEST(Fingerprint, OfTheBuiltInSourcesAreLcmGensOwn) {
  const lcm_schema::Schema schema(built_in_sources());
  EXPECT_TRUE(schema.problems().empty());
  const std::map<std::string, uint64_t> expected = {
      generated<grid_map_t>(),        generated<imu_t>(),
      generated<lidar_raw_t>(),       generated<loop_closures_t>(),
      generated<maebot_encoders_t>(), generated<map_request_t>(),
      generated<mbot_pose2d_t>(),     generated<mesh_t>(),
      generated<odometry_t>(),        generated<pantilt_state_t>(),
      generated<pose2_t>(),           generated<process_status_t>(),
      generated<scene_t>(),           generated<sensor_info_t>(),
      generated<slam_command_t>(),    generated<slam_pose_t>(),
      generated<trajectory_t>()};
  for (const auto& [name, hash] : expected) {
    const auto index = schema.find(name);
    ASSERT_TRUE(index) << name;
    EXPECT_EQ(schema.structures()[static_cast<std::size_t>(*index)].fingerprint, hash) << name;
  }
}

}  // namespace
}  // namespace marco
