// A base of two wheels, as its drivers share it: wheels that obey at once, or do not turn.
#include "drivers/base/differential_base.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"

namespace marco::drivers {
namespace {

using ::marco::testing::IsNear;

GuardOptions no_guard() {
  GuardOptions options;
  options.enabled = false;
  return options;
}

class TwoWheels : public DifferentialBase {
 public:
  static constexpr double kTickM = 0.0005, kTrackM = 0.3;
  explicit TwoWheels(const GuardOptions& guard = no_guard())
      : DifferentialBase("wheels", {0.4, 0.8, 0.3}, guard, kTickM, kTrackM) {}

  void on_connection(bool connected, Utime now) override {
    begin_session(now);
    note_line(connected, "a sign", now);
  }
  void receive(std::span<const uint8_t>, Utime) override {}
  std::vector<uint8_t> stop_bytes() const override { return {}; }
  int64_t bad_input() const override { return 0; }
  using DifferentialBase::ask_is_due, DifferentialBase::ask_later, DifferentialBase::follow_leg,
      DifferentialBase::judge_link, DifferentialBase::note_sign_of_life,
      DifferentialBase::silent_for, DifferentialBase::touched, DifferentialBase::turned;

  double left_m_per_s = 0.0, right_m_per_s = 0.0;  ///< as ordered
  int times_due = 0;
  std::vector<int> due_steps;
  int steps = 0;

 private:
  void keep_link(Utime, std::vector<uint8_t>&) override {}
  bool takes_speeds() const override { return true; }
  void send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>&) override {
    ++steps;
    if (!due) return;
    due_steps.push_back(steps);
    left_m_per_s = speeds.left_m_per_s;
    right_m_per_s = speeds.right_m_per_s;
  }
};

class WheeledBase : public ::testing::Test {
 protected:
  WheeledBase() {
    base_.on_connection(true, now_);
    base_.judge_link("", "", now_);
  }
  /// Steps of 10 ms; the wheels are counted at each second one.
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / 0.01)); ++i) step();
  }
  void step() {
    now_ = now_ + Duration::from_seconds(0.01);
    if (!blocked_) {
      left_ += 0.01 * base_.left_m_per_s / TwoWheels::kTickM;
      right_ += 0.01 * base_.right_m_per_s / TwoWheels::kTickM;
    }
    if (++count_ % 2 == 0) {
      const double left = std::trunc(left_), right = std::trunc(right_);
      left_ -= left;
      right_ -= right;
      way_m_ += TwoWheels::kTickM * (left + right) / 2.0;
      if (spins_free_) base_.turned({left + 1.0, right, 0.0, 0.0}, now_, now_);
      if (!spins_free_) base_.turned({left, right, left / 40.0, right / 40.0}, now_, now_);
      base_.follow_leg(now_);
    }
    std::vector<uint8_t> nowhere;
    base_.advance(now_, nowhere);
  }
  void order(BaseCommand::Kind kind, double amount, double rate = 0.0) {
    BaseCommand command;
    command.utime = now_;
    command.kind = kind;
    command.id = ++id_;
    command.distance_m = command.angle_rad = command.velocity_m_per_s = amount;
    command.yaw_rate_rad_per_s = rate;
    base_.command(command, now_);
  }
  void drive(double seconds, double v, double w) {
    for (double t_s = 0.0; t_s < seconds - 1e-9; t_s += 0.1) {
      order(BaseCommand::Kind::velocity, v, w);
      run(0.1);
    }
  }
  BaseStatus::Command fate() const { return base_.status().command; }
  double run_until_ended(double limit_s) {
    double took_s = 0.0;
    for (; took_s < limit_s && fate() == BaseStatus::Command::running; took_s += 0.01) step();
    return took_s;
  }

  TwoWheels base_;
  Utime now_ = Utime::from_seconds(1000.0);
  bool blocked_ = false, spins_free_ = false;
  double left_ = 0.0, right_ = 0.0, way_m_ = 0.0;
  int count_ = 0;
  int64_t id_ = 0;
};

