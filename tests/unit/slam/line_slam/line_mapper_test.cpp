#include "slam/line_slam/line_mapper.hpp"

#include <gtest/gtest.h>

#include "slam/process/line_checkpoint.hpp"
#include "tests/support/lines_drive.hpp"
#include "tests/support/lines_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using testing::IsNear;
using testing::LinesDrive;
using testing::LinesWorld;

// A square ring of corridors with no doors, 2 m wide: 64 m round, ends of walls at the corners
// only.
LinesWorld make_ring() {
  LinesWorld world;
  world.add_polygon({{0, 0}, {18, 0}, {18, 18}, {0, 18}});
  world.add_box(2.0, 2.0, 16.0, 16.0);
  world.add_box(7.0, 0.0, 7.6, 0.5);  // what makes one corridor unlike the others
  world.add_box(17.4, 11.0, 18.0, 11.8);
  return world;
}

const std::vector<Eigen::Vector2d> kRound = {{3.0, 1.0},  {17.0, 1.0}, {17.0, 17.0},
                                             {1.0, 17.0}, {1.0, 1.0},  {6.0, 1.0}};

SlamInput input_of(const ScanInRobot& scan, std::size_t i, const Pose2& odom_from_robot) {
  SlamInput input;
  input.scan.utime = input.motion.utime = Utime::from_us(static_cast<int64_t>(i) * 100000);
  input.scan.hits_in_robot = hits_of(scan);
  input.scan.sensor_in_robot = scan.sensor_m;
  input.motion.odom_from_robot = odom_from_robot;
  return input;
}

struct Ride {
  Pose2 estimate, truth;
  int replays = 0;
  std::size_t loops = 0;
  Trajectory trajectory;
};

// What happens at the checkpoints on the way.
enum class Life { no_checkpoints, saved, killed };

// On the third side the wheels slip by a tenth, and the filter believes them to a hundredth.
Ride ride(bool close_loops, Life life = Life::no_checkpoints) {
  const LinesWorld world = make_ring();
  testing::LinesLaser laser;
  laser.max_range_m = 5.0;  // of a corridor it mostly sees the sides alone
  std::mt19937 random(31);
  const LinesDrive tour = testing::drive(kRound, 0.15, 0.2, {}, random);
  LineMapperOptions options;
  options.close_loops = close_loops;
  options.lines.filter.motion.distance_sigma_part = 0.01;
  options.lines.filter.motion.floor_m = 0.002;
  LineMapper mapper(options, tour.world_from_robot[0]);
  Pose2 odom_from_robot;
  for (std::size_t i = 0; i < tour.world_from_robot.size(); ++i) {
    Pose2 motion = i == 0 ? Pose2{} : tour.odometry_steps[i - 1];
    if (std::abs(tour.world_from_robot[i].theta_rad) > 3.0) motion.x_m *= 1.10;
    odom_from_robot = odom_from_robot * motion;
    const auto taken = testing::take_scan(world, laser, tour.world_from_robot[i], random);
    mapper.process(input_of(taken.scan, i, odom_from_robot), taken.scan);
    if (life == Life::no_checkpoints || i % 130 != 129) continue;
    LineCheckpoint checkpoint;
    checkpoint.mapper = mapper.store();
    if (life == Life::saved) continue;
    const std::vector<uint8_t> bytes = encode_checkpoint(checkpoint);
    mapper = LineMapper(options);
    mapper.restore(decode_checkpoint(bytes).mapper);
  }
  mapper.finish();
  return {mapper.world_from_robot(), tour.world_from_robot.back(), mapper.replays(),
          mapper.loops().size(), mapper.trajectory()};
}

TEST(LineMapper, AsksTheGraphWhereTheFilterIsTooSure) {
  const Ride without = ride(false), with = ride(true);
  std::printf("error %.3f m without, %.3f m with %zu loops, %d of them against the filter\n",
              (without.estimate.translation_m() - without.truth.translation_m()).norm(),
              (with.estimate.translation_m() - with.truth.translation_m()).norm(), with.loops,
              with.replays);
  EXPECT_GT(with.replays, 0);
  // What was driven since the last loop that contradicted the filter stays open: below 0.3 m.
  EXPECT_THAT(with.estimate, IsNear(with.truth, 0.30, 0.02));
  EXPECT_GT((without.estimate.translation_m() - without.truth.translation_m()).norm(), 0.5);
}

TEST(LineMapper, KilledAndResumedItMakesTheSameMapToTheLastBit) {
  const Ride saved = ride(true, Life::saved), killed = ride(true, Life::killed);
  EXPECT_GT(killed.replays, 0) << "the graph must have been asked after a checkpoint";
  EXPECT_EQ(killed.replays, saved.replays);
  EXPECT_EQ(killed.loops, saved.loops);
  ASSERT_EQ(killed.trajectory.size(), saved.trajectory.size());
  for (std::size_t i = 0; i < saved.trajectory.size(); ++i) {
    ASSERT_EQ(killed.trajectory[i].world_from_robot.vector(),
              saved.trajectory[i].world_from_robot.vector())
        << "scan " << i;
  }
}

TEST(LineMapper, HasAPoseForEveryScanThatMovesWithItsKeyScan) {
  const LinesWorld world = make_ring();
  std::mt19937 random(32);
  const LinesDrive tour = testing::drive({{3.0, 1.0}, {8.0, 1.0}}, 0.1, 0.2, {}, random);
  LineMapper mapper(LineMapperOptions{}, tour.world_from_robot[0]);
  Trajectory live;
  Pose2 odom_from_robot;
  for (std::size_t i = 0; i < tour.world_from_robot.size(); ++i) {
    const auto taken =
        testing::take_scan(world, testing::LinesLaser{}, tour.world_from_robot[i], random);
    const Utime utime = Utime::from_us(static_cast<int64_t>(i) * 100000);
    const Pose2 motion = i == 0 ? Pose2{} : tour.odometry_steps[i - 1];
    odom_from_robot = odom_from_robot * motion;
    live.push_back(
        {utime,
         mapper.process(input_of(taken.scan, i, odom_from_robot), taken.scan).world_from_robot});
  }
  const Trajectory trajectory = mapper.trajectory();
  ASSERT_EQ(trajectory.size(), live.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    // No loop: live it is the filter's pose, here that of scan matching.
    EXPECT_THAT(trajectory[i].world_from_robot, IsNear(live[i].world_from_robot, 0.02, 0.005));
    EXPECT_EQ(trajectory[i].utime, live[i].utime);
  }
}

TEST(LineMapper, AScanThatMayNotDrawLeavesTheMapAlone) {
  const LinesWorld world = make_ring();
  std::mt19937 random(33);
  LineMapper mapper(LineMapperOptions{}, {3.0, 1.0, 0.0});
  const auto taken = testing::take_scan(world, testing::LinesLaser{}, Pose2{3.0, 1.0, 0.0}, random);
  SlamInput input = input_of(taken.scan, 0, {});
  input.may_draw = false;
  mapper.process(input, taken.scan);
  EXPECT_EQ(mapper.filter().num_walls(), 0U);
  EXPECT_TRUE(mapper.keys().empty());
}

}  // namespace
}  // namespace marco::slam
