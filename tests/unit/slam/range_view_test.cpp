#include "slam/map/range_view.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "slam/map/place_view.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

Keyframe in_small_room(const Pose2& place) {
  Keyframe key;
  key.points_in_robot = orient(testing::small_room().hits(place), Eigen::Vector2d::Zero(), {});
  return key;
}

// From (0, -2) the laser looks along +x and to both sides: the walls at x = 4 and y = +-3, the box
// between (1.5, -1.6) and (2.3, -1.0).
TEST(RangeView, TellsWallsFreeSpaceAndWhatIsBehind) {
  const Keyframe key = in_small_room({0, -2, 0});
  const RangeView view(key);
  const auto at = [&view](double x, double y) { return view.look_at({x, y + 2.0}); };
  EXPECT_EQ(at(4.0, -2.0), Seen::as_wall);
  EXPECT_EQ(at(4.1, -2.0), Seen::as_wall);
  EXPECT_EQ(at(1.5, -1.5), Seen::as_wall);
  EXPECT_EQ(at(2.0, -2.0), Seen::as_free);
  EXPECT_EQ(at(3.5, -2.0), Seen::as_free);
  EXPECT_EQ(at(1.0, 1.0), Seen::as_free);
  // Too near to the wall to say, behind it, behind the box, and behind the robot's back.
  EXPECT_EQ(at(3.8, -2.0), Seen::nothing);
  EXPECT_EQ(at(4.5, -2.0), Seen::nothing);
  EXPECT_EQ(at(3.0, -0.9), Seen::nothing);
  EXPECT_EQ(at(-1.0, -2.0), Seen::nothing);
}

// The wall y = -3 is hit at angles down to 12 degrees, each beam far behind the last one: a wall
// that is off by 0.2 m lies metres before what the beam hit, and contradicts nothing.
TEST(RangeView, AWallSeenAtAFlatAngleIsNoContradiction) {
  const Keyframe key = in_small_room({-3.5, -2.2, 0});
  const RangeView view(key);
  for (const double x : {1.0, 3.0, 5.0}) {
    EXPECT_NE(view.look_at({x, -0.6}), Seen::as_free) << x;
  }
}

TEST(RangeView, WithoutPointsNothingIsKnown) {
  Keyframe key;
  key.points_in_robot = {Points2(2, 0), Points2(2, 0)};
  EXPECT_EQ(RangeView(key).look_at({1, 0}), Seen::nothing);
}

// Two keyframes of a closed corridor that look opposite ways.
TEST(PlaceView, JoinsWhatItsKeyframesSaw) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-10, -1.5}, {10, -1.5}, {10, 1.5}, {-10, 1.5}, {-10, -1.5}});
  std::vector<Keyframe> keys(2);
  for (std::size_t i = 0; i < 2; ++i) {
    keys[i].world_from_robot = {2.0, 0.5, i == 0 ? 0.0 : std::numbers::pi};
    keys[i].points_in_robot = orient(corridor.hits(keys[i].world_from_robot), {0, 0}, {});
  }
  const std::vector<Keyframe> first{keys[0]};
  const PlaceView ahead(first);
  EXPECT_EQ(ahead.look_at({10.0, 0.0}), Seen::as_wall);
  EXPECT_EQ(ahead.look_at({6.0, 0.0}), Seen::as_free);
  EXPECT_EQ(ahead.look_at({-10.0, 0.0}), Seen::nothing) << "behind it";
  const PlaceView both(keys);
  EXPECT_EQ(both.look_at({10.0, 0.0}), Seen::as_wall);
  EXPECT_EQ(both.look_at({-10.0, 0.0}), Seen::as_wall);
  EXPECT_EQ(both.look_at({-6.0, 0.0}), Seen::as_free);
  EXPECT_EQ(both.look_at({14.0, 0.0}), Seen::nothing) << "behind the wall";

  Points2 points(2, 3);
  points << 4.0, -4.0, 12.0, 0.0, 0.0, 0.0;
  const Pose2 from{2.0, 0.0, 0.0};
  EXPECT_EQ(ahead.sees(points, from), (std::vector<bool>{true, false, false}));
  EXPECT_EQ(both.sees(points, from), (std::vector<bool>{true, true, false}));
}

}  // namespace
}  // namespace marco::slam
