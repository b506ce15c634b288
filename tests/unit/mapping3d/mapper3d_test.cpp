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

TEST(Mapper3d, AFinishedModelNeedsNoRangesAndTakesNoMoreRows) {
  Mapper3dOptions options;
  options.surface.voxel_m = 0.05;
  Mapper3d mapper(options);
  add_sweep(mapper, kHere, {});
  add_sweep(mapper, kThere, {});
  mapper.refine();
  const TriangleMesh before = mapper.model();
  const std::size_t rows = mapper.scenes()[1].rows.size();
  mapper.finish_model();
  mapper.finish_model();
  EXPECT_EQ(mapper.model().vertices_m, before.vertices_m);
  ASSERT_EQ(mapper.scenes().size(), 2U);
  ASSERT_EQ(mapper.scenes()[1].rows.size(), rows);
  EXPECT_EQ(mapper.scenes()[1].rows[0].ranges_m.capacity(), 0U);
  EXPECT_THROW(mapper.placed(), std::logic_error);
  EXPECT_THROW(mapper.scene_meshes(), std::logic_error);
  EXPECT_THROW(mapper.follow(PathCorrection({}, {})), std::logic_error);
  EXPECT_EQ(mapper.model().triangles, before.triangles);
}

// SLAM knows a stop's place best at its end.
TEST(Mapper3d, RowsOfOneStopLieWhereItsLastRowDoes) {
  Mapper3d mapper;
  std::mt19937 random(4);
  const Scene sweep = AnalyticRoom::sweep(kHere, 60, 0.005, random);
  const auto add = [&](int from, int to, int64_t stop, double x_m) {
    for (int i = from; i < to; ++i) {
      SceneRow row = sweep.rows[static_cast<std::size_t>(i)];
      row.utime = Utime::from_us(i);
      row.stop = Utime::from_us(stop);
      row.world_from_robot.x_m = x_m;
      mapper.add(row, 0.0, deg_to_rad(static_cast<double>(i)));
    }
  };
  const auto x_of = [&](std::size_t scene) {
    std::vector<double> x_m;
    for (const SceneRow& row : mapper.scenes()[scene].rows) {
      x_m.push_back(row.world_from_robot.x_m);
    }
    return x_m;
  };
  add(0, 20, 0, 0.0);
  add(20, 30, 20, 1.0);
  add(30, 40, 20, 1.01);
  ASSERT_TRUE(mapper.finish());
  std::vector<double> expected(20, 0.0);
  expected.resize(40, 1.01);
  EXPECT_EQ(x_of(0), expected);
  // Another sweep of this stop, and a keyframe in its middle that moves.
  add(20, 40, 20, 1.02);
  ASSERT_TRUE(mapper.finish());
  std::fill(expected.begin() + 20, expected.end(), 1.02);
  EXPECT_EQ(x_of(0), expected);
  const std::map<Utime, Pose2> known{{Utime::from_us(35), {1.01, 0, 0}}};
  mapper.follow(PathCorrection({{Utime::from_us(35), {1.51, 0, 0}}}, known));
  std::fill(expected.begin() + 20, expected.end(), 1.52);
  ASSERT_EQ(x_of(0).size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(x_of(0)[i], expected[i], 1e-12) << i;
  }
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
