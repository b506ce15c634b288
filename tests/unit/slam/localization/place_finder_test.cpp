#include "slam/localization/place_finder.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;
using ::testing::SizeIs;

std::vector<Keyframe> keyframes_along(const testing::FlatWorld& world,
                                      const std::vector<Pose2>& world_from_robots,
                                      const Pose2& frame_from_world) {
  std::mt19937 random(5);
  std::vector<Keyframe> keys;
  for (const Pose2& pose : world_from_robots) {
    Keyframe& key = keys.emplace_back();
    key.points_in_robot = orient(world.hits(pose, 0.01, &random), {0, 0}, {});
    key.world_from_robot = frame_from_world * pose;
    if (keys.size() < 2) continue;
    const Keyframe& before = keys[keys.size() - 2];
    key.path_m = before.path_m +
                 between(before.world_from_robot, key.world_from_robot).translation_m().norm();
  }
  return keys;
}

// Twice round the middle of a room 8 x 6 m.
std::vector<Pose2> tour() {
  std::vector<Pose2> poses;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 12.0;
    poses.push_back({1.0 * std::cos(angle), 0.6 * std::sin(angle), normalize_angle(angle + 1.2)});
  }
  return poses;
}

// Straight on, 0.4 m from keyframe to keyframe.
std::vector<Pose2> drive(const Pose2& from, int count) {
  std::vector<Pose2> poses{from};
  while (std::ssize(poses) < count) poses.push_back(poses.back() * Pose2{0.4, 0.0, 0.02});
  return poses;
}

class PlaceFinderTest : public ::testing::Test {
 protected:
  static PlaceMap map_of(const testing::FlatWorld& world) {
    return {keyframes_along(world, tour(), {}), {}};
  }
  // One look a keyframe.
  static std::vector<PlaceEstimate> looks(PlaceFinder& finder, const std::vector<Keyframe>& keys) {
    std::vector<PlaceEstimate> estimates;
    for (std::size_t count = 1; count <= keys.size(); ++count) {
      estimates.push_back(
          finder.look({keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(count)}));
    }
    return estimates;
  }

  testing::FlatWorld room_ = testing::small_room();
  Pose2 session_from_world_{30.0, -7.0, 2.5};
  std::vector<Pose2> path_ = drive({-1.5, -1.0, 0.4}, 6);
};

TEST_F(PlaceFinderTest, GivesTheMapsFrameSeenFromTheSessionsOwn) {
  const PlaceMap map = map_of(room_);
  PlaceFinder finder(map, {});
  const auto estimates = looks(finder, keyframes_along(room_, path_, session_from_world_));
  ASSERT_EQ(estimates.back().status, PlaceEstimate::Status::localized);
  const PlaceCandidate& best = estimates.back().candidates.front();
  EXPECT_THAT(best.map_from_session, IsNear(session_from_world_.inverse(), 0.04, 0.01));
  EXPECT_GT(best.explained, 0.9);
  EXPECT_LT(best.contradicted(), 0.03);
}

TEST_F(PlaceFinderTest, IsSureAfterThreeLooksAndAMetreAndNotBefore) {
  const PlaceMap map = map_of(room_);
  PlaceFinder finder(map, {});
  const std::vector<Keyframe> keys = keyframes_along(room_, path_, session_from_world_);
  const auto estimates = looks(finder, keys);
  // The fourth keyframe is the first one after a metre.
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(estimates[i].status, PlaceEstimate::Status::candidates) << i;
  }
  EXPECT_EQ(estimates[3].status, PlaceEstimate::Status::localized);
  EXPECT_TRUE(finder.has_leader());
  finder.restart();
  EXPECT_FALSE(finder.has_leader());
  for (int look = 1; look <= 3; ++look) {
    EXPECT_EQ(finder.look(keys).status == PlaceEstimate::Status::localized, look == 3) << look;
  }
}

TEST_F(PlaceFinderTest, InASymmetricRoomBothPlacesStayCandidates) {
  testing::FlatWorld room;
  room.add_box(-4, -3, 4, 3);
  const PlaceMap map = map_of(room);
  PlaceFinder finder(map, {});
  const auto last = looks(finder, keyframes_along(room, path_, session_from_world_)).back();
  EXPECT_EQ(last.status, PlaceEstimate::Status::candidates);
  EXPECT_FALSE(finder.has_leader());
  ASSERT_THAT(last.candidates, SizeIs(2));
  const Pose2 half_turn{0, 0, std::numbers::pi};
  for (const Pose2& map_from_world : {Pose2{}, half_turn}) {
    const Pose2 wanted = map_from_world * session_from_world_.inverse();
    EXPECT_TRUE(std::any_of(last.candidates.begin(), last.candidates.end(), [&](const auto& found) {
      return between(found.map_from_session * session_from_world_, wanted * session_from_world_)
                 .translation_m()
                 .norm() < 0.1;
    })) << map_from_world.theta_rad;
  }
}

// With as many candidates as are kept, the right one may be among those cut off. A cupboard tells
// the two ends of this room apart: the better of the two candidates stands out.
TEST_F(PlaceFinderTest, WithAsManyCandidatesAsAreKeptNoneIsBelieved) {
  testing::FlatWorld room;
  room.add_box(-4, -3, 4, 3);
  room.add_box(2.4, 1.6, 3.2, 2.4);
  const PlaceMap map = map_of(room);
  const std::vector<Keyframe> keys = keyframes_along(room, path_, session_from_world_);
  PlaceFinder finder(map, {});
  const PlaceEstimate believed = looks(finder, keys).back();
  ASSERT_THAT(believed.candidates, SizeIs(2));
  EXPECT_EQ(believed.status, PlaceEstimate::Status::localized);
  PlaceFinderOptions options;
  options.max_candidates = 2;
  PlaceFinder full(map, options);
  const PlaceEstimate doubted = looks(full, keys).back();
  ASSERT_THAT(doubted.candidates, SizeIs(2));
  EXPECT_EQ(doubted.status, PlaceEstimate::Status::candidates);
}

TEST_F(PlaceFinderTest, ARoomThatIsNotInTheMapIsNotFoundInIt) {
  testing::FlatWorld hall;
  hall.add_box(-9, -2, 5, 1.5);
  hall.add_box(-6, -0.5, -5, 0.5);
  const PlaceMap map = map_of(room_);
  PlaceFinder finder(map, {});
  for (const PlaceEstimate& estimate :
       looks(finder, keyframes_along(hall, path_, session_from_world_))) {
    EXPECT_NE(estimate.status, PlaceEstimate::Status::localized);
  }
}

TEST_F(PlaceFinderTest, ASessionWithoutAKeyframeIsRefused) {
  const PlaceMap map = map_of(room_);
  PlaceFinder finder(map, {});
  EXPECT_THROW(finder.look({}), std::invalid_argument);
  EXPECT_EQ(finder.look({Keyframe{}}).status, PlaceEstimate::Status::not_yet);
}

}  // namespace
}  // namespace marco::slam
