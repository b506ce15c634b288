#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simulator/devices/hcs12/base_emulator.hpp"
#include "simulator/devices/hcs12/pantilt_emulator.hpp"

namespace marco::drivers::hcs12 {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A hand at the terminal.
class Terminal {
 public:
  explicit Terminal(Emulator& board) : board_(board) { board_.on_connection(true, now_); }
  void type(const std::string& text) {
    board_.receive({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, 9600, now_);
  }
  std::string listen(double seconds) {
    const Utime end = now_ + Duration::from_seconds(seconds);
    std::vector<uint8_t> out;
    while (now_ < end) {
      now_ = now_ + Duration::from_us(500);
      board_.advance(now_, out);
    }
    return {out.begin(), out.end()};
  }
  std::string ask(const std::string& text, double seconds = 0.15) {
    type(text);
    return listen(seconds);
  }
  Utime now() const { return now_; }

 private:
  Emulator& board_;
  Utime now_ = Utime::from_us(1'000'000'000);
};

BaseEmulatorOptions ideal_wheels() {
  BaseEmulatorOptions options;
  options.ideal_wheels = true;
  return options;
}

TEST(Hcs12Base, SaysItsNameAndAnswersTheVectors) {
  BaseEmulator board({}, ideal_wheels());
  Terminal terminal(board);
  EXPECT_EQ(terminal.listen(0.1), "Robot ROCA-MOBILE-2 v1.0 listo\n");
  EXPECT_EQ(terminal.ask("t\n"), "t12716 25394 12859 25837\n");
  EXPECT_EQ(terminal.ask("s2 50 50\n"), "s\n");
  EXPECT_EQ(terminal.ask("k5 30 50\n"), "k\n");
  EXPECT_EQ(terminal.ask("z1\n"), "z\n");
  EXPECT_TRUE(board.buzzer());
  EXPECT_EQ(terminal.ask("z\n"), "z\n");
  EXPECT_FALSE(board.buzzer());
  EXPECT_EQ(terminal.ask("r10\n"), "r\n");  // not the text's misprint c
  EXPECT_EQ(terminal.ask("p\n"), "p\n");
  EXPECT_EQ(terminal.ask("y1 2\n"), "");
  EXPECT_EQ(terminal.ask("*\r\n"), "*\n");
  EXPECT_EQ(terminal.ask("S0 8\n"), "S\n");
  EXPECT_EQ(terminal.ask("s\n"), "s65535\n65535\n");
}

TEST(Hcs12Base, RepliesTakeTheirTimeOnTheLine) {
  BaseEmulator board({}, ideal_wheels());
  Terminal terminal(board);
  terminal.listen(0.1);
  terminal.type("t\n");
  EXPECT_LT(terminal.listen(0.024).size(), 25U);  // 25 bytes of 1.04 ms
  terminal.listen(0.003);
  EXPECT_EQ(terminal.ask("*\n"), "*\n");
}

// The timelines of ideal wheels with the defaults 5 30 50 (device notes 2.3). The reply "a\n" takes
// two bytes, in which two or three ticks are lost to the control, not to the wheels.
TEST(Hcs12Base, MovesTakeTheListingsTicks) {
  const struct {
    const char* command;
    double ticks;
    double clicks;
  } moves[] = {{"a10\n", 199, 1003}, {"a100\n", 987, 10002}, {"a1000\n", 4521, 100005}};
  for (const auto& move : moves) {
    BaseEmulator board({}, ideal_wheels());
    Terminal terminal(board);
    terminal.listen(0.1);
    terminal.type(move.command);
    const int64_t start = board.ticks();
    while (board.motors_on()) terminal.listen(0.0005);
    EXPECT_NEAR(static_cast<double>(board.ticks() - start), move.ticks, 4) << move.command;
    EXPECT_NEAR(board.left_clicks(), move.clicks, 30) << move.command;
    terminal.listen(0.05);
    const auto status = terminal.ask("l\n");
    EXPECT_THAT(status, StartsWith("l"));
    const auto parsed = parse_wheel_status(status.substr(0, status.size() - 1));
    ASSERT_TRUE(parsed) << status;
    EXPECT_NEAR(parsed->left_clicks, board.left_clicks(), 1.0);
    EXPECT_FALSE(parsed->left_on);
  }
}

TEST(Hcs12Base, RealWheelsArriveToo) {
  BaseEmulator board({}, {});
  Terminal terminal(board);
  terminal.listen(0.1);
  for (const char* command : {"a100\n", "r250\n", "i80\n", "d80\n", "a900\n"}) {
    const double left = board.left_clicks(), right = board.right_clicks();
    terminal.type(command);
    terminal.listen(8.0);
    EXPECT_FALSE(board.motors_on()) << command;
    const auto goal =
        parse_command(std::string_view(command).substr(0, std::string(command).size() - 1));
    // One tick's clicks beyond the goal, and what the other wheel ran meanwhile.
    EXPECT_NEAR(std::abs(board.left_clicks() - left), goal->values[0] * 100, 120) << command;
    EXPECT_NEAR(std::abs(board.right_clicks() - right), goal->values[0] * 100, 120) << command;
    EXPECT_EQ(board.left_clicks() > left, command[0] == 'a' || command[0] == 'd') << command;
    EXPECT_EQ(board.right_clicks() > right, command[0] == 'a' || command[0] == 'i') << command;
  }
}

TEST(Hcs12Base, PollingWhileItRunsFastLosesClicks) {
  BaseEmulator board({}, {});
  Terminal terminal(board);
  terminal.listen(0.1);
  terminal.type("a1000\n");
  for (int i = 0; i < 30; ++i) terminal.ask("l\n", 0.1);
  terminal.ask("p\n");
  std::string reply = terminal.ask("l\n");
  const auto status = parse_wheel_status(reply.substr(0, reply.size() - 1));
  ASSERT_TRUE(status);
  EXPECT_GT(board.left_clicks() - status->left_clicks, 1000.0);
  EXPECT_GT(board.skipped_ticks(), 0);
}

TEST(Hcs12Base, WaitsAsTheListingDoes) {
  BaseEmulator board({}, ideal_wheels());
  Terminal terminal(board);
  terminal.listen(0.1);
  EXPECT_EQ(terminal.ask("w50\n", 0.04), "");
  EXPECT_EQ(terminal.listen(0.02), "w\n");
  EXPECT_EQ(terminal.ask("a10\n", 0.01), "a\n");
  EXPECT_EQ(terminal.ask("w10000 1 1 0\n", 0.15), "");
  EXPECT_EQ(terminal.listen(0.1), "w\n");
  // The manual's own example has three numbers: a plain delay.
  EXPECT_EQ(terminal.ask("w500 1 1\n", 0.4), "");
  EXPECT_EQ(terminal.listen(0.2), "w\n");
}

TEST(Hcs12Base, CreepsToRestWithoutAGoalAndKeepsItsMotorsOn) {
  BaseEmulator board({}, ideal_wheels());
  Terminal terminal(board);
  terminal.listen(0.1);
  terminal.ask("v130 130\n", 2.0);
  const double there = board.left_clicks();
  EXPECT_GT(there, 0.0);
  terminal.listen(0.2);
  EXPECT_EQ(board.left_clicks(), there);
  EXPECT_TRUE(board.motors_on());
}

TEST(Hcs12Base, ASecondLineWhileItPrintsIsLost) {
  BaseEmulator board({}, ideal_wheels());
  Terminal terminal(board);
  terminal.listen(0.1);
  terminal.type("t\n");
  const std::string head = terminal.listen(0.005);
  terminal.type("z1\n");
  terminal.type("p\n");
  EXPECT_EQ(head + terminal.listen(0.1), "t12716 25394 12859 25837\nz\n");
  EXPECT_EQ(board.lost_lines(), 1);
}

TEST(Hcs12Base, ASonarRoundTakesItsTime) {
  BaseWorld world;
  world.sonar_range_m = [](std::size_t transducer) {
    return transducer == 3 ? HUGE_VAL : 1.0 + 0.1 * static_cast<double>(transducer);
  };
  BaseEmulatorOptions options;
  options.sonar_form = SonarForm::one_line;
  BaseEmulator board(world, options);
  Terminal terminal(board);
  terminal.listen(0.1);
  EXPECT_EQ(terminal.ask("s1\n", 0.6), "s\n");
  SonarCollector collector;
  collector.begin(16);
  std::string reply = terminal.ask("s\n", 0.2);
  auto times = collector.push(reply.substr(0, reply.size() - 1));
  ASSERT_TRUE(times) << reply;
  EXPECT_NEAR(sonar_range_m(times->at(0), 343.0), 1.0, 0.001);
  EXPECT_EQ(times->at(15), kNoEcho);  // not yet fired: 16 shots take 1.2 s
  terminal.listen(0.9);
  collector.begin(16);
  reply = terminal.ask("s\n", 0.2);
  times = collector.push(reply.substr(0, reply.size() - 1));
  ASSERT_TRUE(times);
  EXPECT_NEAR(sonar_range_m(times->at(15), 343.0), 2.5, 0.001);
  EXPECT_EQ(times->at(3), kNoEcho);
  EXPECT_EQ(terminal.ask("s3\n"), "s1\n");
}

TEST(Hcs12Base, AnotherBaudRateIsNoise) {
  BaseEmulator board({}, {});
  Terminal terminal(board);
  terminal.listen(0.1);
  const std::string text = "*\n";
  board.receive({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, 38400,
                terminal.now());
  EXPECT_EQ(terminal.listen(0.1), "");
}

TEST(Hcs12PanTilt, FindsItsHomeThenAnswers) {
  PanTiltEmulator board({});
  Terminal terminal(board);
  const std::string boot = terminal.listen(5.0);
  EXPECT_THAT(boot, StartsWith("Sistema ROCA-PANT-TILT v1.0\nGirando a la derecha\n"));
  EXPECT_THAT(boot, HasSubstr("Motor de giro apagado\nHacia abajo\n"));
  EXPECT_THAT(boot, HasSubstr("Listo\n"));
  EXPECT_TRUE(board.homed());
  EXPECT_NEAR(board.pan_units(), 0.0, 0.01);
  EXPECT_EQ(terminal.ask("l\n"), "l0 0 0 0 0 0 0 0 0\n");
  EXPECT_EQ(terminal.ask("g10\n", 0.01), "g\n");
}

TEST(Hcs12PanTilt, GoesWhereItIsToldAndEndsOnAnIndex) {
  PanTiltEmulator board({});
  Terminal terminal(board);
  terminal.listen(5.0);
  terminal.ask("g60\n");
  terminal.ask("e40\n", 6.0);
  EXPECT_NEAR(board.pan_units(), 60.0, 0.06);
  EXPECT_NEAR(board.tilt_units(), 40.0, 0.06);
  EXPECT_EQ(terminal.ask("l\n"), "l60 0 40 0 0 0 0 0 0\n");
  terminal.ask("g20\n", 5.0);
  EXPECT_NEAR(board.pan_units(), 20.0, 0.06);
  terminal.ask("g300\n", 12.0);
  EXPECT_NEAR(board.pan_units(), 248.0, 0.06);
  terminal.ask("e255\n", 5.0);
  EXPECT_NEAR(board.tilt_units(), 100.0, 0.06);
}

TEST(Hcs12PanTilt, TheListingDoesNotStopAndTheManualDoes) {
  PanTiltEmulatorOptions manual;
  manual.listing_stop = manual.listing_status = false;
  PanTiltEmulator by_manual(manual), by_listing({});
  Terminal first(by_manual), second(by_listing);
  for (Terminal* terminal : {&first, &second}) {
    terminal->listen(5.0);
    terminal->ask("g100\n", 1.0);
  }
  EXPECT_EQ(first.ask("p\n"), "p\n");
  EXPECT_EQ(second.ask("p\n"), "");
  const double stopped_at = by_manual.pan_units(), passed = by_listing.pan_units();
  EXPECT_THAT(first.ask("l\n", 1.0), ::testing::EndsWith(" 0 0 0 \n"));
  second.listen(1.0);
  EXPECT_EQ(by_manual.pan_units(), stopped_at);
  EXPECT_GT(by_listing.pan_units(), passed + 1.0);
}

}  // namespace
}  // namespace marco::drivers::hcs12
