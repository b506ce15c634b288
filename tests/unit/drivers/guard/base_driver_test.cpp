// The life of an order, and the statuses that report it.
#include "drivers/base/base_driver.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plain_base.hpp"
#include "tests/support/matchers.hpp"

namespace marco::drivers {
namespace {

using ::marco::testing::IsNear;
using ::testing::EndsWith;
using ::testing::StartsWith;
using Fate = BaseStatus::Command;
using Kind = BaseCommand::Kind;

class OpenBase : public testing::PlainBase {
 public:
  explicit OpenBase(const GuardOptions& guard) : PlainBase(guard, 0.1) {}
  using BaseDriver::edit_status, BaseDriver::set_link, BaseDriver::speeds;
  int speeds_changed_times = 0;

 private:
  void speeds_changed() override { ++speeds_changed_times; }
};

class OrderLife : public ::testing::Test {
 protected:
  void begin(bool guarded = false) {
    GuardOptions options;
    options.enabled = guarded;
    base_.emplace(options);
    base_->on_connection(true, now_);
    collect_statuses();
  }
  void collect_statuses() {
    for (const BaseStatus& status : base_->take_output().status) statuses_.push_back(status);
  }
  void run(double seconds) {
    for (const Utime end = now_ + Duration::from_seconds(seconds - 1e-6); now_ < end;) {
      for (int i = 0; i < 4; ++i) {
        now_ = now_ + Duration::from_seconds(0.005);
        base_->roll(0.005, now_);
      }
      std::vector<uint8_t> nowhere;
      base_->advance(now_, nowhere);
      collect_statuses();
    }
  }
  BaseCommand command(Kind kind, double amount = 0.0, double age_s = 0.0) {
    BaseCommand command;
    command.utime = now_ - Duration::from_seconds(age_s);
    command.kind = kind;
    command.id = ++id_;
    command.distance_m = command.angle_rad = command.velocity_m_per_s = amount;
    return command;
  }
  int64_t give(const BaseCommand& command) {
    base_->command(command, now_);
    collect_statuses();
    return command.id;
  }
  int64_t give(Kind kind, double amount = 0.0, double age_s = 0.0) {
    return give(command(kind, amount, age_s));
  }
  const BaseStatus& last() const { return statuses_.back(); }
  const Pose2& pose() const { return base_->world_from_robot; }

