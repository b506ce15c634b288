#include <gtest/gtest.h>

#include "bot_core/image_metadata_t.hpp"
#include "bot_core/image_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "marco/lidar_raw_t.hpp"
#include "marco/maebot_encoders_t.hpp"
#include "marco/mbot_pose2d_t.hpp"

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

}  // namespace
}  // namespace marco
