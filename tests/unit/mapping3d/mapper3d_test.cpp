#include "mapping3d/mapper3d.hpp"

#include <gtest/gtest.h>

#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

const Pose3 kHere = make_pose3({-1.0, 0.2, 0.8});
const Pose3 kThere = make_pose3({-0.6, -0.5, 0.8}, 0.0, 0.0, 0.3);

void add_sweep(Mapper3d& mapper, const Pose3& sensor, const Pose2& path_error) {
  std::mt19937 random(4);
  Scene sweep = AnalyticRoom::sweep(sensor, 60, 0.005, random);
  for (std::size_t i = 0; i < sweep.rows.size(); ++i) {
    sweep.rows[i].world_from_robot = path_error;
    mapper.add(sweep.rows[i], 0.0, deg_to_rad(static_cast<double>(i)));
  }
  ASSERT_TRUE(mapper.finish());
}

TEST(Mapper3d, JoinsItsScenesAndLeavesThemAsAWholeOnThePath) {
  Mapper3d mapper;
  add_sweep(mapper, kHere, {});
  const Pose2 path_error{0.06, -0.04, 0.0};
  add_sweep(mapper, kThere, path_error);
  mapper.refine();
  const RegistrationResult& joined = mapper.registration();
  ASSERT_EQ(joined.world_from_placed.size(), 2U);
  const Pose3 first = joined.world_from_placed[0];
  const Pose3 second = joined.world_from_placed[1] * lift(path_error);
  EXPECT_LT(AnalyticRoom::worst_shift_m(first.inverse() * second), 0.003);
  // Each goes half the way: the path knows no better of the one than of the other.
  EXPECT_NEAR(first.translation().x(), 0.03, 0.01);
  EXPECT_NEAR(first.translation().y(), -0.02, 0.01);
  // The model is made of the scenes as joined.
  const Eigen::Vector3d by_path = place(mapper.scenes()[0]).points_m[100].cast<double>();
  EXPECT_NEAR((mapper.placed()[0].points_m[100].cast<double>() - first * by_path).norm(), 0.0,
              1e-5);
}

TEST(Mapper3d, TheModelFollowsTheScenesAlsoWithoutRegistration) {
  Mapper3dOptions options;
  options.refine = false;
  Mapper3d mapper(options);
  EXPECT_TRUE(mapper.model().triangles.empty());
  add_sweep(mapper, kHere, {});
  const TriangleMesh one = mapper.model();
  add_sweep(mapper, kThere, {});
  mapper.refine();
  EXPECT_FALSE(one.triangles.empty());
  EXPECT_NE(mapper.model().vertices_m, one.vertices_m);
  EXPECT_EQ(mapper.model().vertices_m, fuse(mapper.placed()).vertices_m);
}

// The path was right: what registration finds is the noise of one sweep against another.
TEST(Mapper3d, MovesAlmostNothingWhereThePathIsRight) {
  Mapper3d mapper;
  add_sweep(mapper, kHere, {});
  const Pose2 elsewhere{0.4, -0.7, 0.3};
  std::mt19937 random(5);
  const Scene second = AnalyticRoom::sweep(kThere, 60, 0.005, random);
  for (std::size_t i = 0; i < second.rows.size(); ++i) {
    SceneRow row = second.rows[i];
    row.world_from_robot = elsewhere;
    row.robot_from_sensor_first = lift(elsewhere).inverse() * row.robot_from_sensor_first;
    row.robot_from_sensor_last = row.robot_from_sensor_first;
    mapper.add(row, 0.0, deg_to_rad(static_cast<double>(i)));
  }
  ASSERT_TRUE(mapper.finish());
  mapper.refine();
  ASSERT_EQ(mapper.registration().overlaps, 1U);
  for (const Pose3& moved_by : mapper.registration().world_from_placed) {
    EXPECT_LT(AnalyticRoom::worst_shift_m(moved_by), 0.001);
  }
}

}  // namespace
}  // namespace marco::mapping3d
