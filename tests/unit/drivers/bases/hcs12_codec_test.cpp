#include "drivers/hcs12/codec.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/hcs12/ramp.hpp"

namespace marco::drivers::hcs12 {
namespace {

TEST(Hcs12Codec, CommandsAreTheManualsBytes) {
  EXPECT_EQ(encode_command('a', {10}), std::string("\x61\x31\x30\x0A"));
  EXPECT_EQ(encode_command('k', {5, 30, 50}), std::string("\x6B\x35\x20\x33\x30\x20\x35\x30\x0A"));
  EXPECT_EQ(encode_command('w', {10000, 1, 1, 0}),
            std::string("\x77\x31\x30\x30\x30\x30\x20\x31\x20\x31\x20\x30\x0A"));
  EXPECT_EQ(encode_command('l'), "l\n");
  EXPECT_EQ(encode_command('s', {2, 50, 50}), "s2 50 50\n");
  EXPECT_EQ(encode_command('g', {10}), "g10\n");
}

TEST(Hcs12Codec, TheFirmwareReadsWhatTheHostWrote) {
  const auto command = parse_command("w10000 1 1 0");
  ASSERT_TRUE(command);
  EXPECT_EQ(command->letter, 'w');
  EXPECT_EQ(command->count, 4U);
  EXPECT_EQ(command->values[0], 10000);
  EXPECT_EQ(command->values[3], 0);
  EXPECT_FALSE(parse_command(""));
}

TEST(Hcs12Codec, TheFirmwareReadsOddLinesItsOwnWay) {
  const auto spaced = parse_command("S 0 1");  // a zero slips in
  EXPECT_EQ(spaced->count, 3U);
  EXPECT_EQ(spaced->values[2], 1);
  EXPECT_EQ(parse_command("z")->count, 0U);
  EXPECT_EQ(parse_command("z1 ")->count, 2U);
  EXPECT_EQ(parse_command("a65546")->values[0], 10);  // sixteen bits
  EXPECT_EQ(parse_command("a1/")->values[0], 9);      // '/' is the digit -1
  EXPECT_EQ(parse_command("S" + std::string(40, ' '))->count, Command::kMaxValues);
}

TEST(Hcs12Codec, WheelStatusIsTheVector) {
  const std::string bytes =
      "\x6C\x31\x30\x2E\x30\x33\x20\x31\x30\x2E\x30\x30\x20\x30\x20\x30\x20\x30\x0A";
  EXPECT_EQ(encode_wheel_status({1003, 1000, false, false, false}), bytes);
  const auto status = parse_wheel_status("l10.03 10.00 0 0 0");
  ASSERT_TRUE(status);
  EXPECT_EQ(status->left_clicks, 1003U);
  EXPECT_EQ(status->right_clicks, 1000U);
  EXPECT_FALSE(status->left_on);
  EXPECT_EQ(encode_wheel_status({6553599, 5, true, true, true}), "l65535.99 0.05 1 1 1\n");
}

TEST(Hcs12Codec, NothingElseIsAWheelStatus) {
  for (const char* line : {"", "l", "l10.03", "l10.03 10.00", "l10.03 10.00 0 0",
                           "l1003 10.00 0 0 0", "l10.0 10.00 0 0 0", "l10.03 10.00 0 2 0",
                           "l70000.00 10.00 0 0 0", "l10.+3 10.00 0 0 0", "t10.03 10.00 0 0 0",
                           "l10.03  10.00 0 0 0", "l10.03 10.00 0 0 0 0", "l-1.00 10.00 0 0 0"}) {
    EXPECT_FALSE(parse_wheel_status(line)) << line;
  }
}

TEST(Hcs12Codec, BatteriesAreTheManualsExample) {
  EXPECT_EQ(encode_batteries({battery_millivolts(0, 639), battery_millivolts(1, 679),
                              battery_millivolts(2, 684), battery_millivolts(3, 689)}),
            "t12716 25394 12859 25837\n");
  EXPECT_EQ(parse_batteries("t12716 25394 12859 25837")->at(2), 12859U);
  EXPECT_FALSE(parse_batteries("t12716 25394 12859"));
  EXPECT_FALSE(parse_batteries("t12716 25394 12859 99999"));
  for (uint32_t adc = 0; adc < 1024; ++adc) {
    EXPECT_EQ(battery_adc(1, battery_millivolts(1, adc) * 1e-3), adc);
  }
}

TEST(Hcs12Codec, SonarTimesAreRanges) {
  // 1634 units = 8.71 ms round trip = 1.495 m at 343 m/s.
  EXPECT_NEAR(sonar_range_m(1634, 343.0), 1.4946, 1e-4);
  EXPECT_EQ(sonar_range_m(kNoEcho, 343.0), 0.0);
  EXPECT_EQ(sonar_time_units(sonar_range_m(1634, 343.0), 343.0), 1634U);
}

TEST(Hcs12Codec, SonarReadingsComeInBothForms) {
  const std::vector<uint32_t> times{1634, 1779, 417, 1163};
  EXPECT_EQ(encode_sonar(times, SonarForm::one_line), "s1634 1779 417 1163\n");
  EXPECT_EQ(encode_sonar(times, SonarForm::line_each), "s1634\n1779\n417\n1163\n");
  SonarCollector collector;
  collector.begin(4);
  EXPECT_EQ(collector.push("s1634 1779 417 1163"), times);
  collector.begin(4);
  EXPECT_FALSE(collector.push("s1634"));
  EXPECT_FALSE(collector.push("1779"));
  EXPECT_FALSE(collector.push("417"));
  EXPECT_EQ(collector.push("1163"), times);
  collector.begin(4);
  EXPECT_FALSE(collector.push("s"));
  EXPECT_FALSE(collector.push("1634 x"));
  EXPECT_FALSE(collector.collecting());
}

TEST(Hcs12Codec, PanTiltStatusComesInBothForms) {
  EXPECT_EQ(encode_pantilt_status({}), "l0 0 0 0 0 0 0 0 0\n");
  PanTiltStatus manual;
  manual.full = false;
  EXPECT_EQ(encode_pantilt_status(manual), "l0 0 0 0 \n");
  const auto full = parse_pantilt_status("l12 -345 67 890 0 1 0 1 0");
  ASSERT_TRUE(full);
  EXPECT_TRUE(full->full);
  EXPECT_EQ(full->pan_clicks, -345);
  EXPECT_EQ(full->tilt_units, 67);
  EXPECT_TRUE(full->right_stop);
  EXPECT_TRUE(full->pan_on);
  const auto four = parse_pantilt_status("l12 67 0 1 ");
  ASSERT_TRUE(four);
  EXPECT_FALSE(four->full);
  EXPECT_EQ(four->tilt_units, 67);
  EXPECT_TRUE(four->tilt_on);
  EXPECT_FALSE(parse_pantilt_status("l12 67 0"));
  EXPECT_FALSE(parse_pantilt_status("l12 67 0 3"));
}

TEST(Hcs12Codec, AnyStatusReadsBackInAnySplit) {
  std::mt19937 random(7);
  LineCutter cutter;
  for (int i = 0; i < 2000; ++i) {
    const WheelStatus status{static_cast<uint32_t>(random() % 6553600),
                             static_cast<uint32_t>(random() % 6553600), random() % 2 == 0,
                             random() % 2 == 0, random() % 2 == 0};
    std::optional<std::string> line;
    for (const char c : encode_wheel_status(status)) {
      EXPECT_FALSE(line);
      line = cutter.push(static_cast<uint8_t>(c));
    }
    ASSERT_TRUE(line);
    const auto back = parse_wheel_status(*line);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->left_clicks, status.left_clicks);
    EXPECT_EQ(back->right_clicks, status.right_clicks);
    EXPECT_EQ(back->sonar_on, status.sonar_on);
  }
}

TEST(Hcs12Codec, GarbageNeverOutlivesItsLine) {
  std::mt19937 random(11);
  LineCutter cutter;
  for (int round = 0; round < 200; ++round) {
    const std::size_t length = random() % 600;
    for (std::size_t i = 0; i < length; ++i) {
      if (const auto line = cutter.push(static_cast<uint8_t>(random()))) {
        parse_wheel_status(*line);
        parse_pantilt_status(*line);
        parse_batteries(*line);
        parse_command(*line);
      }
    }
    cutter.push('\n');
    std::optional<std::string> line;
    for (const char c : std::string("l1.23 4.56 1 0 1\n"))
      line = cutter.push(static_cast<uint8_t>(c));
    ASSERT_TRUE(line && parse_wheel_status(*line)) << "round " << round;
  }
  EXPECT_GT(cutter.overlong(), 0);
}

TEST(Hcs12Codec, TheRestOfAnOverlongLineIsNoLine) {
  LineCutter cutter;
  const std::string status = encode_wheel_status({100, 100, true, true, false});
  for (const char c : std::string(LineCutter::kMaxLine + 1, 'x') + status) {
    EXPECT_FALSE(cutter.push(static_cast<uint8_t>(c)));
  }
  EXPECT_EQ(cutter.overlong(), 1);
  std::optional<std::string> line;
  for (const char c : status) line = cutter.push(static_cast<uint8_t>(c));
  EXPECT_TRUE(line && parse_wheel_status(*line));
}

TEST(Hcs12Codec, TheRampIsTheFirmwaresTimeline) {
  // Ideal wheels, defaults 5 30 50: ticks and final counts from the listing, worked by hand in the
  // device notes. The walk may differ by the ticks between reaching the goal and seeing it.
  const auto ticks_of = [](uint32_t tenths) {
    RampWalk walk(Ramp{}, tenths * 100, RampWalk::Brake::to_zero);
    while (!walk.done()) walk.tick();
    return walk.ticks();
  };
  EXPECT_NEAR(static_cast<double>(ticks_of(10)), 199, 2);
  EXPECT_NEAR(static_cast<double>(ticks_of(100)), 987, 3);
  EXPECT_NEAR(static_cast<double>(ticks_of(655)), 3259, 5);
  EXPECT_NEAR(static_cast<double>(ticks_of(1000)), 4521, 5);
}

TEST(Hcs12Ramp, EveryWalkEnds) {
  for (const auto wheel : {RampWalk::Wheel::ideal, RampWalk::Wheel::real}) {
    for (const auto brake : {RampWalk::Brake::to_zero, RampWalk::Brake::to_start}) {
      for (uint32_t top = 1; top <= 50; ++top) {
        for (const uint32_t start : {1U, 3U}) {
          RampWalk walk({std::min(start, top), top, 30}, 3000, brake, wheel);
          walk.advance_to(1'000'000);
          EXPECT_TRUE(walk.done()) << top << " clicks a tick, from " << start;
        }
      }
    }
  }
}

}  // namespace
}  // namespace marco::drivers::hcs12
