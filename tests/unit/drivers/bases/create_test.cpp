#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "driven_base.hpp"
#include "drivers/create/driver.hpp"
#include "simulator/devices/create/emulator.hpp"

namespace marco::drivers::create {
namespace {

using ::testing::HasSubstr;
using Fate = BaseStatus::Command;
using Link = BaseStatus::Link;

// iRobot's document, as it stands there; its 549 is a misprint of 537.
TEST(CreateCodec, DocumentsFrame) {
  const Bytes frame{0x13, 0x05, 0x1D, 0x02, 0x19, 0x0D, 0x00, 0xA3};
  unsigned sum = 0;
  for (const uint8_t byte : frame) sum += byte;
  EXPECT_EQ(sum % 256, 0u);
  EXPECT_FALSE(decode_frame(frame));  // right, and not what we asked for
}

TEST(CreateCodec, RequestsAndFrames) {
  EXPECT_EQ(drive_request(-100, 200), (Bytes{0x91, 0x00, 0xC8, 0xFF, 0x9C}));
  EXPECT_THROW(drive_request(501, 0), std::invalid_argument);
  EXPECT_EQ(stream_request(), (Bytes{0x94, 10, 7, 9, 10, 11, 12, 21, 22, 35, 43, 44}));
  // Left bump, -10 and 20 ticks, 15 V, full: the packets of a computed vector, with ours around.
  const Bytes frame{0x13, 0x17, 0x07, 0x02, 0x09, 0, 0x0A, 0,    0x0B, 1,    0x0C, 0,    0x15,
                    0x02, 0x16, 0x3A, 0x98, 0x23, 2, 0x2B, 0xFF, 0xF6, 0x2C, 0x00, 0x14, 0x1E};
  const auto sensors = decode_frame(frame);
  ASSERT_TRUE(sensors);
  EXPECT_TRUE(sensors->left_bump);
  EXPECT_FALSE(sensors->right_bump || sensors->wheel_drop());
  EXPECT_EQ(sensors->cliffs, (std::array<bool, 4>{false, false, true, false}));
  EXPECT_EQ(sensors->charging, 2);
  EXPECT_EQ(sensors->millivolts, 15'000);
  EXPECT_EQ(sensors->mode, 2);
  EXPECT_EQ(sensors->left_ticks, 0xFFF6);
  EXPECT_EQ(sensors->right_ticks, 20);
  EXPECT_EQ(encode_frame(*sensors), frame);
}

TEST(CreateCodec, FramesAreFoundHoweverTheyAreSplitAndAfterDamage) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    Bytes stream;
    const int hurt = static_cast<int>(random() % 8);
    for (int i = 0; i < 10; ++i) {
      Sensors sensors;
      sensors.left_ticks = static_cast<uint16_t>(0x1313 + i);  // the header's byte in the data
      Bytes frame = encode_frame(sensors);
      if (i == hurt) frame.erase(frame.begin() + static_cast<int>(random() % frame.size()));
      stream.insert(stream.end(), frame.begin(), frame.end());
    }
    FrameParser parser;
    std::vector<int> got;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t count = std::min<std::size_t>(1 + random() % 30, stream.size() - at);
      parser.push(std::span<const uint8_t>(stream).subspan(at, count));
      at += count;
      while (const auto received = parser.next())
        got.push_back(received->sensors.left_ticks - 0x1313);
    }
    // The hurt one is lost, at most the next with it.
    EXPECT_GE(got.size(), 8u);
    EXPECT_TRUE(std::is_sorted(got.begin(), got.end()));
    EXPECT_EQ(std::count(got.begin(), got.end(), hurt), 0);
  }
}

