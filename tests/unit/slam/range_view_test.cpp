#include "slam/map/range_view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
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

// A laser that looks all around, at what stands at these ranges: a beam each `step_deg`, from
// `begin` steps past its right side on.
Keyframe all_around(double step_deg,
                    const std::function<double(double bearing_deg)>& range_m,
                    double begin = 0.5) {
  const auto beams = static_cast<Eigen::Index>(std::lround(360.0 / step_deg));
  Points2 hits(2, beams);
  for (Eigen::Index beam = 0; beam < beams; ++beam) {
    const double bearing_rad =
        normalize_angle(deg_to_rad(-90.0 + (static_cast<double>(beam) + begin) * step_deg));
    hits.col(beam) = range_m(rad_to_deg(bearing_rad)) *
                     Eigen::Vector2d(std::cos(bearing_rad), std::sin(bearing_rad));
  }
  Keyframe key;
  key.points_in_robot = orient(hits, Eigen::Vector2d::Zero(), {});
  return key;
}

Keyframe reversed(Keyframe key) {
  key.points_in_robot.points = key.points_in_robot.points.rowwise().reverse().eval();
  key.points_in_robot.normals = key.points_in_robot.normals.rowwise().reverse().eval();
  return key;
}

Eigen::Vector2d ahead(double bearing_deg, double range_m) {
  return Pose2{0, 0, deg_to_rad(bearing_deg)} * Eigen::Vector2d(range_m, 0.0);
}

TEST(RangeView, BetweenNeighbouringBeamsItIsFreeAsFarAsTheNearerReachesAllAroundTheCircle) {
  const auto range_m = [](double bearing_deg) { return bearing_deg > 0.0 ? 6.0 : 4.0; };
  std::vector<Keyframe> keys;
  for (const double begin : {0.1, 0.5, 0.9}) {
    keys.push_back(all_around(2.0, range_m, begin));
    keys.push_back(reversed(keys.back()));
  }
  for (const Keyframe& key : keys) {
    const RangeView view(key);
    for (double bearing_deg = -180.0; bearing_deg < 180.0; bearing_deg += 0.45) {
      if (std::abs(bearing_deg + 90.0) < 2.5) continue;  // where the scan begins and ends
      EXPECT_EQ(view.look_at(ahead(bearing_deg, 3.5)), Seen::as_free) << bearing_deg;
      // Of both sides' ranges, the nearer holds until the next beam.
      if (bearing_deg > 2.5 && bearing_deg < 177.5) {
        EXPECT_EQ(view.look_at(ahead(bearing_deg, 5.5)), Seen::as_free) << bearing_deg;
      }
      if (bearing_deg < -2.5 && bearing_deg > -177.5) {
        EXPECT_EQ(view.look_at(ahead(bearing_deg, 4.0)), Seen::as_wall) << bearing_deg;
        EXPECT_EQ(view.look_at(ahead(bearing_deg, 5.5)), Seen::nothing) << bearing_deg;
      }
    }
    EXPECT_NE(view.look_at(ahead(0.0, 5.5)), Seen::as_free);
    EXPECT_NE(view.look_at(ahead(180.0, 5.5)), Seen::as_free);
  }
}

// Nor before the walls that they hit: a heading's error may be as large as what a beam shows.
TEST(RangeView, OfBeamsFarApartOnlyTheWallsAreKnown) {
  const Keyframe key = all_around(6.0, [](double) { return 5.0; });
  const RangeView view(key);
  EXPECT_EQ(view.look_at(ahead(3.0, 5.0)), Seen::as_wall);
  for (const double bearing_deg : {0.0, 3.0, 180.0}) {
    EXPECT_EQ(view.look_at(ahead(bearing_deg, 4.0)), Seen::nothing) << bearing_deg;
  }
}

