// The sketch of examples/arduino as C++, on a fake Arduino: a second board beside the emulator,
// which shares nothing with the driver.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/transport/wall_clock.hpp"
#include "tests/support/fake_arduino.hpp"
#include "text_base.hpp"

namespace arduino {
#include "examples/arduino/text_base/text_base.ino"
}  // namespace arduino

namespace marco::drivers::textbase {
namespace {

using testing::Bench;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kLoopS = 0.0005;

/// The sketch as a device on a line.
class Sketch final : public Emulator {
 public:
  Sketch() { reset(); }
  void receive(std::span<const uint8_t> bytes, int /*baud*/, Utime /*now*/) override {
    for (const uint8_t byte : bytes) board().typed.push_back(static_cast<char>(byte));
  }
  void advance(Utime now, std::vector<uint8_t>& out) override {
    if (now_ == Utime{}) now_ = now;
    for (; now_ < now; now_ = now_ + Duration::from_seconds(kLoopS)) run();
    const std::string said = std::exchange(board().printed, "");
    out.insert(out.end(), said.begin(), said.end());
  }
  Utime next_event() const override { return kFarFuture; }
  void on_connection(bool /*connected*/, Utime /*now*/) override {}

  void reset() {
    board() = {};
    arduino::setup();
  }
  void run() {
    board().run(kLoopS);
    arduino::loop();
  }
  static ::marco::testing::FakeArduino& board() { return ::marco::testing::fake_arduino(); }