TEST_F(WheeledBase, LegsEndWhereTheyWereOrdered) {
  for (const double amount : {0.5, -0.3}) {
    const Pose2 before = base_.odom_from_robot();
    order(BaseCommand::Kind::move, amount);
    run_until_ended(10.0);
    EXPECT_EQ(fate(), BaseStatus::Command::done);
    EXPECT_THAT(between(before, base_.odom_from_robot()), IsNear(Pose2{amount, 0, 0}, 0.01, 1e-3));
  }
  // A turn and a half.
  const Pose2 before = base_.odom_from_robot();
  order(BaseCommand::Kind::turn, -3.0 * std::numbers::pi);
  EXPECT_NEAR(run_until_ended(60.0), 3.0 * std::numbers::pi / 0.8, 2.0);
  EXPECT_EQ(fate(), BaseStatus::Command::done);
  EXPECT_THAT(between(before, base_.odom_from_robot()),
              IsNear(Pose2{0, 0, std::numbers::pi}, 0.002, deg_to_rad(2.5)));
}

TEST_F(WheeledBase, ALegIsDoneWhenTheWheelsHaveStoodForFourCounts) {
  order(BaseCommand::Kind::move, 0.3);
  spins_free_ = true;  // one goes on by a tick at each count
  run_until_ended(10.0);
  EXPECT_EQ(fate(), BaseStatus::Command::running);
  EXPECT_EQ(base_.right_m_per_s, 0.0);
  spins_free_ = false;
  EXPECT_NEAR(run_until_ended(1.0), 4 * 0.02, 0.021);
  EXPECT_EQ(fate(), BaseStatus::Command::done);
}

TEST_F(WheeledBase, AStopIsDoneWhenTheWheelsHaveStoodForFourCounts) {
  drive(1.0, 0.2, 0.0);
  spins_free_ = true;
  order(BaseCommand::Kind::stop, 0.0);
  run(2.0);
  EXPECT_EQ(base_.left_m_per_s, 0.0);
  EXPECT_EQ(fate(), BaseStatus::Command::running);
  spins_free_ = false;
  EXPECT_NEAR(run_until_ended(1.0), 8 * 0.02, 0.021) << "the velocity, and then the stop";
  EXPECT_EQ(fate(), BaseStatus::Command::done);
}

TEST_F(WheeledBase, AMoveOfBlockedWheelsIsAbortedAfterASecond) {
  blocked_ = true;
  for (const auto kind : {BaseCommand::Kind::move, BaseCommand::Kind::turn}) {
    order(kind, 0.5);
    EXPECT_NEAR(run_until_ended(5.0), 1.1, 0.15);
    EXPECT_EQ(fate(), BaseStatus::Command::aborted);
    EXPECT_THAT(base_.status().note, ::testing::StartsWith("the wheels do not turn"));
    EXPECT_EQ(base_.right_m_per_s, 0.0);
  }
}

TEST_F(WheeledBase, SpeedsAreSentEveryFiftyMillisecondsAndRampUp) {
  drive(1.0, 0.4, 0.0);
  EXPECT_NEAR(static_cast<double>(base_.due_steps.size()), 20.0, 1.0);
  EXPECT_NEAR(base_.left_m_per_s, 0.3, 0.02);
  EXPECT_NEAR(base_.right_m_per_s, 0.3, 0.02);
  drive(1.0, 0.4, 0.0);
  EXPECT_NEAR(base_.left_m_per_s, 0.4, 1e-9);
  drive(0.2, 0.4, 0.8);  // the wheels' acceleration, at half their distance
  EXPECT_NEAR(base_.right_m_per_s - base_.left_m_per_s, 0.3 * 0.4, 0.03);
  drive(1.0, 0.4, 0.8);
  EXPECT_NEAR(base_.right_m_per_s, 0.4 + 0.8 * 0.15, 1e-9);
  EXPECT_NEAR(base_.left_m_per_s, 0.4 - 0.8 * 0.15, 1e-9);
}

TEST_F(WheeledBase, AnEmergencyStopIsSentAtTheNextStepAndWithoutARamp) {
  drive(1.03, 0.3, 0.0);
  for (int i = 0; base_.due_steps.back() != base_.steps && i < 5; ++i) step();
  ASSERT_GT(base_.left_m_per_s, 0.2);  // just sent: the next would come in 50 ms
  base_.emergency_stop({now_, true, "sheriff", ""}, now_);
  step();
  EXPECT_EQ(base_.left_m_per_s, 0.0);
  EXPECT_EQ(base_.right_m_per_s, 0.0);
  run(0.5);
  EXPECT_EQ(fate(), BaseStatus::Command::aborted);
}