  std::optional<OpenBase> base_;
  std::vector<BaseStatus> statuses_;
  Utime now_ = Utime::from_seconds(1000.0);
  int64_t id_ = 40;
};

TEST_F(OrderLife, IsToldAtItsBeginAndItsEndAndEveryHalfSecond) {
  begin();
  ASSERT_EQ(statuses_.size(), 1U);
  EXPECT_EQ(last().base, "plain");
  EXPECT_EQ(last().link, BaseStatus::Link::up);
  EXPECT_EQ(last().utime, now_);
  run(4.0);
  EXPECT_NEAR(static_cast<double>(statuses_.size()), 9.0, 1.0);
  EXPECT_EQ(last().command, Fate::none);
  const int64_t id = give(Kind::move, 0.3);
  EXPECT_EQ(last().command_id, id);
  EXPECT_EQ(last().command, Fate::running);
  EXPECT_EQ(last().utime, now_);
  EXPECT_EQ(base_->state(), "plain ready, moving: guard: off");
  while (last().command == Fate::running && now_ < Utime::from_seconds(1030.0)) run(0.02);
  EXPECT_EQ(last().command, Fate::done);
  EXPECT_EQ(last().command_id, id);
  EXPECT_EQ(last().utime, now_);
  EXPECT_EQ(last().note, "guard: off");
  EXPECT_NEAR(pose().x_m, 0.3, 0.01);
}

TEST_F(OrderLife, AChangedLinkOrNoteIsToldAndAnUnchangedOneNot) {
  begin();
  base_->set_link(BaseStatus::Link::up, "", now_);
  collect_statuses();
  EXPECT_EQ(statuses_.size(), 1U);
  base_->set_link(BaseStatus::Link::up, "battery low", now_);
  collect_statuses();
  ASSERT_EQ(statuses_.size(), 2U);
  EXPECT_EQ(last().note, "battery low; guard: off");
  base_->edit_status().motors_on = true;
  base_->set_link(BaseStatus::Link::starting, "battery low", now_);
  collect_statuses();
  ASSERT_EQ(statuses_.size(), 3U);
  EXPECT_EQ(last().link, BaseStatus::Link::starting);
  EXPECT_FALSE(last().motors_on);
  EXPECT_EQ(base_->state(), "plain is being set up: battery low; guard: off");
  give(Kind::move, 0.3);
  EXPECT_EQ(last().command, Fate::refused);
  EXPECT_THAT(last().note, StartsWith("the base does not answer"));
}

TEST_F(OrderLife, ALostLineAbortsItAndWhatWaitsIsForgotten) {
  begin();
  const int64_t move = give(Kind::move, 2.0);
  run(1.0);
  give(Kind::turn, 1.0);  // waits for the move's end
  base_->set_link(BaseStatus::Link::down, "the line is gone", now_);
  collect_statuses();
  EXPECT_EQ(last().link, BaseStatus::Link::down);
  EXPECT_EQ(last().command, Fate::aborted);
  EXPECT_EQ(last().command_id, move);
  EXPECT_THAT(last().note, StartsWith("the line is gone"));
  run(3.0);
  base_->set_link(BaseStatus::Link::up, "", now_);
  give(Kind::stop);
  run(3.0);
  EXPECT_NEAR(pose().theta_rad, 0.0, 1e-9);
  EXPECT_EQ(last().command, Fate::done);
}

TEST_F(OrderLife, SpeedsThatAreSetHoldAndZeroLeavesThemAsTheyAre) {
  begin();
  BaseCommand speed = command(Kind::set_speed);
  speed.max_velocity_m_per_s = 0.2;
  give(speed);
  EXPECT_EQ(last().command, Fate::done);
  EXPECT_EQ(last().command_id, speed.id);
  EXPECT_EQ(base_->speeds().velocity_m_per_s, 0.2);
  EXPECT_EQ(base_->speeds().yaw_rate_rad_per_s, 1.2);
  EXPECT_EQ(base_->speeds().acceleration_m_per_s2, 0.3);
  EXPECT_EQ(base_->speeds_changed_times, 1);
  const int64_t move = give(Kind::move, 1.0);
  run(1.0);
  speed.max_velocity_m_per_s = 0.0;
  speed.max_yaw_rate_rad_per_s = 0.5;
  speed.acceleration_m_per_s2 = 0.1;
  speed.utime = now_;
  give(speed);
  EXPECT_EQ(base_->status().command, Fate::running) << "that of the running order";
  EXPECT_EQ(base_->status().command_id, move);
  EXPECT_EQ(base_->speeds().velocity_m_per_s, 0.2);
  EXPECT_EQ(base_->speeds().yaw_rate_rad_per_s, 0.5);
  EXPECT_EQ(base_->speeds().acceleration_m_per_s2, 0.1);
  run(8.0);
  BaseCommand fast = command(Kind::velocity, -0.8);
  fast.yaw_rate_rad_per_s = 1.0;
  give(fast);
  run(0.1);
  EXPECT_EQ(base_->told(), (BaseVelocity{-0.2, 0.5})) << "no velocity exceeds them";
}

TEST_F(OrderLife, ARefusedOneIsAnsweredOnceAndTheRunningOneStays) {
  begin();
  const int64_t move = give(Kind::move, 2.0);
  run(0.5);
  const std::size_t before = statuses_.size();
  const int64_t stale = give(Kind::turn, 1.0, 3.0);
  ASSERT_EQ(statuses_.size(), before + 1);
  EXPECT_EQ(last().command_id, stale);
  EXPECT_EQ(last().command, Fate::refused);
  EXPECT_THAT(last().note, StartsWith("order is 3.0 s old"));
  EXPECT_EQ(base_->status().command_id, move);
  EXPECT_EQ(base_->status().command, Fate::running);
  EXPECT_EQ(base_->status().note, "guard: off");
  run(1.0);
  EXPECT_GT(base_->velocity().ahead_m_per_s, 0.2);
}

TEST_F(OrderLife, ANewerOneAbortsTheRunningOneAndFollowsWhenItStands) {
  begin();
  const int64_t move = give(Kind::move, 2.0);
  run(1.0);
  const int64_t turn = give(Kind::turn, 0.5);
  EXPECT_EQ(base_->status().command_id, move);
  run(3.0);
  const auto aborted =
      std::find_if(statuses_.begin(), statuses_.end(),
                   [](const BaseStatus& status) { return status.command == Fate::aborted; });
  ASSERT_NE(aborted, statuses_.end());
  EXPECT_EQ(aborted->command_id, move);
  EXPECT_THAT(aborted->note, StartsWith("a newer order came"));
  EXPECT_EQ(last().command_id, turn);
  EXPECT_EQ(last().command, Fate::done);
  EXPECT_NEAR(pose().theta_rad, 0.5, 0.01);
  EXPECT_LT(pose().x_m, 0.5);
}

TEST_F(OrderLife, VelocitiesThatFollowEachOtherAreOneAndLapseAfterHalfASecond) {
  begin();
  int64_t id = 0;
  for (int i = 0; i < 10; ++i) {
    id = give(Kind::velocity, i < 5 ? 0.2 : 0.3);
    run(0.4);
    EXPECT_EQ(base_->status().command, Fate::running);
    EXPECT_EQ(base_->status().command_id, id);
  }
  EXPECT_NEAR(base_->velocity().ahead_m_per_s, 0.3, 1e-9);
  run(0.2);
  EXPECT_TRUE(base_->told().is_zero());
  run(2.0);
  EXPECT_EQ(last().command, Fate::done);
  EXPECT_EQ(last().command_id, id);
  EXPECT_THAT(last().note, StartsWith("no velocity came for 0.5 s"));
}

TEST_F(OrderLife, APointIsTurnedToAndMovedTo) {
  begin();
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(-0.3, 0.1)}) {
    BaseCommand go = command(Kind::go_to);
    go.point_m = point;
    give(go);
    run(15.0);
    EXPECT_EQ(last().command, Fate::done);
    EXPECT_LT((pose().translation_m() - point).norm(), 0.02);
  }
  const Pose2 before = pose();
  BaseCommand stay = command(Kind::go_to);
  stay.point_m = before * Eigen::Vector2d(-0.001, 0.002);
  give(stay);
  run(1.0);
  EXPECT_EQ(last().command, Fate::done);
  EXPECT_THAT(pose(), IsNear(before, 1e-9, 1e-9)) << "it is there";
}

