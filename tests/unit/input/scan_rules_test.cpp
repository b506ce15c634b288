// What the rules take out of scans, and what they say and count of it.
#include <gmock/gmock.h>

#include <numbers>
#include <random>

#include "tests/unit/input/sensor_synchronizer_fixture.hpp"

namespace marco {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

class ScanRulesTest : public SensorSynchronizerTest {
 protected:
  void calibrate(const SensorCalibration& calibration) {
    SynchronizerOptions options;
    options.calibration = calibration;
    input_ = SensorSynchronizer(options, {channels::kPanTiltState, &channels::lidar_of},
                                [this](const std::string& cause) { ++drops_[cause]; });
    announce(channels::kLidar);
    announce("LIDAR_REAR");
  }
  /// A beam a degree, all round.
  static LaserScan turn(double seconds, float range_m) {
    LaserScan scan;
    scan.utime = Utime::from_seconds(seconds);
    scan.ranges_m.assign(360, range_m);
    scan.bearing_step_rad = deg_to_rad(1.0);
    return scan;
  }
  /// What becomes of a scan that both lasers take at once.
  std::vector<SynchronizedScan> of_two_lasers(float range_m) {
    LaserScan ahead = turn(0.1, range_m), rear = ahead;
    rear.channel = "LIDAR_REAR";
    input_.add(std::move(ahead));
    input_.add(std::move(rear));
    return take();
  }
  RuleCount count_of(const std::string& rule) const {
    for (const auto& [name, count] : input_.rules().counts()) {
      if (name == rule) return count;
    }
    ADD_FAILURE() << rule;
    return {};
  }
};

TEST_F(ScanRulesTest, TheKnownBodyOfOneLaserIsTakenOutOfItsScansAlone) {
  SensorCalibration calibration;
  calibration.body = {{channels::kLidar, 10.0, 19.0, 0.5}, {channels::kLidar, 40.0, 44.0, 0.5}};
  calibrate(calibration);
  const auto scans = of_two_lasers(0.3F);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[0].scan.ranges_m[15], 0.0F);
  EXPECT_EQ(scans[0].scan.ranges_m[30], 0.3F);
  EXPECT_EQ(scans[0].scan.ranges_m[42], 0.0F);
  EXPECT_EQ(scans[1].scan.ranges_m, std::vector<float>(360, 0.3F));
  EXPECT_EQ(count_of("without known body").returns, 12 + 7);
  EXPECT_EQ(count_of("without known body").scans, 0);
}

TEST_F(ScanRulesTest, TheFloorOfOneLaserIsTakenOutOfItsScansAlone) {
  SensorCalibration calibration;
  calibration.floor = {{channels::kLidar, 0.0, 2.9}, {channels::kLidar, 180.0, 2.9}};
  calibrate(calibration);
  const auto scans = of_two_lasers(3.0F);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[0].scan.ranges_m[0], 0.0F);
  EXPECT_EQ(scans[0].scan.ranges_m[90], 3.0F);
  EXPECT_EQ(scans[1].scan.ranges_m, std::vector<float>(360, 3.0F));
  EXPECT_EQ(count_of("without floor").returns, 2 * 29);  // within 14.8 deg on either side
}

TEST_F(ScanRulesTest, TheBeamsOfOneLaserAreCorrectedInItsScansAlone) {
  SensorCalibration calibration;
  calibration.beams = {{channels::kLidar, 1.0, 0.5}};
  calibrate(calibration);
  const auto scans = of_two_lasers(3.0F);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[0].scan.ranges_m[7], 3.5F);
  EXPECT_EQ(scans[1].scan.ranges_m[7], 3.0F);
}

// A robot drives about; a post, and later a second one, is in view.
TEST_F(ScanRulesTest, ThePostsOfTheRobotAreReportedOnceAndTakenOut) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> changing(1.5F, 9.0F);
  for (int i = 0; i < 100; ++i) {
    LaserScan scan = turn(0.1 * i, 0.0F);
    for (float& range_m : scan.ranges_m) range_m = changing(random);
    for (std::size_t beam = 20; beam < 30; ++beam) scan.ranges_m[beam] = 0.3F;
    for (std::size_t beam = 80; beam < 90 && i > 50; ++beam) scan.ranges_m[beam] = 0.4F;
    input_.add(std::move(scan));
  }
  const auto scans = take();
  ASSERT_EQ(scans.size(), 100U);
  EXPECT_EQ(scans[10].scan.ranges_m[25], 0.3F);
  EXPECT_EQ(scans[99].scan.ranges_m[25], 0.0F);
  EXPECT_EQ(scans[99].scan.ranges_m[85], 0.0F);
  EXPECT_THAT(drops_, ElementsAre(Pair(HasSubstr("20 to 30 deg"), 1)));
  const int64_t returns = count_of("without own body").returns;
  EXPECT_GE(returns, 80 * 10 + 29 * 10);
  EXPECT_LE(returns, 80 * 12 + 30 * 12);
}