TEST_F(WheeledBase, ABumperStopsWhatMovesAheadAtOnceAndATurnContinues) {
  drive(1.0, 0.3, 0.5);
  for (int i = 0; base_.due_steps.back() != base_.steps && i < 5; ++i) step();
  base_.touched({false, false, false}, now_);
  EXPECT_TRUE(base_.touched({false, false, true}, now_)) << "they changed";
  EXPECT_EQ(base_.status().bumpers, (std::vector<bool>{false, false, true}));
  EXPECT_FALSE(base_.touched({false, false, true}, now_));
  step();
  EXPECT_NEAR(base_.right_m_per_s + base_.left_m_per_s, 0.0, 0.05);
  EXPECT_GT(base_.right_m_per_s - base_.left_m_per_s, 0.1);
  EXPECT_TRUE(base_.touched({false, false, false}, now_));
}

TEST(BumpersOfTwoWheels, AreNamedFromTheLeft) {
  GuardOptions guard;
  TwoWheels base(guard);
  base.touched({true, false, true}, Utime::from_seconds(1000.0));
  EXPECT_EQ(base.guard().pressed_bumpers(1.0), "front bumpers 1 3 are pressed");
  EXPECT_EQ(base.guard().pressed_bumpers(-1.0), "");
  base.guard().on_bumpers({}, {2});
  EXPECT_EQ(base.guard().pressed_bumpers(-0.1), "rear bumper 2 is pressed");
  EXPECT_EQ(base.guard().pressed_bumpers(1.0), "");
  EXPECT_EQ(base.guard().pressed_bumpers(0.0), "");
}

TEST_F(WheeledBase, TheLinkIsUpWhileNothingIsUnsafe) {
  drive(0.5, 0.3, 0.0);
  EXPECT_FALSE(base_.judge_link("", "", now_)) << "as before";
  EXPECT_TRUE(base_.judge_link("a wheel hangs", "", now_)) << "it has just gone down";
  EXPECT_EQ(base_.status().link, BaseStatus::Link::starting);
  EXPECT_FALSE(base_.status().motors_on);
  EXPECT_THAT(base_.status().note, ::testing::StartsWith("a wheel hangs"));
  EXPECT_EQ(fate(), BaseStatus::Command::aborted);
  run(0.1);
  EXPECT_EQ(base_.left_m_per_s, 0.0);
  EXPECT_FALSE(base_.judge_link("", "by its own", now_));
  EXPECT_EQ(base_.status().link, BaseStatus::Link::up);
  EXPECT_TRUE(base_.status().motors_on);
  EXPECT_THAT(base_.status().note, ::testing::StartsWith("by its own"));
  run(1.0);
  EXPECT_EQ(base_.left_m_per_s, 0.0) << "nothing resumes";
}

TEST_F(WheeledBase, ALostLineIsToldAndNothingResumes) {
  drive(0.5, 0.3, 0.0);
  base_.on_connection(false, now_);
  EXPECT_EQ(base_.status().link, BaseStatus::Link::down);
  EXPECT_THAT(base_.status().note, ::testing::StartsWith("the line is gone"));
  EXPECT_EQ(fate(), BaseStatus::Command::aborted);
  const int steps = base_.steps;
  run(0.2);
  EXPECT_EQ(base_.steps, steps) << "nothing is sent";
  base_.on_connection(true, now_);
  EXPECT_THAT(base_.status().note, ::testing::StartsWith("waiting for a sign"));
  base_.judge_link("", "", now_);
  run(1.0);
  EXPECT_EQ(base_.left_m_per_s, 0.0);
}

TEST_F(WheeledBase, AsksOnceInSoLongAndKnowsWhenItHeardLast) {
  base_.on_connection(true, now_);
  EXPECT_TRUE(base_.ask_is_due(0.2, now_)) << "at once";
  const Utime asked = now_;
  const auto after = [&](double s) { return asked + Duration::from_seconds(s); };
  EXPECT_FALSE(base_.ask_is_due(0.2, after(0.1)));
  EXPECT_TRUE(base_.ask_is_due(0.2, after(0.2)));
  EXPECT_FALSE(base_.ask_is_due(0.2, after(0.3)));
  base_.ask_later(1.0, after(0.3));
  EXPECT_FALSE(base_.ask_is_due(0.2, after(1.2)));
  EXPECT_TRUE(base_.ask_is_due(0.2, after(1.3)));
  EXPECT_FALSE(base_.silent_for(0.5, after(0.4)));
  EXPECT_TRUE(base_.silent_for(0.5, after(0.6)));
  base_.note_sign_of_life(after(0.5));
  EXPECT_FALSE(base_.silent_for(0.5, after(0.9)));
}

}  // namespace
}  // namespace marco::drivers
