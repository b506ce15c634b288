// Where the obstacle guard draws its limits, through a base that it guards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "guard_fixture.hpp"

namespace marco::drivers {
namespace {

using testing::Guard;
using ::testing::HasSubstr;

// A base that brakes harder than its setting says may be heavier one day.
TEST_F(Guard, ReliesOnTheBrakingThatIsSetThoughTheBaseBrakesHarder) {
  options_.braking_m_per_s2 = 0.15;
  world_.room(3.0);
  begin_seeing();
  for (int i = 0; i < 800; ++i) {
    bench_->run(0.02, BaseVelocity{0.8, 0.0});
    // Before the wall, its margin and the way of a delay.
    const double way_m = std::max(0.0, gap_m() - 0.08);
    EXPECT_LT(speed() * speed() / (2.0 * 0.15), way_m + 0.01) << way_m;
  }
  EXPECT_NEAR(gap_m(), 0.10, 0.02);
}

TEST_F(Guard, ATurnEndsBeforeACornerOfTheBodyMeetsSomething) {
  world_.room(6.0);
  world_.post(0.22, 0.40, 0.05);
  begin_seeing();
  EXPECT_EQ(drive(Kind::turn, 1.5), Fate::shortened);
  EXPECT_NEAR(gap_m(), 0.03, 0.012);
  EXPECT_GT(pose().theta_rad, 0.05);
  EXPECT_EQ(drive(Kind::turn, -0.5), Fate::done);
}

TEST_F(Guard, ALegOfLessThanTwoCentimetresIsNotWorthTheWhile) {
  world_.room(6.0);
  world_.wall({0.30 + 0.03 + 0.14, -1.0}, {0.30 + 0.03 + 0.14, 1.0});
  begin_seeing();
  EXPECT_EQ(move(0.5), Fate::shortened);  // 4 cm are free
  EXPECT_NEAR(pose().x_m, 0.035, 0.011);
  EXPECT_EQ(move(0.5), Fate::refused);
}

TEST_F(Guard, APointBehindAWallIsTurnedToAndNoMore) {
  world_.room(6.0);
  world_.wall({0.30 + 0.03 + 0.11, -1.0}, {0.30 + 0.03 + 0.11, 1.0});
  begin_seeing();
  BaseCommand go = leg(Kind::go_to, 0.0);
  go.point_m = {1.0, 0.1};
  bench_->give(go);
  bench_->run(5.0);
  EXPECT_EQ(bench_->base().status().command, Fate::shortened) << "a part of it was driven";
  EXPECT_NEAR(pose().theta_rad, 0.1, 0.01);
  EXPECT_NEAR(pose().x_m, 0.0, 1e-6);
}

TEST_F(Guard, ABendAheadBeginsANewHalfMetreAndATurnDoesNot) {
  laser_.view_deg = 180.0;
  world_.room(6.0);
  begin_seeing();
  bench_->run(4.0, BaseVelocity{0.5, 0.0});
  bench_->run(2.0, BaseVelocity{});
  bench_->run(10.0, BaseVelocity{-0.1, 0.0});  // as far as it may
  EXPECT_NE(move(-0.3), Fate::done);
  bench_->run(1.0, BaseVelocity{0.0, 0.3});
  bench_->run(2.0, BaseVelocity{0.0, -0.3});
  bench_->run(1.0, BaseVelocity{});
  EXPECT_NE(move(-0.2), Fate::done);
  bench_->run(1.5, BaseVelocity{0.3, 0.3});
  bench_->run(2.0, BaseVelocity{});
  EXPECT_EQ(move(-0.2), Fate::done);
}

TEST_F(Guard, ThatSaysNothingOfAFreeWayLetsItThroughWhole) {
  world_.room(6.0);
  begin_seeing();
  const ObstacleGuard::FreeWay ahead = bench_->base().guard().free_move(1.5);
  EXPECT_EQ(ahead.amount, 1.5);
  EXPECT_EQ(ahead.why, "");
  EXPECT_EQ(ahead.speed_limit_m_per_s, std::numeric_limits<double>::infinity());
  EXPECT_EQ(bench_->base().guard().free_turn(-2.0).amount, -2.0);
  EXPECT_EQ(bench_->base().guard().free_move(0.0).amount, 0.0);
}

TEST_F(Guard, AStickAtRestMayDriveOnAfterALaserWasSilent) {
  world_.room(6.0);
  begin_seeing();
  bench_->run(0.3, BaseVelocity{});
  bench_->laser.runs = false;
  bench_->run(0.45, BaseVelocity{});
  bench_->run(0.15);
  ASSERT_THAT(bench_->note(), HasSubstr("LIDAR is silent"));
  bench_->laser.runs = true;
  bench_->run(0.1);
  bench_->run(2.0, BaseVelocity{0.4, 0.0});  // within half a second of the last one
  EXPECT_NEAR(speed(), 0.4, 1e-9);
}

}  // namespace
}  // namespace marco::drivers