TEST_F(OrderLife, LegsTooShortToDriveAreDoneAtOnce) {
  const auto fate_of = [&](Kind kind, double amount) {
    begin();
    give(kind, amount);
    run(0.02);
    EXPECT_EQ(base_->told().is_zero(), last().command == Fate::done);
    return last().command;
  };
  EXPECT_EQ(fate_of(Kind::move, 0.004), Fate::done);
  EXPECT_EQ(fate_of(Kind::move, -0.008), Fate::running);
  EXPECT_EQ(fate_of(Kind::turn, deg_to_rad(-0.2)), Fate::done);
  EXPECT_EQ(fate_of(Kind::turn, deg_to_rad(0.5)), Fate::running);
}

TEST_F(OrderLife, AnEmergencyStopIsToldAtOnceAndKeepsTheFateOfWhatWasDone) {
  begin();
  give(Kind::move, 0.1);
  run(3.0);
  ASSERT_EQ(last().command, Fate::done);
  base_->emergency_stop({now_, true, "sheriff", "a child"}, now_);
  collect_statuses();
  EXPECT_EQ(last().note, "emergency stop by sheriff: a child; guard: off");
  run(1.0);
  EXPECT_EQ(last().command, Fate::done);
  base_->emergency_stop({now_, false, "sheriff", ""}, now_);
  collect_statuses();
  EXPECT_EQ(last().note, "the emergency stop was released; guard: off");
  give(Kind::move, 2.0);
  run(1.0);
  base_->emergency_stop({now_, true, "sheriff", ""}, now_);
  run(2.0);
  EXPECT_EQ(last().command, Fate::aborted);
}

TEST_F(OrderLife, WithoutALineAnEmergencyStopIsToldAsWell) {
  begin();
  base_->set_link(BaseStatus::Link::down, "the line is gone", now_);
  base_->emergency_stop({now_, true, "sheriff", ""}, now_);
  collect_statuses();
  EXPECT_EQ(last().note, "emergency stop by sheriff; guard: off");
  EXPECT_EQ(base_->state(), "plain does not answer: emergency stop by sheriff; guard: off");
}

TEST_F(OrderLife, AHangIsToldAtOnceAndNothingResumes) {
  begin();
  give(Kind::move, 2.0);
  run(1.0);
  base_->on_hang(1.5, now_);
  collect_statuses();
  EXPECT_THAT(last().note, StartsWith("the driver hung for 1.5 s: stopped"));
  EXPECT_TRUE(base_->told().is_zero());
  run(3.0);
  EXPECT_EQ(last().command, Fate::aborted);
  EXPECT_LT(pose().x_m, 0.5);
}

