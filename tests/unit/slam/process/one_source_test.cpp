// Another robot's scans on our own channel: left out; and nothing of our own ever is.
#include "slam/process/one_source.hpp"

#include <gmock/gmock.h>

#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::FlatWorld;
using ::marco::testing::small_room;
using ::testing::ElementsAreArray;

constexpr double kPeriodS = 1.0 / 37.5;

class OneSourceTest : public ::testing::Test {
 protected:
  OneSourceTest() {
    other_room_.add_box(-1.2, -9.0, 1.2, 14.0);
    other_room_.add_box(-1.2, 3.0, -0.4, 4.0);
  }
  LaserScan scan_at(double at_s, const Pose2& robot, const FlatWorld& room) {
    LaserScan scan = room.scan(robot, 0.01, &random_);
    scan.utime = Utime::from_us(1'000'000) + Duration::from_seconds(at_s);
    return scan;
  }
  /// Our robot drives and turns.
  LaserScan own_at(double at_s) {
    return scan_at(at_s, {-2.0 + 0.4 * at_s, -1.5, 0.5 * at_s}, room_);
  }
  LaserScan other_at(double at_s) { return scan_at(at_s, {0.0, 6.0 - at_s, 1.0}, other_room_); }
  void give(const LaserScan& scan) {
    OneSource::Sorted sorted = source_.take(scan);
    foreign_ += sorted.foreign;
    off_beat_ += sorted.off_beat;
    for (const LaserScan& own : sorted.own) taken_.push_back(own.utime.us);
  }
  void give_own(const LaserScan& scan) {
    given_.push_back(scan.utime.us);
    give(scan);
  }
  std::mt19937 random_{4};
  FlatWorld room_ = small_room(), other_room_;
  OneSource source_;
  std::vector<int64_t> given_, taken_;
  int foreign_ = 0, off_beat_ = 0;
};

TEST_F(OneSourceTest, AnotherRobotsScansAreLeftOutAndAllOfOursAreTaken) {
  std::uniform_int_distribution<int> burst(0, 3);
  int others = 0;
  for (int i = 0; i < 150; ++i) {
    give_own(own_at(kPeriodS * i));
    if (i < 20) continue;
    for (int more = burst(random_); more > 0; --more, ++others) {
      give(other_at(kPeriodS * i + 0.003 * more));
    }
  }
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_GT(others, 150);
  EXPECT_NEAR(foreign_, others, 3);  // the last ones still wait
}

// On a pan-tilt, or past a door: what it sees changes at once, and back.
TEST_F(OneSourceTest, ScansOfOursThatLookElsewhereAreKept) {
  for (int i = 0; i < 98; ++i) {
    const double at_s = kPeriodS * i;
    const bool away = i > 20 && i % 7 < 3;
    give_own(away ? scan_at(at_s, {0.0, 6.0, 1.0 + 0.2 * i}, other_room_) : own_at(at_s));
  }
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_EQ(foreign_, 0);
}

// A tilt from the floor to the ceiling within a second: no scan looks like the one before.
TEST_F(OneSourceTest, ATiltedLasersScansComeLateButAll) {
  for (int i = 0; i < 100; ++i) {
    const double at_s = kPeriodS * i;
    const bool tilts = i > 20 && i < 60;
    const FlatWorld& seen = i % 2 == 0 ? other_room_ : room_;
    give_own(tilts ? scan_at(at_s, {0.0, 2.5 - 0.1 * (i * 7 % 23), 0.9 * i}, seen) : own_at(at_s));
  }
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_EQ(foreign_, 0);
}

// It drives through our place, and its scans come earlier than ours of the same moment; one of them
// is believed, as it looks like ours.
TEST_F(OneSourceTest, AnotherRobotWhereWeAreDoesNotTakeOurPlace) {
  std::vector<int64_t> strays;
  for (int i = 0; i < 120; ++i) {
    const double at_s = kPeriodS * i;
    if (i == 40) {
      LaserScan stray = own_at(at_s);
      stray.utime = stray.utime + Duration::from_seconds(0.15 * kPeriodS);
      strays.push_back(stray.utime.us);
      give(stray);
    }
    give_own(own_at(at_s));
    if (i >= 40 && i % 2 == 0) {
      give(scan_at(at_s + 0.013, {0.0, 6.0 - 0.2 * (i * 7 % 50), 1.0}, other_room_));
    }
  }
  std::erase_if(taken_, [&](int64_t utime) { return utime == strays[0]; });
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_GE(foreign_, 35);
}

