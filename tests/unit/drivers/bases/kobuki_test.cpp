#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "driven_base.hpp"
#include "drivers/kobuki/driver.hpp"
#include "simulator/devices/kobuki/emulator.hpp"

namespace marco::drivers::kobuki {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Fate = BaseStatus::Command;
using Link = BaseStatus::Link;

// The vectors were computed from the protocol's description by another program.
TEST(KobukiCodec, Orders) {
  EXPECT_EQ(velocity_request(0.2, 0.0),
            (Bytes{0xAA, 0x55, 0x06, 0x01, 0x04, 0xC8, 0x00, 0x00, 0x00, 0xCB}));
  EXPECT_EQ(velocity_request(0.0, 1.0),
            (Bytes{0xAA, 0x55, 0x06, 0x01, 0x04, 0x73, 0x00, 0x01, 0x00, 0x71}));
  EXPECT_EQ(version_request(), (Bytes{0xAA, 0x55, 0x04, 0x09, 0x02, 0x0B, 0x00, 0x04}));
}

TEST(KobukiCodec, Feedback) {
  Bytes frame{0xAA, 0x55, 0x4D, 0x01, 0x0F, 0xE8, 0x03, 0x04, 0x00, 0x00, 0xFA, 0xFF, 0x14,
              0x00, 0x0A, 0xF6, 0x00, 0x06, 0xA5, 0x00, 0x03, 0x03, 0x00, 0x00, 0x00, 0x04,
              0x07, 0xD8, 0xDC, 0x64, 0x00, 0x00, 0x00, 0x00, 0x05, 0x06, 0xE8, 0x03, 0xE9,
              0x03, 0xEA, 0x03, 0x06, 0x02, 0x01, 0x02, 0x0D, 0x0E, 0x05, 0x06, 0x00, 0x00,
              0x00, 0x00, 0x64, 0x00, 0x00, 0x00, 0x00, 0x00, 0x64, 0x00, 0x10, 0x10};
  frame.resize(frame.size() + 16);
  frame.push_back(0x6D);
  FrameParser parser;
  parser.push(frame);
  const auto received = parser.next();
  ASSERT_TRUE(received);
  const auto said = decode_feedback(received->payload);
  ASSERT_TRUE(said);
  EXPECT_EQ(said->clock_ms, 1000);
  EXPECT_EQ(said->bumpers, kLeft);
  EXPECT_EQ(said->left_ticks, 65530);
  EXPECT_EQ(said->right_ticks, 20);
  EXPECT_EQ(said->charger, 6);
  EXPECT_FALSE(said->on_cable());
  EXPECT_EQ(said->decivolts, 165);
  EXPECT_EQ(said->heading_cdeg, -9000);
  EXPECT_EQ(said->rate_cdeg_per_s, 100);
  ASSERT_EQ(said->gyro.size(), 2u);
  EXPECT_EQ(said->gyro[1], (std::array<int16_t, 3>{0, 0, 100}));
  EXPECT_EQ(parser.garbage_bytes(), 0);
}

TEST(KobukiCodec, PartsThatAreCutOffOrOfAnImpossibleSizeAreRefused) {
  const Bytes frame = encode_frame({});
  const Bytes payload(frame.begin() + 3, frame.end() - 1);
  ASSERT_TRUE(decode_feedback(payload));
  for (std::size_t size = 0; size < payload.size(); ++size) {
    // Up to the end of a part it is whole.
    EXPECT_EQ(decode_feedback(std::span(payload).first(size)).has_value(), size == 17) << size;
  }
  Bytes unknown = payload;
  unknown.insert(unknown.end(), {0x77, 2, 1, 2});
  EXPECT_TRUE(decode_feedback(unknown));
  unknown.insert(unknown.end(), {0x0D, 3, 0, 3, 1});  // half a reading of the gyro
  EXPECT_FALSE(decode_feedback(unknown));
}

TEST(KobukiCodec, AnOrderIsReadAsItWasGiven) {
  for (double v = -0.6; v < 0.65; v += 0.1) {
    for (double w = -2.0; w < 2.05; w += 0.25) {
      const Bytes frame = velocity_request(v, w);
      const auto order = decode_order(std::span(frame).subspan(3, frame[2]));
      ASSERT_TRUE(order && order->velocity_m_per_s);
      EXPECT_NEAR(*order->velocity_m_per_s, v, 0.002) << v << " " << w;
      EXPECT_NEAR(order->yaw_rate_rad_per_s, w, 0.006) << v << " " << w;
    }
  }
}

TEST(KobukiCodec, FramesAreFoundHoweverTheyAreSplitAndAfterDamage) {
  std::mt19937 random(4);
  for (int round = 0; round < 200; ++round) {
    Bytes stream;
    const int hurt = static_cast<int>(random() % 8);
    for (int i = 0; i < 10; ++i) {
      Feedback told;
      told.left_ticks = 0x55AA;  // a head in the data
      told.right_ticks = static_cast<uint16_t>(i);
      Bytes frame = encode_frame(told);
      if (i == hurt) frame.erase(frame.begin() + static_cast<int>(random() % frame.size()));
      stream.insert(stream.end(), frame.begin(), frame.end());
    }
    FrameParser parser;
    std::vector<int> got;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t count = std::min<std::size_t>(1 + random() % 30, stream.size() - at);
      parser.push(std::span<const uint8_t>(stream).subspan(at, count));
      at += count;
      while (const auto received = parser.next()) {
        if (const auto told = decode_feedback(received->payload)) got.push_back(told->right_ticks);
      }
    }
    // The hurt one is lost; one whose length was lost takes what it announces with it.
    EXPECT_GE(got.size(), 8u);
    EXPECT_TRUE(std::is_sorted(got.begin(), got.end()));
    EXPECT_EQ(std::count(got.begin(), got.end(), hurt), 0);
  }
}