// Groups of packets, as other people's programs ask for them; sizes and places by iRobot's
// document.
TEST(CreateCodec, GroupsOfPackets) {
  Sensors sensors;
  sensors.right_drop = true;
  sensors.cliffs[3] = true;
  sensors.charging = 2;
  sensors.millivolts = 15'000;
  sensors.mode = 3;
  sensors.left_ticks = 0x1234;
  const auto group = [&sensors](uint8_t id) { return encode_packets(sensors, {&id, 1}); };
  const std::pair<uint8_t, std::size_t> sizes[] = {{0, 26},   {1, 10},   {2, 6},  {3, 10},
                                                   {4, 14},   {5, 12},   {6, 52}, {100, 80},
                                                   {101, 28}, {106, 12}, {107, 9}};
  for (const auto& [id, size] : sizes) EXPECT_EQ(group(id).size(), size) << int{id};
  const Bytes all = group(100);
  EXPECT_EQ(all[0], 4);   // a wheel hangs
  EXPECT_EQ(all[5], 1);   // cliff on the right
  EXPECT_EQ(all[16], 2);  // charging
  EXPECT_EQ(all[17], 0x3A);
  EXPECT_EQ(all[18], 0x98);
  EXPECT_EQ(all[40], 3);  // mode
  EXPECT_EQ(all[52], 0x12);
  EXPECT_EQ(all[53], 0x34);
  EXPECT_TRUE(group(0x3B).empty());
}

// Orders that Marco never gives, with data that look like orders.
TEST(CreateCodec, OtherRequestsKeepThemInStep) {
  RequestParser parser;
  const Bytes requests{0x8C, 0,    2,    0x80, 0x10, 0x8E, 7,  // a song whose notes are opcodes
                       0x8B, 0x80, 0x84, 0x07,                 // lights
                       0xA7, 7,    7,    7,    7,    7,    7, 7,    7, 7,   7,
                       7,    7,    7,    7,    7,    0x92, 0, 0x80, 0, 0x40};
  std::vector<uint8_t> opcodes;
  for (const uint8_t byte : requests) {
    parser.push({&byte, 1});
    while (const auto request = parser.next())
      opcodes.push_back(static_cast<uint8_t>(request->opcode));
  }
  EXPECT_EQ(opcodes, (Bytes{0x8C, 0x8B, 0xA7, 0x92}));
}

struct Parts {
  explicit Parts(const CreateEmulatorOptions& device)
      : robot(device, [this] { return touch; }), driver(CreateOptions{}) {}
  CreateWorld touch;
  CreateEmulator robot;
  CreateBase driver;
};
struct Robot : Parts, testing::DrivenBase<CreateBase> {
  explicit Robot(const CreateEmulatorOptions& device = {})
      : Parts(device), DrivenBase(driver, robot, kBaud) {}
  double moved_m() const { return (robot.left_m() + robot.right_m()) / 2.0; }
  double turned_rad() const { return (robot.right_m() - robot.left_m()) / kTrackM; }
  bool stands() const { return robot.left_m_per_s() == 0.0 && robot.right_m_per_s() == 0.0; }
};

