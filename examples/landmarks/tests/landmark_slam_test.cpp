#include "landmarks/landmark_slam.hpp"

#include <gtest/gtest.h>

#include "landmarks/bearing_convention.hpp"
#include "tests/post_run.hpp"

namespace marco::slam {
namespace {

// Short drives: the statistics of long ones are statistics.cpp.
testing::PostWorld short_world() {
  testing::PostWorld world;
  world.way_m = 40.0;
  return world;
}

testing::PostResult run(const testing::PostWorld& world, unsigned seed) {
  return testing::run_posts(testing::PostSimulation(world, seed).run(), {});
}

TEST(LandmarkSlam, FindsEveryPostAndNoOther) {
  const testing::PostResult result = run(short_world(), 11);
  EXPECT_EQ(result.found, 17);
  EXPECT_EQ(result.landmarks, 17);
  EXPECT_LT(result.path_rms_m, 0.02);  // measured: 0.007
  EXPECT_GT(result.dead_reckoning_rms_m, 0.1);
}

TEST(LandmarkSlam, FindsThemAmongClutterAndMisses) {
  testing::PostWorld world = short_world();
  world.clutter_part = 0.05;
  world.missed_part = 0.3;
  world.way_m = 70.0;
  const testing::PostResult result = run(world, 12);
  EXPECT_EQ(result.found, 17);
  EXPECT_EQ(result.landmarks, 17);
  EXPECT_LT(result.path_rms_m, 0.02);
}

TEST(LandmarkSlam, TellsPairsOfPostsApart) {
  testing::PostWorld world = short_world();
  world.pairs = 3;
  const testing::PostResult result = run(world, 13);
  EXPECT_EQ(result.found, 17);
  EXPECT_EQ(result.landmarks, 17);
}

TEST(LandmarkSlam, LearnsTheNoise) {
  const testing::PostResult result = run(short_world(), 14);
  EXPECT_NEAR(result.noise.range_sigma_m, 0.033, 0.003);
  EXPECT_NEAR(result.noise.bearing_sigma_rad, 0.026, 0.0025);
}

TEST(LandmarkSlam, LearnsWhatTheWheelsGetWrongAndWhereTheSensorIs) {
  testing::PostWorld world = short_world();
  world.way_m = 100.0;
  world.speed_scale = 1.0 / 1.04;
  world.turn_bias_rad_per_s = 0.01;
  world.sensor_ahead_m = 0.22;
  LandmarkSlam slam({});
  const testing::PostDrive drive = testing::PostSimulation(world, 15).run();
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    slam.process(drive.wheels[i]);
    slam.process(drive.scans[i]);
  }
  const SetUpVector set_up = slam.filter().set_up(), sigma = slam.filter().set_up_sigma();
  EXPECT_NEAR(set_up[speed_scale], 0.04, 0.01);
  EXPECT_NEAR(set_up[turn_bias], -0.01, 0.004);
  EXPECT_NEAR(set_up[sensor_x], 0.22, 0.02);
  EXPECT_LT(sigma[sensor_x], 0.02);
}

TEST(LandmarkSlam, ForgetsAPostThatIsTakenAway) {
  testing::PostWorld world = short_world();
  testing::PostDrive drive = testing::PostSimulation(world, 16).run();
  LandmarkSlam slam({});
  std::size_t most = 0;
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    slam.process(drive.wheels[i]);
    SightingScan scan = drive.scans[i];
    if (i > drive.wheels.size() / 3) {
      // The post nearest to the start is gone.
      const Pose2 sensor_from_world = drive.truth[i].world_from_robot.inverse();
      std::erase_if(scan.sightings, [&](const Sighting& sighting) {
        return (point_of(sighting) - sensor_from_world * drive.posts[0]).norm() < 0.4;
      });
    }
    slam.process(scan);
    most = std::max(most, slam.landmarks().size());
  }
  EXPECT_EQ(most, 17U);
  EXPECT_EQ(slam.landmarks().size(), 16U);
}

TEST(LandmarkSlam, LeavesOutWhatIsNoNumberOrLate) {
  LandmarkSlam slam({});
  EXPECT_TRUE(slam.process(WheelVelocity{Utime::from_seconds(2.0), 1.0, 0.0}));
  EXPECT_FALSE(slam.process(WheelVelocity{Utime::from_seconds(1.0), 1.0, 0.0}));
  EXPECT_FALSE(slam.process(WheelVelocity{Utime::from_seconds(3.0), std::nan(""), 0.0}));
  const SightingScan scan{Utime::from_seconds(2.0), {{std::nan(""), 0.0}, {-1.0, 0.0}}};
  EXPECT_EQ(slam.process(scan).added, 0);
  EXPECT_TRUE(is_finite(slam.world_from_robot()));
}

TEST(LandmarkSlam, RefusesAnOptionOutsideItsLimits) {
  LandmarkSlamOptions options;
  options.gate_probability = 1.5;
  EXPECT_THROW(LandmarkSlam{options}, std::invalid_argument);
}

TEST(BearingConvention, IsFoundFromTheDrive) {
  testing::PostWorld world = short_world();
  world.way_m = 15.0;
  const testing::PostDrive drive = testing::PostSimulation(world, 17).run();
  for (const BearingConvention wanted :
       {BearingConvention{0.0, 1.0}, {-0.5 * 3.14159265358979, 1.0}, {3.14159265358979, -1.0}}) {
    LandmarkDrive told{drive.wheels, drive.scans};
    for (SightingScan& scan : told.scans) {
      for (Sighting& sighting : scan.sightings) {
        sighting.bearing_rad = wanted.sign * (sighting.bearing_rad - wanted.zero_rad);
      }
    }
    const auto found = find_bearing_convention(told, {});
    ASSERT_TRUE(found) << wanted.zero_rad << " " << wanted.sign;
    EXPECT_NEAR(std::abs(normalize_angle(found->zero_rad - wanted.zero_rad)), 0.0, 1e-6);
    EXPECT_EQ(found->sign, wanted.sign);
  }
}

TEST(BearingConvention, IsNotGuessedForARobotThatStands) {
  LandmarkDrive drive;
  for (int i = 0; i < 50; ++i) {
    const Utime utime = Utime::from_seconds(0.1 * i);
    drive.wheels.push_back({utime, 0.0, 0.0});
    drive.scans.push_back({utime, {{2.0, 0.3}, {3.0, 1.0}}});
  }
  EXPECT_FALSE(find_bearing_convention(drive, {}));
}

}  // namespace
}  // namespace marco::slam
