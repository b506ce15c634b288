#include "slam/map/keyframe.hpp"

#include <gmock/gmock.h>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::testing::HasSubstr;

// Two points of one wall, seen from `place`.
Keyframe key_at(const Pose2& place, double sensor_heading_rad = 0.0) {
  Keyframe key;
  key.world_from_robot = place;
  key.sensor_heading_rad = sensor_heading_rad;
  key.points_in_robot = {Points2(2, 2), Points2(2, 2)};
  key.points_in_robot.points << 1.0, 1.0, 0.0, 0.5;
  key.points_in_robot.normals << -1.0, -1.0, 0.0, 0.0;
  return key;
}

class KeyframeIsDue : public ::testing::Test {
 protected:
  bool is_due(const Pose2& here, double sensor_heading_rad = 0.0) const {
    return set_.is_due(here, sensor_heading_rad, options_);
  }
  KeyframeSet set_;
  KeyframeOptions options_{0.3, 15.0};
};

TEST_F(KeyframeIsDue, AfterAMoveOrATurnToEitherSide) {
  EXPECT_TRUE(is_due({})) << "the first";
  set_.keys = {key_at({})};
  EXPECT_FALSE(is_due({0.2, 0.2, 0.2}));
  EXPECT_TRUE(is_due({0.25, 0.25, 0.0}));
  EXPECT_TRUE(is_due({0.0, 0.0, deg_to_rad(16.0)}));
  EXPECT_TRUE(is_due({0.0, 0.0, deg_to_rad(-16.0)}));
}

TEST_F(KeyframeIsDue, ForEachWayThatALaserLooksFromOnePlace) {
  set_.keys = {key_at({}, 0.0), key_at({}, deg_to_rad(170.0))};
  EXPECT_FALSE(is_due({}, 0.1));
  EXPECT_FALSE(is_due({}, deg_to_rad(-178.0))) << "12 degrees past the second, over the back";
  EXPECT_TRUE(is_due({}, deg_to_rad(90.0)));
  // The keyframes of another place do not count, whichever way they look.
  set_.keys = {key_at({5, 0, 0}, 0.0), key_at({}, deg_to_rad(170.0))};
  EXPECT_TRUE(is_due({}, 0.0));
}

TEST(Keyframes, AreJoinedInAnyFrameWithTheNoiseOfTheWorst) {
  std::vector<Keyframe> keys{key_at({9, 9, 0}), key_at({2, 0, deg_to_rad(90)}), key_at({3, 0, 0}),
                             key_at({9, 9, 0})};
  keys[1].points_in_robot.range_sigma_m = 0.03;
  keys[2].points_in_robot.range_sigma_m = 0.01;
  keys[3].points_in_robot.range_sigma_m = 0.5;
  const OrientedPoints joined = join_points(keys, 1, 2, Pose2{1, 0, 0}.inverse());
  Points2 points(2, 4), normals(2, 4);
  points << 1.0, 0.5, 3.0, 3.0, 1.0, 1.0, 0.0, 0.5;
  normals << 0.0, 0.0, -1.0, -1.0, -1.0, -1.0, 0.0, 0.0;
  ASSERT_EQ(joined.points.cols(), 4);
  EXPECT_LT((joined.points - points).norm(), 1e-9);
  EXPECT_LT((joined.normals - normals).norm(), 1e-9);
  EXPECT_EQ(joined.range_sigma_m, 0.03);
}

TEST(Keyframes, TheirTrajectoryIsThatOfTheirScans) {
  std::vector<Keyframe> keys{key_at({}), key_at({2, 1, 0.5})};
  keys[1].utime = Utime::from_us(77);
  const Trajectory trajectory = trajectory_of(keys);
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory[1].utime.us, 77);
  EXPECT_THAT(trajectory[1].world_from_robot, IsNear(Pose2{2, 1, 0.5}, 0.0, 0.0));
}

TEST(Keyframes, ImpossibleOnesAreRefusedAndSaidSo) {
  const auto said = [](const auto& spoil) {
    KeyframeSet set{{key_at({}), key_at({-1e6, 1e6, 0})}, 0};  // 1000 km, and just that
    set.keys[1].sensor_in_robot = {1e6, -1e6};
    set.keys[1].points_in_robot.points(1, 0) = -1e6;
    set.keys[1].path_m = 1e9;
    spoil(set);
    return complaint([&] { check(set); });
  };
  EXPECT_EQ(said([](KeyframeSet&) {}), "");
  EXPECT_EQ(said([](KeyframeSet& set) {
              set.keys[0].points_in_robot = {Points2(2, 0), Points2(2, 0)};
            }),
            "")
      << "a scan without returns";
  EXPECT_THAT(
      said([](KeyframeSet& set) { set.keys[1].points_in_robot.normals.conservativeResize(2, 1); }),
      HasSubstr("one normal per point"));
  for (const double far_m : {1e7, -1e7}) {
    const auto far = HasSubstr("farther away");
    EXPECT_THAT(said([=](KeyframeSet& set) { set.keys[1].world_from_robot.x_m = far_m; }), far);
    EXPECT_THAT(said([=](KeyframeSet& set) { set.keys[1].world_from_robot.y_m = far_m; }), far);
    EXPECT_THAT(said([=](KeyframeSet& set) { set.keys[1].sensor_in_robot = {0, far_m}; }), far);
    EXPECT_THAT(said([=](KeyframeSet& set) { set.keys[1].path_m = 1e3 * far_m; }), far);
  }
  EXPECT_THAT(said([](KeyframeSet& set) { set.merged = -1; }), HasSubstr("impossible"));
  EXPECT_FALSE(is_index(-1, 2));
  EXPECT_TRUE(is_index(0, 2));
  EXPECT_TRUE(is_index(1, 2));
  EXPECT_FALSE(is_index(2, 2));
}

}  // namespace
}  // namespace marco::slam
