#include "slam/localization/saved_map.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "common/byte_archive.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recorded_drive.hpp"
#include "slam/session/mapping_session.hpp"
#include "slam/session/merge_maps.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::testing::HasSubstr;

// Two different rooms, 20 x 6 m, and a door between them.
testing::FlatWorld two_rooms() {
  testing::FlatWorld world = testing::small_room();
  world.add_chain({{-4, -3}, {-4, -6}, {12, -6}, {12, 3}, {4, 3}});
  world.add_box(8.0, -2.0, 8.5, -0.6);
  world.add_box(10.5, 0.4, 11.2, 1.0);
  world.add_box(6.0, -5.2, 6.9, -4.9);
  return world;
}

// In the second room: round the box at its middle, 4.2 m a side with round corners.
std::vector<Pose2> round_the_box(const Pose2& start, int steps) {
  std::vector<Pose2> path{start};
  for (int i = 1; i < steps; ++i) {
    path.push_back(path.back() * Pose2{0.1, 0, deg_to_rad(i % 40 >= 32 ? 11.25 : 0.0)});
  }
  return path;
}

class SavedMapTest : public ::testing::Test {
 protected:
  // Odometry that is 3 % long; @param seed of the scans' noise
  std::vector<SlamInput> drive(const std::vector<Pose2>& path, uint32_t seed, int64_t start_us) {
    return recorded_drive(world_, path, seed, start_us);
  }
  static void expect_equal(const Trajectory& a, const Trajectory& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].utime, b[i].utime);
      ASSERT_EQ(a[i].world_from_robot.x_m, b[i].world_from_robot.x_m) << i;
      ASSERT_EQ(a[i].world_from_robot.theta_rad, b[i].world_from_robot.theta_rad) << i;
    }
  }
  testing::FlatWorld world_ = two_rooms();
  std::vector<Pose2> path_ = round_the_box({6.3, -3.6, 0.0}, 130);
};

TEST_F(SavedMapTest, RestoredFromItsBytesASlamGoesOnAsIfNothingHadBeen) {
  const std::vector<SlamInput> inputs = drive(path_, 3, 0);
  Slam whole, first;
  for (const SlamInput& input : inputs) whole.process(input);
  whole.finish();
  for (std::size_t i = 0; i < 71; ++i) first.process(inputs[i]);
  Slam resumed;
  resumed.restore(decode_saved_map(encode_saved_map({"", {0}, first.state()})).slam);
  for (std::size_t i = 71; i < inputs.size(); ++i) resumed.process(inputs[i]);
  resumed.finish();
  expect_equal(whole.trajectory(), resumed.trajectory());
  EXPECT_EQ(whole.loops().size(), resumed.loops().size());
}