struct KobukiParts {
  explicit KobukiParts(const KobukiEmulatorOptions& device)
      : robot(device, [this] { return touch; }), driver(KobukiOptions{}) {}
  KobukiWorld touch;
  KobukiEmulator robot;
  KobukiBase driver;
};
struct Turtle : KobukiParts, testing::DrivenBase<KobukiBase> {
  explicit Turtle(const KobukiEmulatorOptions& device = {})
      : KobukiParts(device), DrivenBase(driver, robot, kBaud) {}
  double moved_m() const { return (robot.left_m() + robot.right_m()) / 2.0; }
  double turned_rad() const { return (robot.right_m() - robot.left_m()) / kTrackM; }
  bool stands() const { return robot.left_m_per_s() == 0.0 && robot.right_m_per_s() == 0.0; }
};

TEST(KobukiDriver, MovesTurnsAndReckonsOverTheCountersWrap) {
  Turtle turtle;
  EXPECT_EQ(turtle.driver.status().battery_v, std::vector<double>{16.5});
  EXPECT_THAT(turtle.driver.status().note, HasSubstr("firmware 1.2.0"));
  EXPECT_EQ(turtle.move(1.0), Fate::done);
  EXPECT_NEAR(turtle.moved_m(), 1.0, 0.01);
  EXPECT_EQ(turtle.turn(deg_to_rad(90.0)), Fate::done);
  EXPECT_NEAR(rad_to_deg(turtle.turned_rad()), 90.0, 2.0);
  EXPECT_EQ(turtle.move(-1.5), Fate::done);
  const Pose2& pose = turtle.driver.odom_from_robot();
  EXPECT_NEAR(pose.y_m, -1.5, 0.03);
  EXPECT_NEAR(normalize_angle(pose.theta_rad - turtle.turned_rad()), 0.0, 0.002);
  // 5.6 m are 65536 ticks.
  EXPECT_EQ(turtle.move(13.0, 200.0), Fate::done);
  EXPECT_NEAR(turtle.moved_m(), 12.5, 0.03);
  EXPECT_NEAR(pose.y_m, 11.5, 0.4);
  EXPECT_EQ(turtle.driver.bad_input(), 0);
  for (std::size_t i = 1; i < turtle.odometry.size(); ++i) {
    EXPECT_GT(turtle.odometry[i].utime, turtle.odometry[i - 1].utime);
  }
}