// No sensor: the guard limits legs to 0.2 m/s, of the fastest point.
TEST_F(OrderLife, LegsAreAsSlowAsTheGuardWantsAndVelocitiesThenAsFastAsTheBaseIs) {
  begin(true);
  const double radius_m = base_->guard().radius_m();
  give(Kind::move, 1.0);
  run(0.1);
  EXPECT_EQ(base_->speeds().velocity_m_per_s, 0.2);
  EXPECT_NEAR(base_->speeds().yaw_rate_rad_per_s, 0.2 / radius_m, 1e-12);
  EXPECT_EQ(base_->speeds_changed_times, 1);
  run(10.0);
  EXPECT_EQ(last().command, Fate::done);
  EXPECT_THAT(last().note, EndsWith("guard: at most 0.2 m/s: no laser or sonar data"));
  give(Kind::move, -0.5);
  run(6.0);
  EXPECT_EQ(base_->speeds_changed_times, 1) << "they are the same";
  give(Kind::velocity, 0.1);
  EXPECT_EQ(base_->speeds().velocity_m_per_s, 0.8);
  EXPECT_EQ(base_->speeds_changed_times, 2);
}

class Gate : public ::testing::Test {
 protected:
  std::string why(Kind kind, double value) const {
    BaseCommand order;
    order.utime = now_;
    order.kind = kind;
    order.distance_m = order.angle_rad = order.velocity_m_per_s = value;
    order.point_m = {0.0, value};
    order.acceleration_m_per_s2 = value;
    return gate_.why_refused(order, now_);
  }
  EmergencyStop stop(bool engaged, double later_s) const {
    return {now_ + Duration::from_seconds(later_s), engaged, "sheriff", ""};
  }
  bool receive(const EmergencyStop& message) { return gate_.on_emergency_stop(message, now_); }
  OrderGate gate_;
  Utime now_ = Utime::from_seconds(1000.0);
};

TEST_F(Gate, WhatNoRobotDrivesIsRefused) {
  struct Case {
    Kind kind;
    double most;
  };
  for (const auto& [kind, most] :
       {Case{Kind::velocity, 10.0}, Case{Kind::move, 1000.0}, Case{Kind::turn, 100.0},
        Case{Kind::go_to, 1000.0}, Case{Kind::set_speed, 100.0}}) {
    EXPECT_EQ(why(kind, -0.9 * most), "");
    EXPECT_THAT(why(kind, 1.1 * most), StartsWith("impossible for a robot"));
  }
  BaseCommand order;
  order.utime = now_;
  order.kind = Kind::velocity;
  order.yaw_rate_rad_per_s = 25.0;
  EXPECT_THAT(gate_.why_refused(order, now_), StartsWith("impossible for a robot"));
  order.yaw_rate_rad_per_s = 15.0;
  EXPECT_EQ(gate_.why_refused(order, now_), "");
  EXPECT_EQ(why(Kind::forget_sensors, 1e9), "");
  EXPECT_THAT(why(static_cast<Kind>(99), 0.0), StartsWith("impossible")) << "of a newer sender";
}

TEST_F(Gate, WhileItIsStoppedSpeedsMayBeSetAndSensorsForgotten) {
  receive(stop(true, 0.0));
  EXPECT_THAT(why(Kind::move, 0.1), StartsWith("orders to move are refused until"));
  EXPECT_EQ(why(Kind::set_speed, 0.1), "");
  EXPECT_EQ(why(Kind::forget_sensors, 0.0), "");
  EXPECT_EQ(why(Kind::stop, 0.0), "");
}

TEST_F(Gate, EveryStopThatWasReleasedStaysReleased) {
  EXPECT_FALSE(receive(stop(false, 0.0))) << "none is latched";
  EXPECT_TRUE(receive(stop(true, -2.0)));
  EXPECT_FALSE(receive(stop(true, -2.0))) << "the same again";
  EXPECT_FALSE(receive(stop(true, -1.0))) << "it says no more than the other";
  EXPECT_TRUE(receive(stop(false, -1.5))) << "older: ignored, and said";
  EXPECT_THAT(gate_.note(), EndsWith("; a release by sheriff is older: ignored"));
  EXPECT_TRUE(receive(stop(true, -1.0))) << "pressed again";
  EXPECT_EQ(gate_.note(), "emergency stop by sheriff");
  EXPECT_TRUE(receive(stop(false, -1.0))) << "as old is not older";
  EXPECT_FALSE(gate_.stopped());
  for (const double late_s : {-2.0, -1.0}) {
    EXPECT_FALSE(receive(stop(true, late_s)));
    EXPECT_FALSE(gate_.stopped());
  }
  EXPECT_TRUE(receive(stop(true, -0.5)));
  EXPECT_TRUE(gate_.stopped());
}

}  // namespace
}  // namespace marco::drivers