TEST_F(SavedMapTest, WhatLiesFartherAwayThanAnyBuildingIsRefused) {
  Slam slam;
  for (const SlamInput& input : drive({path_.begin(), path_.begin() + 12}, 3, 0)) {
    slam.process(input);
  }
  const auto said = [&](const auto& spoil) {
    SavedMap map{"", {0}, slam.state()};
    spoil(map.slam);
    return complaint([&] { decode_saved_map(encode_saved_map(map)); });
  };
  EXPECT_EQ(said([](SlamState&) {}), "");
  EXPECT_THAT(said([](SlamState& s) { s.keyframes.keys[1].world_from_robot.x_m = 1e300; }),
              HasSubstr("farther away"));
  EXPECT_THAT(said([](SlamState& s) { s.keyframes.keys[1].points_in_robot.points(1, 5) = -1e9; }),
              HasSubstr("farther away"));
  EXPECT_THAT(said([](SlamState& s) { s.path.scans[3].key_from_robot.y_m = 1e12; }),
              HasSubstr("farther away"));
  EXPECT_THAT(said([](SlamState& s) { s.back_end.edges[0].from_from_to.x_m = 1e12; }),
              HasSubstr("longer than"));
  EXPECT_THAT(said([](SlamState& s) { s.estimate.world_from_robot.x_m = 1e12; }),
              HasSubstr("farther away"));
  EXPECT_THAT(said([](SlamState& s) { s.path.keyframe_poses.pop_back(); }),
              HasSubstr("more keyframe poses"));
  EXPECT_THAT(said([](SlamState& s) { s.path.keyframe_poses.push_back(s.path.keyframe_poses[0]); }),
              HasSubstr("more keyframe poses"));
  EXPECT_THAT(said([](SlamState& s) { s.path.keyframe_poses[0].key = -1; }),
              HasSubstr("relative to no keyframe"));
  EXPECT_THAT(said([](SlamState& s) { s.keyframes.merged = -1; }), HasSubstr("impossible"));
  EXPECT_THAT(said([](SlamState& s) { s.keyframes.merged = 2'000'000'000; }),
              HasSubstr("impossible"));
}

// The local map begins at its first keyframe then, not before it.
TEST_F(SavedMapTest, AMapOfFewKeyScansOfManyThatWereIsGoneOnFrom) {
  const std::vector<SlamInput> inputs = drive({path_.begin(), path_.begin() + 12}, 3, 0);
  Slam slam, other;
  for (std::size_t i = 0; i + 1 < inputs.size(); ++i) slam.process(inputs[i]);
  SlamState state = slam.state();
  state.keyframes.merged = 1000;
  other.restore(state);
  const Pose2 there = other.process(inputs.back()).world_from_robot;
  EXPECT_EQ(there.vector(), slam.process(inputs.back()).world_from_robot.vector());
}

TEST_F(SavedMapTest, DamagedForeignAndCutFilesAreRefusedAndSaidSo) {
  Slam slam;
  for (const SlamInput& input : drive({path_.begin(), path_.begin() + 12}, 3, 0)) {
    slam.process(input);
  }
  const std::string bytes = encode_saved_map({"a = 1", {0}, slam.state()});
  ASSERT_EQ(decode_saved_map(bytes).options, "a = 1");
  const auto said = [](const std::string& of) { return complaint([&] { decode_saved_map(of); }); };
  EXPECT_THAT(said(""), HasSubstr("is no MARCOMAP file"));
  EXPECT_THAT(said("P5 100 100 255"), HasSubstr("is no MARCOMAP file"));
  EXPECT_THAT(said(bytes.substr(0, bytes.size() - 1)), HasSubstr("is truncated"));
  EXPECT_THAT(said(bytes.substr(0, 15)), HasSubstr("is truncated"));
  std::string flipped = bytes;
  flipped[bytes.size() / 2] = static_cast<char>(flipped[bytes.size() / 2] ^ 4);
  EXPECT_THAT(said(flipped), HasSubstr("is damaged"));
  EXPECT_THAT(said(seal("MARCOMAP", 99, "")), HasSubstr("version 99"));
}

std::string map_file(int version) {
  std::ifstream file(
      "tests/unit/slam/localization/map_version_" + std::to_string(version) + ".marco",
      std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Five scans of a room, half a metre apart, as the first program of each version wrote them: every
// later program reads these files.
class MapFileOfVersion : public SavedMapTest, public ::testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(All, MapFileOfVersion, ::testing::Values(12, 13));

TEST_P(MapFileOfVersion, IsRead) {
  const SavedMap map = decode_saved_map(map_file(GetParam()));
  EXPECT_EQ(map.options, "a = 1");
  EXPECT_EQ(map.session_starts, std::vector<int64_t>{0});
  const SlamState& slam = map.slam;
  ASSERT_EQ(slam.keyframes.keys.size(), 3U);
  EXPECT_EQ(slam.keyframes.merged, 0);
  EXPECT_EQ(slam.back_end.edges.size(), 2U);
  EXPECT_TRUE(slam.back_end.loops.empty());
  EXPECT_EQ(slam.path.scans.size(), 5U);
  EXPECT_EQ(slam.path.keyframe_poses.size(), 3U);
  EXPECT_THAT(slam.keyframes.keys[2].world_from_robot, IsNear(Pose2{2, 0, 0}, 0.05, 0.02));
  EXPECT_EQ(slam.estimate.world_from_robot.vector(),
            slam.keyframes.keys[2].world_from_robot.vector());
  EXPECT_NEAR(slam.keyframes.keys[2].path_m, 2.0, 0.05);
  ASSERT_TRUE(slam.motion.before.has_value());
  EXPECT_EQ(slam.motion.before->utime.us, 800'000);
  EXPECT_THAT(slam.motion.before->odom_from_robot.value(), IsNear(Pose2{2, 0, 0}, 1e-12, 1e-12));
}

TEST_F(SavedMapTest, AMapFileOfTheNewestVersionIsWrittenAsItWasRead) {
  const std::string bytes = map_file(13);
  EXPECT_EQ(encode_saved_map(decode_saved_map(bytes)), bytes)
      << "a new layout needs a new version, and this one read";
}

TEST_F(SavedMapTest, AMapOfVersion12StartsWithOdometryAsItIsAssumed) {
  const SlamState slam = decode_saved_map(map_file(12)).slam;
  EXPECT_EQ(slam.motion.odometry_noise.drift_per_m, OdometryNoise().drift_per_m);
  EXPECT_FALSE(slam.drift);
  Slam restored;
  restored.restore(slam);
  EXPECT_THAT(restored.state().drift.value().drifted.world_from_robot,
              IsNear(slam.estimate.world_from_robot, 0.0, 0.0));
}

TEST_F(SavedMapTest, BytesThatLieUnderAGoodChecksumAreRefusedToo) {
  Slam slam;
  for (const SlamInput& input : drive({path_.begin(), path_.begin() + 12}, 3, 0)) {
    slam.process(input);
  }
  const std::string sealed = encode_saved_map({"", {0}, slam.state()});
  const std::string payload(unseal("MARCOMAP", 13, sealed));
  std::mt19937 random(11);
  int refused = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::string lying = payload;
    // Lengths stand near the front; all bits are tried there, some everywhere.
    const std::size_t at =
        trial < 200 ? static_cast<std::size_t>(trial) % 100 : random() % payload.size();
    lying[at] = static_cast<char>(random());
    if (trial % 3 == 0) lying.resize(random() % lying.size());
    refused += complaint([&] { decode_saved_map(seal("MARCOMAP", 13, lying)); }).empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 150);
  SlamState state = slam.state();
  state.back_end.edges.front().to = 1000;
  EXPECT_THAT(complaint([&] {
                decode_saved_map(encode_saved_map({"", {0}, state}));
              }),
              HasSubstr("ends at no keyframe"));
}

TEST_F(SavedMapTest, ASecondSessionFindsItselfAndGoesOnInTheFirstOnesFrame) {
  MappingSession session({}, {});
  for (const SlamInput& input : drive(path_, 3, 0)) session.process(input);
  session.finish();
  const SavedMap first = session.saved("");
  // From elsewhere, heading elsewhere.
  const std::vector<Pose2> path = round_the_box({10.0, -3.0, 1.5707963}, 60);
  session.extend(first);
  for (const SlamInput& input : drive(path, 4, 1'000'000'000)) session.process(input);
  ASSERT_TRUE(session.joined());
  session.finish();
  const auto poses = session.trajectory();
  ASSERT_EQ(poses.size(), path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    // Noise of 1 cm over hundreds of beams, and the first map's own error.
    EXPECT_THAT(*poses[i], IsNear(between(path_.front(), path[i]), 0.03, 0.01)) << i;
  }
  EXPECT_EQ(session.saved("").session_starts, (std::vector<int64_t>{0, 130}));
  EXPECT_EQ(session.slam().trajectory().size(), 190U);
}

TEST_F(SavedMapTest, SeparateMapsOfOneBuildingBecomeOneAndAForeignOneIsLeftOut) {
  const auto map_of = [&](const std::vector<Pose2>& path, uint32_t seed) {
    MappingSession session({}, {});
    for (const SlamInput& input : drive(path, seed, 1'000'000'000 * int64_t{seed})) {
      session.process(input);
    }
    session.finish();
    return session.saved("");
  };
  const SavedMap first = map_of(path_, 3);
  const std::vector<Pose2> path = round_the_box({10.0, -3.0, 1.5707963}, 60);
  const SavedMap second = map_of(path, 4);
  world_ = testing::FlatWorld();
  world_.add_box(-9, -1.1, 9, 1.3);
  const SavedMap foreign = map_of(round_the_box({-5, 0, 0}, 25), 5);
  std::vector<std::size_t> not_found;
  const SavedMap merged = merge_maps({first, foreign, second}, {}, {}, not_found);
  EXPECT_EQ(not_found, (std::vector<std::size_t>{1}));
  Slam slam;
  slam.restore(merged.slam);
  const Trajectory poses = slam.trajectory();
  ASSERT_EQ(poses.size(), path_.size() + path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_THAT(poses[path_.size() + i].world_from_robot,
                IsNear(between(path_.front(), path[i]), 0.03, 0.01));
  }
}

TEST_F(SavedMapTest, InABuildingOfTwoEqualWingsItStaysWithCandidates) {
  const testing::FlatWorld wing = world_;
  for (const testing::FlatWorld::Wall& wall : wing.walls) {
    world_.walls.push_back({wall.from + Eigen::Vector2d(0, 30), wall.to + Eigen::Vector2d(0, 30)});
  }
  Slam mapper;
  for (const SlamInput& input : drive(path_, 3, 0)) mapper.process(input);
  mapper.finish();
  std::vector<Keyframe> both = mapper.keys();
  for (Keyframe key : mapper.keys()) {
    key.world_from_robot.y_m += 30.0;
    both.push_back(key);
  }
  Localizer localizer(both);
  for (const SlamInput& input : drive(round_the_box({10.0, -3.0, 1.5707963}, 50), 4, 0)) {
    localizer.process(input);
  }
  EXPECT_FALSE(localizer.is_localized());
  EXPECT_EQ(localizer.estimate().status, PlaceEstimate::Status::candidates);
  EXPECT_GE(localizer.estimate().candidates.size(), 2U);
}

TEST_F(SavedMapTest, CarriedAwayItLooksAnewAndFindsItselfAgain) {
  Slam mapper;
  for (const SlamInput& input : drive(path_, 3, 0)) mapper.process(input);
  mapper.finish();
  Localizer localizer(mapper.keys());
  for (const SlamInput& input : drive({path_.begin(), path_.begin() + 40}, 4, 0)) {
    localizer.process(input);
  }
  ASSERT_TRUE(localizer.is_localized());
  const std::vector<Pose2> elsewhere = round_the_box({10.0, -3.0, 1.5707963}, 110);
  SlamUpdate last;
  for (const SlamInput& input : drive(elsewhere, 5, 20'000'000)) last = localizer.process(input);
  EXPECT_TRUE(localizer.is_localized());
  EXPECT_THAT(last.world_from_robot, IsNear(between(path_.front(), elsewhere.back()), 0.03, 0.01));
}

}  // namespace
}  // namespace marco::slam
