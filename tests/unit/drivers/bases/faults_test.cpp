#include "simulator/live/faulty_emulator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace marco::sim {
namespace {

constexpr Utime kStart = Utime::from_us(1'000'000'000'000'000);

Utime at(double seconds) { return kStart + Duration::from_seconds(seconds); }

/// Says "tick" at each step and notes what it hears.
class Parrot final : public drivers::Emulator {
 public:
  void receive(std::span<const uint8_t> bytes, int, Utime) override {
    heard.insert(heard.end(), bytes.begin(), bytes.end());
  }
  void advance(Utime, std::vector<uint8_t>& out) override {
    for (const char c : {'t', 'i', 'c', 'k'}) out.push_back(static_cast<uint8_t>(c));
  }
  Utime next_event() const override { return at(1000.0); }
  void on_connection(bool, Utime) override {}

  std::vector<uint8_t> heard;
};

struct Bench {
  std::string advance(double seconds) {
    std::vector<uint8_t> out;
    faulty.advance(at(seconds), out);
    return {out.begin(), out.end()};
  }
  FaultBoard board{{"laser"}};
  Parrot parrot;
  FaultyEmulator faulty{parrot, board, "laser"};
};

TEST(Faults, OffNeitherHearsNorSpeaksAndComesBack) {
  Bench bench;
  bench.board.add({"laser", "off", 1.0, 2.0}, kStart);
  EXPECT_EQ(bench.advance(0.9), "tick");
  EXPECT_EQ(bench.advance(1.0), "");
  const std::vector<uint8_t> order{1, 2};
  bench.faulty.receive(order, 9600, at(1.5));
  EXPECT_TRUE(bench.parrot.heard.empty());
  EXPECT_EQ(bench.board.state(at(1.5)), "laser off");
  EXPECT_EQ(bench.advance(3.0), "tick");
  bench.faulty.receive(order, 9600, at(3.0));
  EXPECT_EQ(bench.parrot.heard, order);
  EXPECT_EQ(bench.board.state(at(3.0)), "");
}

TEST(Faults, GarbageKeepsTheCountOfBytes) {
  Bench bench;
  bench.board.add({"laser", "garbage", 0.0, 1000.0}, kStart);
  int changed = 0;
  for (int i = 0; i < 100; ++i) {
    const std::string said = bench.advance(0.01 * i);
    ASSERT_EQ(said.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) changed += said[k] != "tick"[k] ? 1 : 0;
  }
  EXPECT_NEAR(changed, 120, 40);  // three of ten, four standard deviations of 400 draws
}

TEST(Faults, SlowComesLateButInOrder) {
  Bench bench;
  bench.board.add({"laser", "slow", 0.0, 1.0}, kStart);
  EXPECT_EQ(bench.advance(0.0), "");
  EXPECT_LE(bench.faulty.next_event(), at(0.5));
  EXPECT_EQ(bench.advance(0.4), "");
  EXPECT_EQ(bench.advance(0.5), "tick");
  EXPECT_EQ(bench.advance(1.2), "tickticktick");  // of 0.4 and 0.5, and, the fault over, of 1.2
  EXPECT_EQ(bench.advance(1.3), "tick");
}

TEST(Faults, IntermittentSpeaksSixTenthsOfTheTime) {
  Bench bench;
  bench.board.add({"laser", "intermittent", 0.0, 100.0}, kStart);
  int spoken = 0;
  for (int i = 0; i < 1000; ++i) spoken += bench.advance(0.01 * i).empty() ? 0 : 1;
  EXPECT_EQ(spoken, 600);
}

TEST(Faults, NoneEndsThemAndNonsenseIsRefused) {
  Bench bench;
  bench.board.add({"laser", "off", 0.0, 100.0}, kStart);
  bench.board.add({"laser", "wrong", 0.0, 100.0}, kStart);
  EXPECT_EQ(bench.board.state(at(1.0)), "laser off, laser wrong");
  bench.board.add({"laser", "none"}, at(1.0));
  EXPECT_EQ(bench.board.state(at(1.0)), "");
  EXPECT_THROW(bench.board.add({"lamp", "off"}, kStart), std::invalid_argument);
  EXPECT_THROW(bench.board.add({"laser", "sad"}, kStart), std::invalid_argument);
  EXPECT_THROW(bench.board.add({"laser", "off", -1.0}, kStart), std::invalid_argument);
  EXPECT_THROW(bench.board.add({"laser", "off", 0.0, HUGE_VAL}, kStart), std::invalid_argument);
  EXPECT_THAT(describe_faults(), ::testing::HasSubstr("intermittent"));
}

}  // namespace
}  // namespace marco::sim
