#include "teleop/goal_drive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driven_base.hpp"
#include "drivers/create/driver.hpp"
#include "drivers/kobuki/driver.hpp"
#include "drivers/p2os/driver.hpp"
#include "hcs12_base.hpp"
#include "simulator/devices/create/emulator.hpp"
#include "simulator/devices/kobuki/emulator.hpp"
#include "simulator/devices/p2os/emulator.hpp"
#include "simulator/devices/textbase/emulator.hpp"
#include "text_base.hpp"

namespace marco::teleop {
namespace {

using ::testing::HasSubstr;
using Fate = BaseStatus::Command;
using Kind = BaseCommand::Kind;

constexpr int64_t kId = 7;
constexpr Duration kEvery = Duration::from_seconds(GoalDrive::kSendEveryS);

BaseStatus said(int64_t id, Fate command, const std::string& note = "") {
  BaseStatus status;
  status.command_id = id;
  status.command = command;
  status.note = note;
  return status;
}

/// A drive whose base has taken it; the robot moves as it is told, at once.
struct Told {
  GoalDrive drive{kId, {}, Utime{}};
  Pose2 robot;
  Utime now;
  Eigen::Vector2d goal_m{1.0, 0.5};

  Told() { drive.on_status(said(kId, Fate::running)); }
  std::optional<BaseCommand> step(Duration later = kEvery) {
    now = now + later;
    const auto order = drive.next(robot.inverse() * goal_m, now);
    if (order) {
      robot = robot * Pose2{order->velocity_m_per_s * later.seconds(), 0.0,
                            order->yaw_rate_rad_per_s * later.seconds()};
    }
    return order;
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) ASSERT_TRUE(step());
  }
};

TEST(GoalDrive, AllItsOrdersLapseByThemselves) {
  Told told;
  int orders = 0;
  while (const auto order = told.step()) {
    ASSERT_EQ(order->kind, Kind::velocity);
    ASSERT_EQ(order->id, kId);
    ASSERT_EQ(order->utime.us, told.now.us);
    ASSERT_LE(order->velocity_m_per_s, 0.4);
    ASSERT_LE(std::abs(order->yaw_rate_rad_per_s), 0.8);
    ASSERT_LT(++orders, 400);
  }
  EXPECT_EQ(told.drive.why_ended(), "");
  EXPECT_LT((told.robot.inverse() * told.goal_m).norm(), GoalDrive::kNearM);
  EXPECT_FALSE(told.step());
}

TEST(GoalDrive, ASenderThatWasHeldUpDoesNotGoOn) {
  Told told;
  told.steps(20);
  EXPECT_TRUE(told.step(Duration::from_seconds(0.45)));
  EXPECT_FALSE(told.step(Duration::from_seconds(0.6)));
  EXPECT_THAT(told.drive.why_ended(), HasSubstr("stalled"));
  EXPECT_FALSE(told.step());
  Told stepped;
  stepped.steps(20);
  EXPECT_FALSE(stepped.step(Duration::from_seconds(-5.0)));  // the clock was set back
}

TEST(GoalDrive, ItStandsForAMomentAndGoesOn) {
  Told told;
  told.steps(20);
  for (int i = 0; i < 10; ++i) {
    told.now = told.now + kEvery;
    const auto order = told.drive.hold(told.now);
    ASSERT_TRUE(order);
    EXPECT_EQ(order->kind, Kind::velocity);
    EXPECT_EQ(order->id, kId);
    EXPECT_EQ(std::abs(order->velocity_m_per_s) + std::abs(order->yaw_rate_rad_per_s), 0.0);
  }
  told.steps(20);
  EXPECT_FALSE(told.drive.hold(told.now + Duration::from_seconds(0.6)));
  EXPECT_THAT(told.drive.why_ended(), HasSubstr("stalled"));
}

TEST(GoalDrive, ItEndsWithTheBasesWordAndWithOrdersOfOthers) {
  for (const Fate fate : {Fate::done, Fate::shortened, Fate::refused, Fate::aborted}) {
    Told told;
    told.steps(5);
    told.drive.on_status(said(kId, fate, "because"));
    EXPECT_FALSE(told.step());
    EXPECT_EQ(told.drive.why_ended(), "because");
    EXPECT_FALSE(told.drive.is_taken_over());
  }
  Told told;
  told.drive.on_status(said(9, Fate::refused, "too old"));  // changes nothing for ours
  told.steps(5);
  told.drive.on_status(said(9, Fate::running));
  EXPECT_FALSE(told.step());
  EXPECT_THAT(told.drive.why_ended(), HasSubstr("another order"));
  EXPECT_TRUE(told.drive.is_taken_over());
}

TEST(GoalDrive, ItWaitsForTheBaseAndNotForEver) {
  GoalDrive drive(kId, {}, Utime{});
  Utime now;
  drive.on_status(said(3, Fate::done));  // of the order before
  int orders = 0;
  for (; drive.next({2.0, 0.0}, now); now = now + kEvery) ++orders;
  EXPECT_NEAR(orders * GoalDrive::kSendEveryS, 2.5, 0.6);
  Told stuck;  // taken, and blocked
  orders = 0;
  for (Utime at; stuck.drive.next({0.5, 0.0}, at); at = at + kEvery) {
    stuck.drive.on_status(said(kId, Fate::running, "slowed down before an obstacle"));
    ++orders;
  }
  EXPECT_NEAR(orders * GoalDrive::kSendEveryS, 2.5, 0.3);
  EXPECT_EQ(stuck.drive.why_ended(), "slowed down before an obstacle");
}

struct Hcs12Robot : drivers::testing::Hcs12OnBench {
  bool moves() const { return board.motors_on(); }
};
struct P2osParts {
  drivers::p2os::P2osEmulator robot;
  drivers::p2os::P2osBase driver{drivers::p2os::P2osOptions{}};
};
struct P2osRobot : P2osParts, drivers::testing::DrivenBase<drivers::p2os::P2osBase> {
  P2osRobot() : DrivenBase(driver, robot, drivers::p2os::kBaud) {}
  bool moves() const { return robot.velocity_m_per_s() != 0 || robot.yaw_rate_rad_per_s() != 0; }
};
struct TextParts {
  drivers::textbase::TextBoard robot;
  drivers::textbase::TextBase driver{drivers::textbase::small_robot()};
};
struct TextRobot : TextParts, drivers::testing::DrivenBase<drivers::textbase::TextBase> {
  TextRobot() : DrivenBase(driver, robot, drivers::textbase::kBaud) {}
  bool moves() const { return std::abs(robot.left_ticks_per_s()) > 20.0; }
};
struct CreateParts {
  drivers::create::CreateEmulator robot;
  drivers::create::CreateBase driver{drivers::create::CreateOptions{}};
};
struct CreateRobot : CreateParts, drivers::testing::DrivenBase<drivers::create::CreateBase> {
  CreateRobot() : DrivenBase(driver, robot, drivers::create::kBaud) {}
  bool moves() const { return std::abs(robot.left_m_per_s()) > 0.003; }
};
struct KobukiParts {
  drivers::kobuki::KobukiEmulator robot;
  drivers::kobuki::KobukiBase driver{drivers::kobuki::KobukiOptions{}};
};
struct KobukiRobot : KobukiParts, drivers::testing::DrivenBase<drivers::kobuki::KobukiBase> {
  KobukiRobot() : DrivenBase(driver, robot, drivers::kobuki::kBaud) {}
  bool moves() const { return std::abs(robot.left_m_per_s()) > 0.003; }
};

template <class Robot>
class GoalOfBase : public ::testing::Test {
 protected:
  /// @returns whether it drove for that long
  bool drive(GoalDrive& goal, const Eigen::Vector2d& odom_m, double seconds) {
    const Utime end = robot_.bench.now() + Duration::from_seconds(seconds);
    while (robot_.bench.now() < end) {
      goal.on_status(robot_.driver.status());
      const auto order =
          goal.next(robot_.driver.odom_from_robot().inverse() * odom_m, robot_.bench.host_now());
      if (!order) return false;
      robot_.driver.command(*order, robot_.bench.host_now());
      robot_.bench.run(GoalDrive::kSendEveryS);
    }
    return true;
  }
  Robot robot_;
};
using GoalRobots = ::testing::Types<Hcs12Robot, P2osRobot, TextRobot, CreateRobot, KobukiRobot>;
TYPED_TEST_SUITE(GoalOfBase, GoalRobots);

TYPED_TEST(GoalOfBase, IsReachedAndLastsNoLongerThanItsSender) {
  auto& robot = this->robot_;
  int64_t id = 100;
  for (const Eigen::Vector2d& goal_m : {Eigen::Vector2d{0.9, 0.4}, {0.3, -0.2}, {0.35, -0.2}}) {
    GoalDrive goal(++id, {}, robot.bench.host_now());
    EXPECT_FALSE(this->drive(goal, goal_m, 30.0));
    EXPECT_EQ(goal.why_ended(), "");
    EXPECT_LT((robot.driver.odom_from_robot().inverse() * goal_m).norm(), GoalDrive::kNearM);
    robot.begin({});
    robot.bench.run(1.0);
  }
  for (const double after_s : {0.5, 3.0}) {  // in its turn, in its move
    GoalDrive goal(++id, {}, robot.bench.host_now());
    EXPECT_TRUE(this->drive(goal, {-9.0, -0.2}, after_s));
    EXPECT_TRUE(robot.moves());
    EXPECT_TRUE(robot.bench.run_until(1.0, [&] { return !robot.moves(); })) << after_s;
    EXPECT_FALSE(this->drive(goal, {-9.0, -0.2}, 0.1));  // its sender comes back
    robot.bench.run(0.5);
    EXPECT_FALSE(robot.moves());
  }
}

}  // namespace
}  // namespace marco::teleop