TEST_F(ScanRulesTest, OfALaserOnAPanTiltNothingIsTakenForTheRobot) {
  announce(channels::kLidar, SensorInfo::Mount::pantilt);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> changing(1.5F, 9.0F);
  for (int i = 0; i < 60; ++i) {
    LaserScan scan = turn(0.1 * i, 0.0F);
    for (float& range_m : scan.ranges_m) range_m = changing(random);
    for (std::size_t beam = 20; beam < 30; ++beam) scan.ranges_m[beam] = 0.3F;
    input_.add(std::move(scan));
  }
  EXPECT_EQ(count_of("without own body").returns, 0);
  EXPECT_TRUE(drops_.empty());
}

TEST_F(ScanRulesTest, ScansInMillimetresAreNotUsedOnceThatIsKnown) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> millimetres(1000.0F, 5000.0F);
  for (int i = 0; i < 25; ++i) {
    LaserScan scan = turn(0.1 * i, 0.0F);
    for (float& range_m : scan.ranges_m) range_m = millimetres(random);
    input_.add(std::move(scan));
  }
  EXPECT_EQ(take().size(), 19U);
  EXPECT_THAT(drops_, ElementsAre(Pair(HasSubstr("millimetres"), 6)));
  EXPECT_EQ(count_of("ranges in metres").scans, 6);
}

TEST_F(ScanRulesTest, TheCountsAreThoseOfEachRuleInTheirOrder) {
  scan(0.1, "LIDAR_UNKNOWN");
  for (const double seconds : {0.1, 0.2, 0.2}) scan(seconds);
  const auto counts = input_.rules().counts();
  ASSERT_EQ(counts.size(), 12U);
  EXPECT_EQ(counts[0].first, "announced");
  EXPECT_EQ(counts[0].second.scans, 1);
  EXPECT_EQ(counts[1].first, "not repeated");
  EXPECT_EQ(counts[1].second.scans, 1);
  EXPECT_EQ(counts[11].first, "beams ordered");
  EXPECT_EQ(counts[11].second.scans, 0);
}

// A stalled logger's.
TEST_F(ScanRulesTest, TwoScansOfOneStampThatDifferAreTwo) {
  LaserScan other = turn(0.1, 3.0F);
  other.ranges_m.back() = 4.0F;
  input_.add(turn(0.1, 3.0F));
  input_.add(other);
  EXPECT_EQ(take().size(), 2U);
  EXPECT_TRUE(drops_.empty());
}

TEST_F(ScanRulesTest, BeamTimesInAWrongUnitAreToldOnce) {
  for (int i = 0; i < 20; ++i) {
    LaserScan scan = turn(0.1 * i, 3.0F);
    for (int beam = 0; beam < 360; ++beam) {
      scan.time_offsets_s.push_back(static_cast<float>(1e-6 * 0.1 * beam / 360));
    }
    input_.add(std::move(scan));
  }
  const auto scans = take();
  ASSERT_GT(scans.size(), 15U);
  EXPECT_NEAR(scans[15].scan.time_offsets_s.back(), 0.1 * 359 / 360, 1e-4);
  EXPECT_THAT(drops_, ElementsAre(Pair(HasSubstr("LIDAR: beam times 1000000 times too short"), 1)));
}

// Its beam times are known; of another one, or where the scans have their own, they are judged.
TEST_F(ScanRulesTest, BeamsOfALaserThatSaysHowLongItsScanTakesAreNotJudged) {
  for (const bool says : {true, false}) {
    for (const bool times : {false, true}) {
      const std::string channel = std::string("LIDAR_") + (says ? "A" : "B") + (times ? "C" : "D");
      announce(channel, SensorInfo::Mount::robot, says ? 0.1 : 0.0);
      for (int i = 0; i < 5; ++i) {
        LaserScan scan = turn(0.1 * i, 3.0F + static_cast<float>(i));
        scan.channel = channel;
        if (times) scan.time_offsets_s.assign(360, 0.0F);
        input_.add(std::move(scan));
      }
      input_.complete_all();
      const auto scans = take();
      ASSERT_EQ(scans.size(), 5U);
      EXPECT_EQ(scans[4].beam_order.order.has_value(), times || !says) << channel;
    }
  }
}

// A driver without beam times; the map tells in which order its beams are measured.
TEST_F(ScanRulesTest, TheOrderThatIsFoundIsToldAndUsedFromThenOn) {
  std::optional<BeamOrder> found;
  for (int i = 0; i < 60 && !found; ++i) {
    input_.add(turn(0.1 * i, 3.0F));
    for (const SynchronizedScan& scan : take()) {
      EXPECT_FALSE(input_.note_misfits(scan, {}));
      if (scan.beam_order.rivals.empty()) continue;  // the period is not known yet
      EXPECT_FALSE(found);
      found = input_.note_misfits(scan, {1.5e-3, 1e-3 * (i % 2 == 0 ? 1.02 : 0.98), 3e-3});
    }
  }
  ASSERT_EQ(found, BeamOrder::forwards);
  EXPECT_THAT(drops_, ElementsAre(Pair(HasSubstr("LIDAR: beam times missing"), 1)));
  input_.add(turn(6.1, 3.0F));
  const auto scans = take();
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].scan.time_offsets_s.size(), 360U);
}

}  // namespace
}  // namespace marco
