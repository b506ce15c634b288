// The obstacle guard, through a base that it guards: what it lets through, and what it says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "guard_fixture.hpp"
#include "lcm_tools/process/config.hpp"

namespace marco::drivers {
namespace {

using testing::Guard;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST_F(Guard, StopsAtAWall) {
  world_.room(3.0);
  begin_seeing();
  bench_->run(12.0, BaseVelocity{0.8, 0.0});
  EXPECT_EQ(speed(), 0.0);
  // The wall is 6 cm thick. The margin, and how fine the parts are that an order has.
  EXPECT_NEAR(gap_m(), 0.10, 0.02);
  EXPECT_THAT(bench_->note(), HasSubstr("an obstacle is in the way"));
  // Away from it is free, and so is a turn.
  bench_->run(2.0, BaseVelocity{-0.3, 0.0});
  EXPECT_GT(gap_m(), 0.3);
  EXPECT_FALSE(bench_->touched());
}

TEST_F(Guard, LimitsALegAtItsStart) {
  world_.room(3.0);
  begin_seeing();
  EXPECT_EQ(move(5.0), Fate::shortened);
  EXPECT_NEAR(gap_m(), 0.10, 0.02);
  EXPECT_EQ(move(0.5), Fate::refused);
  EXPECT_THAT(bench_->note(), StartsWith("an obstacle is in the way"));
  EXPECT_EQ(move(-1.0), Fate::done);
  EXPECT_EQ(drive(Kind::turn, 1.0), Fate::done);
}

// The old guard looked straight ahead and at turns on the spot.
TEST_F(Guard, LooksAlongTheArc) {
  world_.room(4.0);
  world_.post(0.55, 0.62, 0.05);  // beside the way straight on, and in the bend to the left
  begin_seeing();
  bench_->run(3.0, BaseVelocity{0.4, 0.6});
  EXPECT_FALSE(bench_->touched());
  EXPECT_LT(gap_m(), 0.12);
  begin_seeing();
  bench_->run(3.0, BaseVelocity{0.4, 0.0});
  EXPECT_NEAR(speed(), 0.4, 1e-9);
}

TEST_F(Guard, ATurnAwayIsFreeWhereTheArcIsNot) {
  world_.room(4.0);
  world_.wall({0.45, -1.0}, {0.45, 1.0});  // 12 cm ahead, as thick as it is
  begin_seeing();
  bench_->run(1.0, BaseVelocity{0.4, 0.5});
  EXPECT_NEAR(bench_->base().velocity().turn_rad_per_s, 0.0, 0.5);
  EXPECT_GT(pose().theta_rad, 0.02);
  EXPECT_LT(std::abs(speed()), 0.01);
  EXPECT_FALSE(bench_->touched());
}

TEST_F(Guard, WhatIsWithinTheMarginMayBeLeft) {
  world_.room(6.0);
  world_.wall({-0.1, 0.27 + 0.03 + 0.015}, {0.1, 0.27 + 0.03 + 0.015});  // 1.5 cm beside the body
  begin_seeing();
  bench_->run(1.0, BaseVelocity{0.0, 0.5});  // its corners would swing at it
  EXPECT_LT(std::abs(pose().theta_rad), 0.01);
  bench_->run(5.0, BaseVelocity{0.4, 0.0});
  EXPECT_NEAR(speed(), 0.4, 1e-9);
  EXPECT_FALSE(bench_->touched());
}

TEST_F(Guard, ALegIsWatched) {
  world_.room(6.0);
  begin_seeing();
  bench_->give(leg(Kind::move, 4.0));
  bench_->run(2.0);
  ASSERT_GT(speed(), 0.4);
  world_.post(pose().x_m + 1.7, 0.0, 0.1);
  bench_->run(6.0);
  EXPECT_FALSE(bench_->touched());
  EXPECT_EQ(bench_->base().status().command, Fate::shortened);
  EXPECT_THAT(bench_->note(), StartsWith("an obstacle is in the way"));
  EXPECT_GT(pose().x_m, 1.2);
}

TEST_F(Guard, PeopleLeaveAndThinLegsStay) {
  world_.room(6.0);
  world_.post(1.2, 0.0, 0.12);
  begin_seeing();
  bench_->run(5.0, BaseVelocity{0.5, 0.0});
  EXPECT_EQ(speed(), 0.0);
  world_.things.pop_back();
  bench_->run(1.0, BaseVelocity{0.5, 0.0});
  EXPECT_GT(speed(), 0.1);

  // A leg that half of the scans miss from afar.
  world_.post(pose().x_m + 2.0, 0.004, 0.015);
  laser_.beams = 121;
  begin({pose().x_m, 0.0, 0.0});
  for (int i = 0; i < 250; ++i) {
    bench_->run(0.02, BaseVelocity{0.5, i % 50 < 25 ? 0.05 : -0.05});
  }
  EXPECT_FALSE(bench_->touched());
}

TEST_F(Guard, AWallThatBeamsGrazeStays) {
  world_.wall({0.6, -0.30 - 0.06}, {9.0, -0.30 - 0.06});
  laser_.beams = 121;
  begin_seeing();
  for (int i = 0; i < 20; ++i) {
    bench_->run(0.5, BaseVelocity{0.5, 0.0});
    bench_->run(0.5, BaseVelocity{0.3, -0.3});
    bench_->run(0.5, BaseVelocity{0.3, 0.3});
    ASSERT_FALSE(bench_->touched()) << i;
  }
}

// With a view ahead alone: what it saw stays when it turns away.
TEST_F(Guard, RemembersAPillarOutOfView) {
  laser_.view_deg = 180.0;
  world_.room(6.0);
  world_.post(0.1, -0.52, 0.1);
  begin_seeing({0.0, 0.0, -0.6});
  bench_->run(2.5, BaseVelocity{0.0, 0.8});  // until it is behind
  const Pose2 before = pose();
  EXPECT_GT(before.theta_rad, 0.5);
  bench_->run(4.0, BaseVelocity{0.0, 1.0});
  EXPECT_FALSE(bench_->touched());
}

TEST_F(Guard, BackwardsWhereNoSensorSees) {
  laser_.view_deg = 180.0;
  world_.room(6.0);
  begin_seeing();
  bench_->run(1.0, BaseVelocity{-0.4, 0.0});  // nobody knows what is there
  EXPECT_NEAR(pose().x_m, 0.0, 0.05);
  EXPECT_THAT(bench_->note(), HasSubstr("no sensor sees the ground there"));
  EXPECT_EQ(move(-0.3), Fate::refused);

  bench_->run(4.0, BaseVelocity{0.5, 0.0});
  bench_->run(2.0, BaseVelocity{});
  const double front_m = pose().x_m;
  double fastest = 0.0;
  for (int i = 0; i < 500; ++i) {
    bench_->run(0.02, BaseVelocity{-0.4, 0.0});
    fastest = std::max(fastest, -speed());
  }
  EXPECT_LE(fastest, 0.1 + 1e-9);
  EXPECT_GT(fastest, 0.09);
  EXPECT_NEAR(front_m - pose().x_m, 0.5, 0.1);
  EXPECT_EQ(speed(), 0.0);
  // Seen ground ahead begins a new half metre; legs go as slowly.
  bench_->run(2.0, BaseVelocity{0.3, 0.0});
  bench_->run(2.0, BaseVelocity{});
  const double from_m = pose().x_m;
  bench_->give(leg(Kind::move, -0.3));
  for (int i = 0; i < 200; ++i) {
    bench_->run(0.02);
    EXPECT_GE(speed(), -0.1 - 1e-9);
  }
  EXPECT_EQ(bench_->base().status().command, Fate::done);
  EXPECT_NEAR(pose().x_m, from_m - 0.3, 0.02);

  bench_->run(31.0);  // long ago
  EXPECT_EQ(move(-0.3), Fate::refused);
}

// As after a restart of its driver alone.
TEST_F(Guard, ItsOdometryMayBeginAnywhere) {
  world_.room(6.0);
  begin_seeing({3.0, 2.0, 0.5});
  EXPECT_EQ(move(1.0), Fate::done);
}

TEST_F(Guard, ForwardWithALaserThatLooksBack) {
  laser_.view_deg = 180.0;
  world_.room(6.0);
  begin_seeing();
  SensorInfo back;
  back.parent_from_sensor = make_pose3({0.0, 0.0, 0.3}, 0.0, 0.0, std::numbers::pi);
  bench_->base().guard().forget_sensors();
  bench_->base().guard().on_sensor_info(back);
  bench_->run(0.5);
  bench_->run(1.0, BaseVelocity{0.4, 0.0});
  EXPECT_LT(speed(), 0.01);
  bench_->run(2.0, BaseVelocity{-0.4, 0.0});
  EXPECT_NEAR(speed(), -0.4, 1e-9);
}

TEST_F(Guard, DoorsArePassed) {
  for (const double off_m : {-0.02, 0.0, 0.02}) {
    world_.things.clear();
    world_.wall({1.0, -3.0}, {1.0, -0.32 - 0.03});  // the body and 5 cm on each side
    world_.wall({1.0, 0.32 + 0.03}, {1.0, 3.0});
    world_.room(4.0);
    begin_seeing({0.0, off_m, 0.0});
    bench_->run(12.0, BaseVelocity{0.3, 0.0});
    EXPECT_GT(pose().x_m, 2.0) << off_m << bench_->note();
    EXPECT_FALSE(bench_->touched());
  }
}

// A hand that steers for the middle of the door.
TEST_F(Guard, DoorsArePassedByArcs) {
  for (const double off_m : {-0.6, 0.4}) {
    world_.things.clear();
    world_.wall({1.5, -4.0}, {1.5, -0.32 - 0.03});
    world_.wall({1.5, 0.32 + 0.03}, {1.5, 4.0});
    world_.room(4.0);
    begin_seeing({-1.0, off_m, 0.0});
    for (int i = 0; i < 2000 && pose().x_m < 2.6; ++i) {
      const double aim_m = 0.6, wanted = std::atan2(-pose().y_m, aim_m);
      bench_->run(0.02,
                  BaseVelocity{0.25, std::clamp(2.0 * (wanted - pose().theta_rad), -0.8, 0.8)});
    }
    EXPECT_GT(pose().x_m, 2.5) << off_m << " " << bench_->note();
    EXPECT_FALSE(bench_->touched());
  }
}

TEST_F(Guard, WithoutSensorsItGoesSlowlyAndSaysSo) {
  laser_.runs = false;
  begin();
  bench_->run(2.0, BaseVelocity{0.8, 0.0});
  EXPECT_NEAR(speed(), 0.2, 1e-9);
  EXPECT_THAT(bench_->note(), HasSubstr("guard: at most 0.2 m/s: no laser or sonar data"));
  bench_->run(2.0, BaseVelocity{0.0, 1.2});
  EXPECT_NEAR(bench_->base().velocity().turn_rad_per_s, 0.2 / std::hypot(0.30, 0.27), 1e-9);
  bench_->run(1.0, BaseVelocity{});
  bench_->give(leg(Kind::move, 2.0));
  bench_->run(3.0);
  EXPECT_NEAR(speed(), 0.2, 1e-9);
}

TEST_F(Guard, ALaserIsOfUseWhenItsPlaneIsKnownAndNotAboveTheBody) {
  struct Case {
    double height_m;
    const char* words;
  };
  for (const auto& [height_m, words] :
       {Case{0.0, "LIDAR has no height (position_m)"},
        Case{1.3, "LIDAR is above the body (max_height_m)"}, Case{0.05, ""}, Case{0.18, ""}}) {
    laser_.height_m = height_m;
    world_.things.clear();
    world_.room(3.0);
    begin_seeing();
    bench_->run(14.0, BaseVelocity{0.8, 0.0});
    // Whatever its height, what it sees stops it.
    EXPECT_NEAR(gap_m(), 0.10, 0.02) << height_m;
    EXPECT_FALSE(bench_->touched());
    if (*words == '\0') {
      EXPECT_THAT(bench_->note(), Not(HasSubstr("guard:"))) << height_m;
    } else {
      EXPECT_THAT(bench_->note(), HasSubstr(std::string("guard: at most 0.2 m/s: ") + words));
    }
  }
}

TEST_F(Guard, ALaserThatSeesNothingOrTheFloorAloneIsNotOfUse) {
  laser_.range_max_m = 5.0;  // no wall is so near
  begin_seeing();
  bench_->run(1.0, BaseVelocity{0.8, 0.0});
  EXPECT_THAT(bench_->note(), HasSubstr("LIDAR sees nothing at the body's height"));
  EXPECT_LE(speed(), 0.2 + 1e-9);

  world_.room(3.0);
  laser_.range_max_m = 80.0;
  laser_.view_deg = 60.0;
  begin();
  SensorInfo down;  // 20 degrees: the floor is 0.9 m ahead
  down.parent_from_sensor = make_pose3({0.0, 0.0, 0.3}, 0.0, deg_to_rad(20.0), 0.0);
  bench_->base().guard().forget_sensors();
  bench_->base().guard().on_sensor_info(down);
  bench_->run(1.0, BaseVelocity{0.8, 0.0});
  EXPECT_LT(bench_->base().told().ahead_m_per_s, 0.2 + 1e-9);
  EXPECT_THAT(bench_->note(), HasSubstr("LIDAR sees nothing at the body's height"));
}

TEST_F(Guard, ASilentLaserStopsTheRobotAndAHeldStickMustBeLetGo) {
  world_.room(6.0);
  begin_seeing();
  bench_->run(2.0, BaseVelocity{0.4, 0.0});
  ASSERT_NEAR(speed(), 0.4, 1e-9);
  bench_->laser.runs = false;
  bench_->run(0.7, BaseVelocity{0.4, 0.0});
  EXPECT_THAT(bench_->note(), HasSubstr("LIDAR is silent for 0."));
  bench_->run(1.5, BaseVelocity{0.4, 0.0});
  EXPECT_EQ(speed(), 0.0);
  EXPECT_EQ(move(0.3), Fate::refused);
  bench_->laser.runs = true;
  bench_->run(2.0, BaseVelocity{0.4, 0.0});  // still held
  EXPECT_EQ(speed(), 0.0);
  EXPECT_THAT(bench_->note(), HasSubstr("release the stick"));
  bench_->run(0.2);
  bench_->run(1.0, BaseVelocity{0.4, 0.0});  // too short a pause
  EXPECT_EQ(speed(), 0.0);
  bench_->run(0.6);
  bench_->run(2.0, BaseVelocity{0.4, 0.0});
  EXPECT_NEAR(speed(), 0.4, 1e-9);
  // Or an order to rest between.
  bench_->laser.runs = false;
  bench_->run(1.0, BaseVelocity{0.4, 0.0});
  bench_->laser.runs = true;
  bench_->run(0.3, BaseVelocity{0.4, 0.0});
  bench_->run(0.1, BaseVelocity{});
  bench_->run(2.0, BaseVelocity{0.4, 0.0});
  EXPECT_NEAR(speed(), 0.4, 1e-9);
}

TEST_F(Guard, ALegThatASilentLaserEndedDoesNotResume) {
  world_.room(6.0);
  begin_seeing();
  bench_->give(leg(Kind::move, 4.0));
  bench_->run(1.5);
  bench_->laser.runs = false;
  bench_->run(3.0);
  EXPECT_EQ(bench_->base().status().command, Fate::aborted);
  EXPECT_THAT(bench_->note(), StartsWith("LIDAR is silent for 0."));
  EXPECT_EQ(speed(), 0.0);
  bench_->laser.runs = true;
  const double at_m = pose().x_m;
  bench_->run(3.0);
  EXPECT_EQ(pose().x_m, at_m);
  EXPECT_EQ(move(0.5), Fate::done);
}

TEST_F(Guard, ASlowLaserIsNotSilent) {
  world_.room(6.0);
  laser_.hz = 2.5;
  begin();
  bench_->run(2.0);
  bench_->run(5.0, BaseVelocity{0.3, 0.0});
  EXPECT_NEAR(speed(), 0.3, 1e-9);
}

TEST_F(Guard, ASensorThatWasRemovedIsForgottenByOrder) {
  world_.room(6.0);
  begin_seeing();
  bench_->laser.runs = false;
  bench_->run(2.0);
  EXPECT_EQ(move(0.3), Fate::refused);
  BaseCommand forget = leg(Kind::forget_sensors, 0.0);
  bench_->give(forget);
  EXPECT_EQ(bench_->base().status().command, Fate::done);
  EXPECT_THAT(bench_->note(), StartsWith("forgot LIDAR; guard: at most 0.2 m/s: no laser"));
  EXPECT_EQ(move(0.3), Fate::done);
  bench_->give(forget);
  EXPECT_THAT(bench_->note(), StartsWith("forgot no sensor"));
  // Checked for its age, as others are.
  forget.utime = bench_->now() - Duration::from_seconds(3.0);
  bench_->base().command(forget, bench_->now());
  EXPECT_EQ(bench_->base().status().command, Fate::refused);
}

TEST_F(Guard, AnotherMountIsRefusedAndMakesItSlow) {
  world_.room(4.0);
  begin_seeing();
  bench_->run(1.0, BaseVelocity{0.5, 0.0});
  bench_->laser.height_m = 5.0;  // somebody says
  bench_->tell_mount();
  bench_->run(1.5, BaseVelocity{0.5, 0.0});
  EXPECT_NEAR(speed(), 0.2, 1e-9);
  EXPECT_THAT(bench_->note(), HasSubstr("LIDAR is in dispute"));
  EXPECT_THAT(bench_->note(), HasSubstr("another mount for LIDAR is refused"));
  bench_->run(8.0);
  bench_->run(1.0, BaseVelocity{0.5, 0.0});
  EXPECT_THAT(bench_->note(), Not(HasSubstr("guard:")));
  // A leg that is under way is too fast then.
  begin_seeing();
  bench_->laser.height_m = 0.3;
  bench_->give(leg(Kind::move, 3.0));
  bench_->run(2.0);
  bench_->laser.height_m = 0.3011;  // more than a millimetre
  bench_->tell_mount();
  bench_->run(3.0);
  EXPECT_EQ(bench_->base().status().command, Fate::shortened);
  EXPECT_EQ(speed(), 0.0);
}

TEST_F(Guard, AFloodOfChannelsCostsNothing) {
  world_.room(4.0);
  begin_seeing();
  ObstacleGuard& guard = bench_->base().guard();
  SensorInfo info;
  for (int i = 0; i < 60'000; ++i) {
    info.channel = "LIDAR_" + std::to_string(i);
    guard.on_sensor_info(info);
    info.channel = "CAMERA_" + std::to_string(i);
    guard.on_sensor_info(info);
  }
  bench_->run(2.0, BaseVelocity{0.5, 0.0});
  EXPECT_NEAR(speed(), 0.5, 1e-9);
  const std::string names = guard.forget_sensors();
  EXPECT_EQ(std::count(names.begin(), names.end(), ','), 15);
  EXPECT_THAT(names, Not(HasSubstr("CAMERA")));
}

TEST_F(Guard, ItsSwitchIsShown) {
  options_.enabled = false;
  world_.post(0.5, 0.0, 0.05);
  begin_seeing();
  EXPECT_EQ(bench_->note(), "guard: off");
  bench_->run(3.0, BaseVelocity{0.5, 0.0});
  EXPECT_TRUE(bench_->touched());
}

TEST_F(Guard, ABumperLeavesTurnsAndTheWayBack) {
  world_.room(6.0);
  begin_seeing();
  bench_->base().guard().on_bumpers({2}, {});
  bench_->run(1.0, BaseVelocity{0.4, 0.5});
  EXPECT_EQ(speed(), 0.0);
  EXPECT_GT(pose().theta_rad, 0.1);
  EXPECT_THAT(bench_->note(), StartsWith("front bumper 2 is pressed"));
  EXPECT_EQ(move(0.3), Fate::refused);
  bench_->run(1.0, BaseVelocity{-0.4, 0.0});
  EXPECT_LT(speed(), -0.2);
}

TEST_F(Guard, AScanWhileTheRobotTurnsIsDeskewed) {
  world_.room(6.0);
  world_.post(0.75, 0.0, 0.05);
  laser_.runs = false;
  begin();
  ObstacleGuard& guard = bench_->base().guard();
  SensorInfo info;
  info.parent_from_sensor.translation().z() = 0.3;
  info.scan_duration_s = 0.2;
  guard.forget_sensors();
  guard.on_sensor_info(info);
  // It turns by 1 rad/s; the beam straight ahead is measured 0.1 s before the scan arrives.
  const Utime begin = bench_->now();
  for (int i = 0; i <= 20; ++i) {
    const Utime when = begin + Duration::from_seconds(0.01 * i);
    guard.note_time(when);
    guard.on_odometry({when, {0.0, 0.0, 0.01 * i}, 0.0, 1.0});
  }
  LaserScan scan;
  scan.utime = begin;
  scan.first_bearing_rad = -1.0;
  scan.bearing_step_rad = 0.01;
  scan.ranges_m.assign(201, 5.0F);
  scan.ranges_m[100] = 0.70F;
  guard.on_scan(scan, {0.0, 0.0, 0.2}, begin + Duration::from_seconds(0.2));
  // Straight ahead of where it looked then: 0.1 rad to the right of where it looks now.
  guard.on_odometry({begin + Duration::from_seconds(0.21), {0.0, 0.0, 0.1}, 0.0, 0.0});
  EXPECT_NEAR(guard.free_move(2.0).amount, 0.30, 0.011);
  guard.on_odometry({begin + Duration::from_seconds(0.22), {0.0, 0.0, 0.1 + 0.6}, 0.0, 0.0});
  EXPECT_GT(guard.free_move(2.0).amount, 1.0);
}

TEST_F(Guard, ScansThatComeTwiceAndRawOnesAlone) {
  begin();
  ObstacleGuard& guard = bench_->base().guard();
  LaserScan scan;
  scan.utime = bench_->now();
  scan.channel = "LIDAR_RAW";
  scan.first_bearing_rad = -1.5;
  scan.bearing_step_rad = 0.03;
  scan.ranges_m.assign(101, 5.0F);
  scan.ranges_m[50] = 0.9F;
  guard.on_scan(scan, {}, bench_->now());
  EXPECT_NEAR(guard.free_move(2.0).amount, 0.50, 0.011);
  scan.channel = "LIDAR";
  scan.ranges_m[50] = 0.6F;
  guard.on_scan(scan, {}, bench_->now());  // the same: not used
  EXPECT_NEAR(guard.free_move(2.0).amount, 0.50, 0.011);
}

TEST_F(Guard, SonarsAloneAreOfUse) {
  laser_.runs = false;
  begin();
  ObstacleGuard& guard = bench_->base().guard();
  SonarRing ring;
  ring.cone_rad = 0.26;
  for (int i = 0; i < 16; ++i) {
    ring.readings.push_back({3.0, {0.0, 0.0, normalize_angle(i * std::numbers::pi / 8.0)}});
  }
  const auto sound = [&](double seconds, const BaseVelocity& order) {
    for (double t_s = 0.0; t_s < seconds; t_s += 0.1) {
      ring.utime = bench_->now();
      guard.on_sonar(ring, pose(), bench_->now());
      bench_->run(0.1, order);
    }
  };
  sound(3.0, {0.4, 0.0});
  EXPECT_NEAR(speed(), 0.4, 1e-9);
  EXPECT_THAT(bench_->note(), Not(HasSubstr("guard:")));
  ring.readings[0].range_m = 0.35;
  sound(3.0, {0.4, 0.0});
  EXPECT_EQ(speed(), 0.0);
  bench_->run(0.8, BaseVelocity{-0.4, 0.0});
  EXPECT_THAT(bench_->note(), HasSubstr("SONAR is silent for"));
}

TEST_F(Guard, RefusesABodyThatIsNone) {
  options_.body_m = {0.1, 0.1, 0.2};
  EXPECT_THAT([&] { ObstacleGuard{options_}; },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("body_m")));
}

}  // namespace
}  // namespace marco::drivers