 private:
  Utime now_;
};

/// Types lines, byte by byte, a loop for each.
class ArduinoSketch : public ::testing::Test {
 protected:
  /// @returns what it says until the line was read and `then_s` have passed.
  std::string type(const std::string& line, double then_s = 0.0) {
    sketch_.board().printed.clear();
    for (const char c : line + "\n") {
      sketch_.board().typed.push_back(c);
      sketch_.run();
    }
    wait(then_s);
    return sketch_.board().printed;
  }
  void wait(double seconds) {
    for (double s = 0.0; s < seconds; s += kLoopS) sketch_.run();
  }
  ::marco::testing::FakeArduino& board() { return sketch_.board(); }
  Sketch sketch_;
};

TEST_F(ArduinoSketch, SaysWhoItIsAtItsStartAndWhenAsked) {
  EXPECT_EQ(board().printed, "V 1 mybot 1.0 wd=500\n");
  EXPECT_EQ(type("V?"), "V 1 mybot 1.0 wd=500\n");
  EXPECT_EQ(type("V?*69\r"), with_sum("V 1 mybot 1.0 wd=500") + "\n");
  EXPECT_EQ(type("V?"), with_sum("V 1 mybot 1.0 wd=500") + "\n") << "it keeps its sums";
}

TEST_F(ArduinoSketch, RefusesWhatIsNoOrder) {
  for (const char* line : {"Q", "M", "M 1", "M 1 2 3", "M  1 2", "M x 2", "M1 2", "V", "v?", " V?",
                           "W", "R 1 2", "W 500 "}) {
    EXPECT_EQ(type(line), "E 1 line\n") << line;
  }
  EXPECT_EQ(type(""), "");
  EXPECT_EQ(type(std::string(81, 'M')), "E 1 line\n");
  for (const char* line : {"M 0 0*4E", "M 0 0*4", "M 0 0*", "M 0 0*4DD"}) {
    EXPECT_THAT(type(line), StartsWith("E 2 ")) << line;
  }
  for (const char* line : {"W 99", "W 2001", "W 0", "R 4", "R 1001", "R 0", "R -5"}) {
    EXPECT_THAT(type(line), StartsWith("E 3 ")) << line;
  }
  EXPECT_EQ(type("W 100"), "K W 100\n");
  EXPECT_EQ(type("R 1000"), "K R 1000\n");
}

TEST_F(ArduinoSketch, TurnsItsWheelsAsFastAsTold) {
  for (int i = 0; i < 10; ++i) type("M 1000 -500", 0.2);
  EXPECT_NEAR(board().left.speed, 1000.0, 30.0);
  EXPECT_NEAR(board().right.speed, -500.0, 30.0);
  type("M 0 0", 0.3);
  EXPECT_NEAR(board().left.speed, 0.0, 10.0);
}

TEST_F(ArduinoSketch, ReportsItsTicks) {
  EXPECT_THAT(type("T"), Not(HasSubstr("T ")));
  const std::string said = type("R 20", 0.101);
  EXPECT_THAT(said, StartsWith("K R 20\n"));
  EXPECT_EQ(std::count(said.begin(), said.end(), 'T'), 5);
  type("M 700 -300", 0.4);
  const std::string last = type("M 700 -300", 0.05);
  const std::size_t at = last.rfind("T ");
  ASSERT_NE(at, std::string::npos) << last;
  const auto report = parse_board_line(last.substr(at, last.find('\n', at) - at));
  ASSERT_TRUE(report.has_value()) << last;
  const auto& numbers = std::get<Report>(*report);
  EXPECT_NEAR(numbers.left_ticks, board().left.travelled, 20.0);
  EXPECT_NEAR(numbers.right_ticks, board().right.travelled, 20.0);
  EXPECT_LT(numbers.right_ticks, -50);
  EXPECT_EQ(numbers.flags, kMotorsOn);
}

TEST_F(ArduinoSketch, StopsWhenNobodyOrders) {
  type("W 300");
  type("M 1000 1000", 0.28);
  EXPECT_GT(board().left.speed, 500.0);
  EXPECT_THAT(type("R 20", 0.1), HasSubstr("E 4 watchdog\n"));
  EXPECT_EQ(board().outputs[5], 0);
  EXPECT_EQ(board().outputs[6], 0);
  EXPECT_THAT(type("V?", 0.1), Not(HasSubstr("E 4"))) << "said once";
  EXPECT_THAT(board().printed, HasSubstr(" 2\n"));  // the flag
  type("M 1000 1000", 0.2);
  EXPECT_GT(board().left.speed, 500.0);
}

TEST_F(ArduinoSketch, RedButtonAndBumpers) {
  type("R 20");
  type("M 1000 1000", 0.2);
  board().inputs[12] = 0;
  wait(0.05);
  EXPECT_THAT(board().printed, HasSubstr("E 7 "));
  EXPECT_EQ(board().outputs[5], 0);
  type("M 1000 1000", 0.1);
  EXPECT_EQ(board().outputs[5], 0) << "an order does not release it";
  board().inputs[12] = 1;
  wait(0.2);
  EXPECT_EQ(board().outputs[5], 0) << "the release is no order";
  board().inputs[10] = 0;
  EXPECT_THAT(type("M 0 0", 0.1), HasSubstr(" 5\n"));  // motors on, left bumper
}

/// The driver with the sketch as its board.
struct SketchParts {
  Sketch sketch;
  TextBase driver{small_robot()};
};
struct SketchRobot : SketchParts, testing::DrivenBase<TextBase> {
  SketchRobot() : DrivenBase(driver, sketch, kBaud) {}
};

TEST(ArduinoRobot, TheDriverDrivesIt) {
  SketchRobot robot;
  EXPECT_EQ(robot.driver.status().note, "mybot 1.0");
  EXPECT_EQ(robot.move(0.5), BaseStatus::Command::done);
  const auto moved_m = [&] {
    return (robot.sketch.board().left.travelled + robot.sketch.board().right.travelled) / 2.0 /
           ticks_per_m(small_robot());
  };
  EXPECT_NEAR(moved_m(), 0.5, 0.015);
  EXPECT_EQ(robot.turn(deg_to_rad(-90.0)), BaseStatus::Command::done);
  EXPECT_NEAR(rad_to_deg(robot.driver.odom_from_robot().theta_rad), -90.0, 3.0);
  EXPECT_EQ(robot.move(-0.3), BaseStatus::Command::done);
  EXPECT_NEAR(moved_m(), 0.2, 0.03);
  EXPECT_EQ(robot.driver.bad_input(), 0);
}

TEST(ArduinoRobot, ResetInMidDriveAndAHostThatDies) {
  SketchRobot robot;
  robot.begin_move(2.0);
  robot.bench.run(1.5);
  robot.sketch.reset();
  robot.bench.run(0.2);
  EXPECT_EQ(robot.driver.status().command, BaseStatus::Command::aborted);
  EXPECT_TRUE(robot.comes_up(3.0));
  robot.begin_move(2.0);
  robot.bench.run(1.5);
  EXPECT_GT(robot.sketch.board().left.speed, 1000.0);
  robot.bench.frozen = true;
  robot.bench.run(1.0);
  EXPECT_NEAR(robot.sketch.board().left.speed, 0.0, 1.0);
}

}  // namespace
}  // namespace marco::drivers::textbase