// A post 1 m away of one beam: what is beside it by a degree may be behind it, seen from elsewhere.
TEST(RangeView, BesideAPostNothingIsKnownOfWhatIsBehindIt) {
  const Keyframe key = all_around(
      0.5, [](double bearing_deg) { return std::abs(bearing_deg - 30.25) < 0.1 ? 1.0 : 5.0; });
  const RangeView view(key);
  for (const double bearing_deg : {29.3, 30.25, 31.2}) {
    EXPECT_EQ(view.look_at(ahead(bearing_deg, 3.0)), Seen::nothing) << bearing_deg;
  }
  for (const double bearing_deg : {28.5, 32.0}) {
    EXPECT_EQ(view.look_at(ahead(bearing_deg, 3.0)), Seen::as_free) << bearing_deg;
  }
  EXPECT_EQ(view.look_at(ahead(29.3, 1.2)), Seen::nothing);
  EXPECT_EQ(view.look_at(ahead(29.3, 0.8)), Seen::nothing);
  EXPECT_EQ(view.look_at(ahead(29.3, 0.6)), Seen::as_free);
  // Without a side that could be told, it is a wall as far as it was hit.
  EXPECT_EQ(view.look_at(ahead(30.25, 1.1)), Seen::as_wall);
  EXPECT_EQ(view.look_at(ahead(30.25, 1.2)), Seen::nothing);
}

// A second laser, or a scan of more than a turn: its hits come before or after the wall's.
TEST(RangeView, OfTwoHitsAtOneBearingTheNearerEndsTheFreeSpace) {
  const Keyframe wall = all_around(0.5, [](double) { return 5.0; });
  for (const Eigen::Index at : {Eigen::Index{0}, wall.points_in_robot.points.cols()}) {
    Keyframe key = wall;
    key.points_in_robot.points.resize(2, wall.points_in_robot.points.cols() + 1);
    key.points_in_robot.normals.setZero(2, key.points_in_robot.points.cols());
    key.points_in_robot.points << wall.points_in_robot.points.leftCols(at), ahead(40.3, 2.0),
        wall.points_in_robot.points.rightCols(wall.points_in_robot.points.cols() - at);
    const RangeView view(key);
    EXPECT_EQ(view.look_at(ahead(40.25, 1.5)), Seen::as_free) << at;
    EXPECT_EQ(view.look_at(ahead(40.25, 2.0)), Seen::as_wall) << at;
    EXPECT_EQ(view.look_at(ahead(40.25, 4.0)), Seen::nothing) << at;
  }
}

// Headings err: the farther, the more.
TEST(RangeView, TheFartherAWallTheEarlierItIsInDoubt) {
  const auto seen_before = [](double range_m, double margin_m) {
    const Keyframe key = all_around(0.5, [range_m](double) { return range_m; });
    return RangeView(key).look_at(ahead(40.25, range_m - margin_m));
  };
  EXPECT_EQ(seen_before(5.0, 0.45), Seen::as_free);
  EXPECT_EQ(seen_before(25.0, 0.45), Seen::nothing);
  EXPECT_EQ(seen_before(25.0, 0.65), Seen::as_free);
}

// The last beam along a wall hits it 5 m away; what its line says of 1.2 m more is no wall.
TEST(RangeView, AWallGoesOnForLessThanAMetreBeyondWhatWasHit) {
  Keyframe key;
  key.points_in_robot = {Points2(2, 1), Points2(2, 1)};
  key.points_in_robot.points << 5.0, 0.5;
  key.points_in_robot.normals << 0.0, -1.0;
  const RangeView view(key);
  EXPECT_EQ(view.look_at({5.8, 0.58}), Seen::as_wall);
  EXPECT_EQ(view.look_at({6.2, 0.62}), Seen::nothing);
}

TEST(RangeView, ItsBeamsComeFromTheSensorAndNotFromTheRobot) {
  Keyframe key = in_small_room({0, -2, 0});
  key.points_in_robot.points.colwise() += Eigen::Vector2d(-1.0, 0.5);
  key.sensor_in_robot = {-1.0, 0.5};
  const RangeView view(key);
  EXPECT_EQ(view.look_at({3.0, 0.5}), Seen::as_wall);
  EXPECT_EQ(view.look_at({1.0, 0.5}), Seen::as_free);
  EXPECT_EQ(view.look_at({-2.0, 0.5}), Seen::nothing);
  EXPECT_EQ(view.look_at({2.0, 1.6}), Seen::nothing) << "behind the box";
}

}  // namespace
}  // namespace marco::slam
