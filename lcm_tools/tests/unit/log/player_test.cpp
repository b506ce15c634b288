#include "lcm_tools/log/player.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/log/keys.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"

namespace marco::logs {
namespace {

using ::testing::ElementsAre;

class PlayerTest : public ::testing::Test {
 protected:
  PlayerTest() { write_poses(folder_ / "log", 20); }  // 0, 0.1 ... 1.9 s

  Player make(const PlayerOptions& options = {}, ChannelChoice channels = {}) {
    return Player(folder_ / "log", std::move(channels), options,
                  [this](const std::string& channel, std::span<const uint8_t>, Utime time) {
                    played_.push_back(static_cast<int>((time.us - kStartUs) / 100000));
                    channels_.push_back(channel);
                    return true;
                  });
  }
  // Calls advance whenever it asks to be called, until `end_us`.
  static void run(Player& player, int64_t start_us, int64_t end_us) {
    auto due = player.advance(start_us);
    while (due && *due <= end_us) due = player.advance(std::max(start_us, *due));
  }
  std::vector<int> take() { return std::exchange(played_, {}); }
  static Utime at_s(double seconds) {
    return Utime::from_us(kStartUs) + Duration::from_seconds(seconds);
  }

  ScratchFolder folder_;
  std::vector<int> played_;
  std::vector<std::string> channels_;
};

constexpr int64_t kNow = 5'000'000'000;

TEST_F(PlayerTest, PlaysAtTheLogsPaceAndSaysWhenItIsDue) {
  Player player = make();
  EXPECT_EQ(player.advance(kNow), kNow + 100000);
  EXPECT_THAT(take(), ElementsAre(0));
  EXPECT_EQ(player.advance(kNow + 99999), kNow + 100000);
  EXPECT_THAT(take(), ElementsAre());
  EXPECT_EQ(player.advance(kNow + 350000), kNow + 400000);
  EXPECT_THAT(take(), ElementsAre(1, 2, 3));
  run(player, kNow + 350000, kNow + 10'000'000);
  EXPECT_TRUE(player.finished());
  EXPECT_EQ(player.published(), 20);
}

TEST_F(PlayerTest, SpeedDividesTheWaitsAndZeroKnowsNone) {
  PlayerOptions options;
  options.speed = 4.0;
  Player fast = make(options);
  EXPECT_EQ(fast.advance(kNow), kNow + 25000);
  // From 50 ms on at half speed: event 2 was just played, event 3 comes 200 ms later.
  fast.advance(kNow + 50000);
  fast.set_speed(0.5, kNow + 50000);
  EXPECT_EQ(fast.advance(kNow + 50000), kNow + 250000);
  options.speed = 0.0;
  Player at_once = make(options);
  take();
  at_once.advance(kNow);
  EXPECT_EQ(take().size(), 20U);
  EXPECT_TRUE(at_once.finished());
  options.speed = -1.0;
  EXPECT_THROW(make(options), std::invalid_argument);
}

TEST_F(PlayerTest, PauseStopsTheLogsTimeAndStepPublishesOne) {
  Player player = make();
  player.advance(kNow);
  player.set_paused(true, kNow + 50000);
  EXPECT_FALSE(player.advance(kNow + 5'000'000));
  take();
  player.step(kNow + 5'000'000);
  player.step(kNow + 5'000'000);
  EXPECT_THAT(take(), ElementsAre(1, 2));
  EXPECT_TRUE(player.paused());
  player.set_paused(false, kNow + 9'000'000);
  EXPECT_EQ(player.advance(kNow + 9'000'000), kNow + 9'100'000);
  EXPECT_THAT(take(), ElementsAre());
}

TEST_F(PlayerTest, SeekGoesToTheFirstEventBehindAnyMoment) {
  Player player = make();
  for (const double seconds : {1.25, 0.0, 1.9, 0.35, -5.0}) {
    player.seek(at_s(seconds), kNow);
    player.advance(kNow);
    EXPECT_EQ(take().front(), std::max(0, static_cast<int>(std::ceil(seconds * 10.0 - 1e-6))));
  }
  player.seek(at_s(60.0), kNow);
  player.advance(kNow);
  EXPECT_TRUE(player.finished());
  player.seek(at_s(1.8), kNow);
  EXPECT_FALSE(player.finished());
  run(player, kNow, kNow + 1000000);
  EXPECT_THAT(take(), ElementsAre(18, 19));
}

// The bisection against a plain search, on a log of many windows.
TEST_F(PlayerTest, SeekInALongLogFindsWhatAPlainSearchFinds) {
  {
    files::EventLogWriter writer(folder_ / "log");
    const std::vector<uint8_t> bytes(700, 0xED);
    for (int i = 0; i < 3000; ++i) {
      // Neighbours out of order by up to 30 ms, as loggers write them.
      writer.write("A", bytes, Utime::from_us(kStartUs + 100000 * i - (i % 3) * 30000));
    }
  }
  const auto events = read_events(folder_ / "log");
  for (int i = 0; i < 3000; i += 131) {
    const Utime wanted = events[static_cast<std::size_t>(i)].event_time;
    Player player = make();
    player.seek(wanted, kNow);
    EXPECT_EQ(player.next_time(), wanted) << i;
  }
}

TEST_F(PlayerTest, LoopsOverItsRange) {
  PlayerOptions options;
  options.loop = true;
  options.range = {at_s(0.5), at_s(0.8)};
  Player player = make(options);
  run(player, kNow, kNow + 650000);
  EXPECT_THAT(take(), ElementsAre(5, 6, 7, 5, 6, 7, 5, 6, 7, 5));
  player.set_loop(false);
  run(player, kNow + 650000, kNow + 2000000);
  EXPECT_THAT(take(), ElementsAre(6, 7));
  EXPECT_TRUE(player.finished());
}

TEST_F(PlayerTest, AnEmptyRangeEndsAlsoWhenLooping) {
  PlayerOptions options;
  options.loop = true;
  Player player = make(options, ChannelChoice({"NOBODY"}, ChannelChoice::Sense::keep));
  EXPECT_FALSE(player.advance(kNow));
  EXPECT_TRUE(player.finished());
}

TEST_F(PlayerTest, SilencesAreShortenedAndASleepingMachineCausesNoBurst) {
  {
    files::EventLogWriter writer(folder_ / "log");
    for (const int tenth : {0, 1, 6000, 6001, 5000, 5001}) {
      writer.write("A", pose_bytes(0, 0.0), at_s(0.1 * tenth));
    }
  }
  PlayerOptions options;
  options.longest_wait = Duration::from_seconds(2.0);
  Player player = make(options);
  player.advance(kNow);
  EXPECT_EQ(player.advance(kNow + 100000), kNow + 2'100'000);
  EXPECT_EQ(player.advance(kNow + 2'100'000), kNow + 2'200'000);
  EXPECT_THAT(take(), ElementsAre(0, 1, 6000));
  // Back in time by 100 s: at once, and on at the log's pace from there.
  EXPECT_EQ(player.advance(kNow + 2'200'000), kNow + 2'300'000);
  EXPECT_THAT(take(), ElementsAre(6001, 5000));

  write_poses(folder_ / "log", 20);
  Player sleepy = make();
  sleepy.advance(kNow);
  take();
  sleepy.advance(kNow + 60'000'000);
  EXPECT_THAT(take(), ElementsAre(1));
}

TEST_F(PlayerTest, DamageIsPassedOver) {
  std::string bytes = read_text(folder_ / "log");
  bytes[0] = 'x';
  write_text(folder_ / "log", bytes);
  Player player = make();
  run(player, kNow, kNow + 10'000'000);
  EXPECT_EQ(player.published(), 19);
  write_text(folder_ / "log", "no log");
  EXPECT_THROW(make(), std::invalid_argument);
}

TEST(ChannelRenames, TheFirstRuleThatFitsHolds) {
  const ChannelRenames renames({"LIDAR=SICK", "CAMERA_(.*)=CAM_$1", ".*_RAW=DROPPED"});
  EXPECT_EQ(renames("LIDAR"), "SICK");
  EXPECT_EQ(renames("LIDAR_REAR"), "LIDAR_REAR");
  EXPECT_EQ(renames("CAMERA_LEFT_RAW"), "CAM_LEFT_RAW");
  EXPECT_EQ(renames("LIDAR_RAW"), "DROPPED");
  for (const char* wrong : {"A", "=B", "A=", "(=B"}) {
    EXPECT_THROW(ChannelRenames({wrong}), std::invalid_argument) << wrong;
  }
}

TEST(Keys, AreTakenOneByOneWhateverArrivesTogether) {
  std::string typed = " x\x1b[C\x1b[5~q";
  EXPECT_EQ(take_key(typed), Key::pause);
  EXPECT_EQ(take_key(typed), Key::forward);  // x means nothing
  EXPECT_EQ(take_key(typed), Key::far_back);
  EXPECT_EQ(take_key(typed), Key::quit);
  EXPECT_EQ(take_key(typed), Key::none);
  typed = "\x1b[";
  EXPECT_EQ(take_key(typed), Key::none);
  typed += "D";
  EXPECT_EQ(take_key(typed), Key::back);
  EXPECT_TRUE(typed.empty());
  typed = "\x1b[24~s";  // F12: its bytes mean nothing, the key behind it does
  EXPECT_NE(take_key(typed), Key::none);
}

}  // namespace
}  // namespace marco::logs