// Ours is silent, two others are not: together they keep no rhythm.
TEST_F(OneSourceTest, ScansWithoutARhythmAreNotTakenForARestart) {
  for (int i = 0; i < 40; ++i) give_own(own_at(kPeriodS * i));
  for (int i = 40; i < 120; ++i) {
    const FlatWorld& place = i % 2 == 0 ? other_room_ : room_;
    give(scan_at(kPeriodS * (i + (i % 2 == 0 ? 0.4 : 0.0)),
                 {0.1 * (i % 5), 2.0 - 0.1 * (i * 7 % 23), 0.9 * i}, place));
  }
  EXPECT_THAT(taken_, ElementsAreArray(given_));
}

// The computer was busy for a moment, and stamps the next half second's scans late, now more, now
// less; then one comes on the old beat again.
TEST_F(OneSourceTest, ScansThatAreStampedLateForAWhileAreKept) {
  std::uniform_real_distribution<double> late(0.25, 0.40);
  for (int i = 0; i < 120; ++i) {
    const bool is_late = i >= 40 && i < 56;
    LaserScan scan = own_at(kPeriodS * i);
    if (is_late) scan.utime = scan.utime + Duration::from_seconds(late(random_) * kPeriodS);
    give_own(scan);
  }
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_EQ(foreign_, 0);
}

// A simulated laser that fell behind hurries: nothing tells its scans from those of a robot beside
// us.
TEST_F(OneSourceTest, ScansOffTheBeatThatLookLikeOursAreNotBlamedOnAnotherLaser) {
  for (int i = 0; i < 80; ++i) {
    give_own(own_at(kPeriodS * i));
    if (i >= 40 && i < 45) give(own_at(kPeriodS * (i + 0.5)));
  }
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_EQ(foreign_, 0);
  EXPECT_EQ(off_beat_, 5);
}

// On our own laser's beat, with its very ranges: only their number tells.
TEST_F(OneSourceTest, AnotherLasersScansOfAnotherShapeAreAnotherLasers) {
  for (int i = 0; i < 60; ++i) {
    if (i % 5 != 4) {
      give_own(own_at(kPeriodS * i));
    } else if (i > 20) {
      LaserScan small = own_at(kPeriodS * i);
      small.ranges_m.resize(181);
      give(small);
    }
  }
  give_own(own_at(kPeriodS * 60));
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_EQ(foreign_, 8);
}

// Half the scans lost, stamps in bursts of three, 2 rad/s: nothing of it is another's, nor waits.
TEST_F(OneSourceTest, NothingOfOursIsLeftOut) {
  std::bernoulli_distribution lost(0.5);
  for (int i = 0; i < 200; ++i) {
    if (lost(random_)) continue;
    const double at_s = kPeriodS * i;
    LaserScan scan = scan_at(at_s, {0.5, 0.3, 2.0 * at_s}, room_);
    scan.utime = Utime::from_us(1'000'000) + Duration::from_seconds(kPeriodS * (i / 3 * 3));
    give_own(scan);
    EXPECT_EQ(taken_.size(), given_.size()) << i;
  }
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_EQ(foreign_, 0);
}

// The driver was away for 4 s while the robot drove on; or the clock was set by an hour.
TEST_F(OneSourceTest, ARestartedDriverIsTakenAgainWithinASecondAndNoScanIsLost) {
  for (int i = 0; i < 40; ++i) give_own(own_at(kPeriodS * i));
  const int restarted = 40 + 150;
  int late = 0;
  for (int i = restarted; i < restarted + 40; ++i) {
    LaserScan scan = scan_at(kPeriodS * i, {2.8, 1.5, 2.5 + 0.02 * (i - restarted)}, room_);
    scan.utime = scan.utime + Duration::from_seconds(3600.0);
    give_own(scan);
    late += taken_.back() < given_.back() ? 1 : 0;
  }
  EXPECT_GT(late, 0);
  EXPECT_LE(late * kPeriodS, 0.6);
  EXPECT_THAT(taken_, ElementsAreArray(given_));
  EXPECT_EQ(foreign_, 0);
}

TEST_F(OneSourceTest, ASlowLasersScansAreAllTakenAtOnce) {
  for (int i = 0; i < 30; ++i) {
    give_own(i % 2 == 0 ? own_at(0.3 * i) : other_at(0.3 * i));
    ASSERT_EQ(taken_.size(), given_.size());
  }
}

TEST_F(OneSourceTest, AtTheEndWhatWaitsIsGivenBack) {
  for (int i = 0; i < 20; ++i) give_own(own_at(kPeriodS * i));
  give(other_at(kPeriodS * 20));
  EXPECT_EQ(taken_.size(), 20U);
  EXPECT_EQ(source_.rest().size(), 1U);
  EXPECT_TRUE(source_.rest().empty());
}

}  // namespace
}  // namespace marco::slam