TEST(KobukiDriver, ItsGyroIsPublishedInTheRobotsFrame) {
  KobukiEmulatorOptions device;
  device.gyro_bias_deg_per_s = 0.5;
  Turtle turtle(device);
  const std::vector<ImuSample>& heard = turtle.imu;
  turtle.velocity(0.0, 0.8);
  turtle.bench.run(0.45);
  turtle.velocity(0.0, 0.8);
  turtle.bench.run(0.45);
  turtle.velocity(0.0, 0.8);
  turtle.bench.run(0.45);
  ASSERT_GT(heard.size(), 55u);  // 50 a second
  EXPECT_NEAR(heard.back().angular_velocity_rad_per_s.z(), 0.8 + deg_to_rad(0.5), 0.02);
  EXPECT_DOUBLE_EQ(heard.back().angular_velocity_rad_per_s.x(), 0.0);

  KobukiBase driver({});
  const Utime now = Utime::from_us(1'700'000'000'000'000);
  driver.on_connection(true, now);
  Feedback told;
  told.gyro = {{100, 0, 0}, {100, 200, 0}};  // its x points left, its y backwards
  driver.receive(encode_frame(told), now);
  const auto imu = driver.take_output().imu;
  ASSERT_EQ(imu.size(), 1u);
  EXPECT_TRUE(imu[0].angular_velocity_rad_per_s.isApprox(deg_to_rad(0.00875) *
                                                         Eigen::Vector3d(-100, 100, 0)));
}

// Its firmware lets it fall; a driver that only tells would be too late.
TEST(KobukiDriver, ACliffALiftedWheelOrACableEndsTheOrder) {
  for (uint8_t KobukiWorld::*danger :
       {&KobukiWorld::cliffs, &KobukiWorld::hanging_wheels, &KobukiWorld::charger}) {
    Turtle turtle;
    turtle.begin_move(2.0);
    turtle.bench.run(1.5);
    EXPECT_FALSE(turtle.stands());
    const double at_m = turtle.moved_m();
    turtle.touch.*danger = 0x12;  // a cable; in the others the middle or the left one
    turtle.bench.run(0.6);
    EXPECT_TRUE(turtle.stands());
    EXPECT_LT(turtle.moved_m() - at_m, 0.05);
    EXPECT_EQ(turtle.driver.status().link, Link::starting);
    EXPECT_EQ(turtle.driver.status().command, Fate::aborted);
    EXPECT_EQ(turtle.move(0.2), Fate::refused);
    turtle.touch.*danger = 0;
    EXPECT_TRUE(turtle.comes_up(0.5));
    turtle.bench.run(1.0);
    EXPECT_TRUE(turtle.stands());  // nothing resumes
    EXPECT_EQ(turtle.move(0.2), Fate::done);
  }
  Turtle docked;
  docked.touch.charger = 6;  // it must be able to leave its dock
  EXPECT_EQ(docked.move(-0.2), Fate::done);
}

TEST(KobukiDriver, ABumperStopsIt) {
  Turtle turtle;
  turtle.begin_move(2.0);
  turtle.bench.run(1.5);
  turtle.touch.bumpers = kRight;
  turtle.bench.run(0.6);
  EXPECT_TRUE(turtle.stands());
  EXPECT_EQ(turtle.driver.status().bumpers, (std::vector<bool>{false, false, true}));
}

TEST(KobukiDriver, SwitchedOffAndOnItReckonsOn) {
  Turtle turtle;
  EXPECT_EQ(turtle.move(1.0), Fate::done);
  turtle.robot.reset(turtle.bench.now());
  turtle.bench.run(0.7);
  EXPECT_EQ(turtle.driver.status().link, Link::down);
  EXPECT_THAT(turtle.driver.status().note, StartsWith("the robot is silent"));
  EXPECT_TRUE(turtle.comes_up(1.0));
  EXPECT_NEAR(turtle.driver.odom_from_robot().x_m, turtle.moved_m(), 0.002);
  EXPECT_EQ(turtle.move(0.5), Fate::done);
  EXPECT_NEAR(turtle.driver.odom_from_robot().x_m, turtle.moved_m(), 0.002);
  EXPECT_NEAR(turtle.moved_m(), 1.5, 0.02);
}

// So short that no silence is noticed: its clock says it.
TEST(KobukiDriver, AShortBrownOutCostsNoWay) {
  KobukiEmulatorOptions device;
  device.boot_s = 0.2;
  Turtle turtle(device);
  EXPECT_EQ(turtle.move(1.0), Fate::done);
  turtle.robot.reset(turtle.bench.now());
  turtle.bench.run(0.7);
  EXPECT_EQ(turtle.driver.status().link, Link::up);
  EXPECT_NEAR(turtle.driver.odom_from_robot().x_m, turtle.moved_m(), 0.002);
  EXPECT_EQ(turtle.move(0.5), Fate::done);
  EXPECT_NEAR(turtle.driver.odom_from_robot().x_m, turtle.moved_m(), 0.002);
  EXPECT_NEAR(turtle.moved_m(), 1.5, 0.02);
}

// Perhaps it has no watchdog: the driver's last words must stop it.
TEST(KobukiDriver, LeavesAStandingRobot) {
  Turtle turtle;
  turtle.velocity(0.2, 0.0);
  turtle.bench.run(0.4);
  EXPECT_FALSE(turtle.stands());
  Bytes last;
  turtle.driver.shut_down(last);
  turtle.robot.receive(last, kBaud, turtle.bench.now());
  turtle.bench.frozen = true;
  turtle.bench.run(0.7);
  EXPECT_TRUE(turtle.stands());
}

}  // namespace
}  // namespace marco::drivers::kobuki