TEST(CreateDriver, FindsTheRobotAtEachSpeed) {
  for (const int baud : {115'200, 57'600, 19'200}) {
    CreateEmulatorOptions device;
    device.baud = baud;
    CreateEmulator robot(device);
    CreateBase driver({});
    testing::Bench<CreateBase> bench(driver, robot, kBaud);
    const Utime begin = bench.now();
    const auto up = [&] { return driver.status().link == BaseStatus::Link::up; };
    EXPECT_TRUE(bench.run_until(4.0, up)) << baud << ": " << driver.state();
    std::printf("Create: %d baud found after %.1f s\n", baud, (bench.now() - begin).seconds());
    bench.plug(false);
    bench.run(3.0);
    bench.plug(true);
    EXPECT_TRUE(bench.run_until(1.0, up)) << baud;
  }
  CreateOptions fixed;
  fixed.baud = 19'200;
  CreateEmulator robot;
  CreateBase driver(fixed);
  testing::Bench<CreateBase> bench(driver, robot, kBaud);
  bench.run(8.0);
  EXPECT_NE(driver.status().link, BaseStatus::Link::up);
  EXPECT_NE(driver.status().note.find("press CLEAN"), std::string::npos);
}

TEST(CreateDriver, MovesTurnsAndReckonsOverTheCountersWrap) {
  Robot robot;
  EXPECT_EQ(robot.driver.status().battery_v, std::vector<double>{15.0});
  EXPECT_EQ(robot.move(1.0), Fate::done);
  EXPECT_NEAR(robot.moved_m(), 1.0, 0.01);
  EXPECT_EQ(robot.turn(deg_to_rad(90.0)), Fate::done);
  EXPECT_NEAR(rad_to_deg(robot.turned_rad()), 90.0, 2.0);
  EXPECT_EQ(robot.move(-1.5), Fate::done);
  const Pose2& pose = robot.driver.odom_from_robot();
  EXPECT_NEAR(pose.x_m, 1.0, 0.01 + 1.5 * std::sin(deg_to_rad(2.0)));  // the turn is good to 2 deg
  EXPECT_NEAR(pose.y_m, -1.5, 0.03);
  EXPECT_NEAR(normalize_angle(pose.theta_rad - robot.turned_rad()), 0.0, 0.006);  // three ticks
  // 29 m are 65536 ticks; the way back went below 0, which is a wrap as well.
  EXPECT_EQ(robot.move(32.0, 200.0), Fate::done);
  EXPECT_NEAR(robot.driver.odom_from_robot().y_m, 30.5, 0.7);
  EXPECT_NEAR(robot.moved_m(), 31.5, 0.05);
  EXPECT_EQ(robot.driver.bad_input(), 0);
}

TEST(CreateDriver, ACliffOrALiftedWheelEndsTheOrder) {
  for (const int mode_offset : {0, 1}) {
    CreateEmulatorOptions device;
    device.mode_offset = mode_offset;
    Robot robot(device);
    for (bool CreateWorld::*danger :
         {&CreateWorld::cliff, &CreateWorld::left_drop, &CreateWorld::on_charger}) {
      robot.begin_move(2.0);
      robot.bench.run(1.5);
      EXPECT_FALSE(robot.stands());
      robot.touch.*danger = true;
      robot.bench.run(0.6);
      EXPECT_TRUE(robot.stands());
      EXPECT_EQ(robot.robot.mode(), OiMode::passive);
      EXPECT_EQ(robot.driver.status().link, Link::starting);
      EXPECT_EQ(robot.driver.status().command, Fate::aborted);
      robot.touch.*danger = false;
      EXPECT_TRUE(robot.comes_up(1.5));
      robot.bench.run(1.0);
      EXPECT_TRUE(robot.stands());  // nothing resumes
      EXPECT_EQ(robot.robot.mode(), OiMode::safe);
      EXPECT_EQ(robot.move(0.2), Fate::done);
    }
  }
}

TEST(CreateDriver, ABumperStopsIt) {
  Robot robot;
  robot.begin_move(2.0);
  robot.bench.run(1.5);
  robot.touch.left_bump = true;
  robot.bench.run(0.6);
  EXPECT_TRUE(robot.stands());
  EXPECT_EQ(robot.driver.status().bumpers, (std::vector<bool>{true, false}));
}

TEST(CreateDriver, ASleepingRobotIsNamed) {
  CreateEmulator robot;
  robot.sleep();
  CreateBase driver({});
  testing::Bench<CreateBase> bench(driver, robot, kBaud);
  bench.run(5.0);
  EXPECT_EQ(driver.status().link, Link::down);
  EXPECT_THAT(driver.status().note, HasSubstr("press CLEAN"));
  robot.press_clean();
  EXPECT_TRUE(bench.run_until(1.5, [&] { return driver.status().link == Link::up; }));
}

// It has no watchdog: the driver's last words must stop it.
TEST(CreateDriver, LeavesAStandingRobot) {
  Robot robot;
  robot.velocity(0.2, 0.0);
  robot.bench.run(0.4);
  EXPECT_FALSE(robot.stands());
  Bytes last;
  robot.driver.shut_down(last);
  robot.robot.receive(last, kBaud, robot.bench.now());
  robot.bench.frozen = true;
  robot.bench.run(0.5);
  EXPECT_TRUE(robot.stands());
  EXPECT_EQ(robot.robot.mode(), OiMode::off);
}

// Each byte may be lost or turned: no way is made of it.
TEST(CreateDriver, SpoiltBytesCostNoWay) {
  Robot robot;
  std::mt19937 random(7);
  robot.bench.spoil = [&random](std::vector<uint8_t>& bytes) {
    for (uint8_t& byte : bytes) {
      if (random() % 300 == 0) byte = static_cast<uint8_t>(random());
    }
  };
  EXPECT_EQ(robot.move(1.0), Fate::done);
  EXPECT_NEAR(robot.driver.odom_from_robot().x_m, robot.moved_m(), 0.01);
  EXPECT_GT(robot.driver.bad_input(), 0);
}

}  // namespace
}  // namespace marco::drivers::create
