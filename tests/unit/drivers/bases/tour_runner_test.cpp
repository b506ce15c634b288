#include "teleop/tour_runner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco::teleop {
namespace {

using ::testing::HasSubstr;
using Fate = BaseStatus::Command;

/// A robot that does what it is told, one order a step.
class ObedientRobot {
 public:
  explicit ObedientRobot(TourRunner& runner) : runner_(runner) {}

  void step() {
    now_ = now_ + Duration::from_us(50'000);
    if (speaks) runner_.on_base_status(status(), now_);
    runner_.on_pantilt(head_, now_);
    runner_.on_pose(pose, now_);
    const TourRunner::Orders orders = runner_.step(now_);
    for (const BaseCommand& command : orders.base) obey(command);
    for (const PanTiltCommand& command : orders.pantilt) {
      ++gazes;
      fastest_tilt = std::max(fastest_tilt, command.tilt_rate_rad_per_s);
      head_.pan_rad = command.pan_rad;
      head_.tilt_rad = command.tilt_rad;
      highest_tilt = std::max(highest_tilt, head_.tilt_rad);
    }
    head_.utime = now_;
  }
  void run(int steps) {
    for (int i = 0; i < steps && runner_.outcome() == TourRunner::Outcome::running; ++i) step();
  }

  Pose2 pose;
  BaseStatus::Link link = BaseStatus::Link::up;
  Fate answer = Fate::done;
  bool speaks = true;
  int moves = 0;
  int gazes = 0;
  double fastest_tilt = 0.0;
  double highest_tilt = -1.0;

 private:
  BaseStatus status() const {
    BaseStatus status;
    status.link = link;
    status.command_id = id_;
    status.command = id_ > 0 ? answer : Fate::none;
    return status;
  }
  void obey(const BaseCommand& command) {
    id_ = command.id;
    ++moves;
    if (answer != Fate::done) return;
    if (command.kind == BaseCommand::Kind::move) pose = pose * Pose2{command.distance_m, 0.0, 0.0};
    if (command.kind == BaseCommand::Kind::turn) pose = pose * Pose2{0.0, 0.0, command.angle_rad};
  }

  TourRunner& runner_;
  Utime now_ = Utime::from_us(1'000'000);
  int64_t id_ = 0;
  PanTiltState head_;
};

sim::Tour tour_of(std::vector<sim::TourStep> steps) {
  sim::Tour tour;
  tour.steps = std::move(steps);
  return tour;
}
sim::TourStep go(double x, double y) {
  sim::TourStep step;
  step.to_m = {x, y};
  return step;
}

TEST(TourRunner, GoesFromPointToPoint) {
  sim::TourStep face;
  face.kind = "face";
  face.heading_deg = 45.0;
  TourRunner runner(tour_of({go(2.5, 0.0), go(2.5, -1.5), face}), {});
  ObedientRobot robot(runner);
  robot.run(200);
  EXPECT_EQ(runner.outcome(), TourRunner::Outcome::done);
  EXPECT_NEAR(robot.pose.x_m, 2.5, 0.12);
  EXPECT_NEAR(robot.pose.y_m, -1.5, 0.12);
  EXPECT_NEAR(rad_to_deg(robot.pose.theta_rad), 45.0, 3.0);
  EXPECT_GE(robot.moves, 7);  // in pieces of a metre, heading corrected between
  EXPECT_EQ(runner.progress(), 1.0);
}

TEST(TourRunner, SweepsAtEachPanAndLooksAheadAgain) {
  sim::TourStep sweep;
  sweep.kind = "sweep";
  sweep.pans_deg = {0.0, 90.0};
  TourRunner runner(tour_of({sweep}), {});
  ObedientRobot robot(runner);
  robot.run(400);
  EXPECT_EQ(runner.outcome(), TourRunner::Outcome::done);
  EXPECT_EQ(robot.gazes, 5);  // to the start and along, twice, and home
  EXPECT_NEAR(rad_to_deg(robot.highest_tilt), 45.0, 1e-9);
  EXPECT_NEAR(rad_to_deg(robot.fastest_tilt), 5.5, 1e-9);
}

TEST(TourRunner, GivesUpBeforeAnObstacle) {
  TourRunner runner(tour_of({go(2.0, 0.0)}), {});
  ObedientRobot robot(runner);
  robot.answer = Fate::refused;
  robot.run(400);
  EXPECT_EQ(runner.outcome(), TourRunner::Outcome::blocked);
  EXPECT_EQ(robot.moves, 4);  // once and three more times
}

TEST(TourRunner, ALostLinkEndsIt) {
  TourRunner runner(tour_of({go(20.0, 0.0)}), {});
  ObedientRobot robot(runner);
  robot.run(5);
  robot.speaks = false;
  robot.run(100);
  EXPECT_EQ(runner.outcome(), TourRunner::Outcome::lost);
  EXPECT_THAT(runner.state(), HasSubstr("base"));
  const auto orders = runner.stop(Utime::from_us(9'000'000));
  ASSERT_EQ(orders.base.size(), 1U);
  EXPECT_EQ(orders.base[0].kind, BaseCommand::Kind::stop);
  EXPECT_EQ(orders.pantilt.at(0).kind, PanTiltCommand::Kind::stop);
}

TEST(TourRunner, RefusesAStepItDoesNotKnow) {
  sim::TourStep step;
  step.kind = "fly";
  EXPECT_THAT([&] { TourRunner(tour_of({step}), {}); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("fly")));
}

}  // namespace
}  // namespace marco::teleop
