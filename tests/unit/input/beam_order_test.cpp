#include "common/input/beam_order.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

namespace marco {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pointwise;

constexpr double kTurnPeriodS = 0.2;

LaserScan four_beams(std::vector<float> times_s) {
  LaserScan scan;
  scan.ranges_m.assign(4, 2.0F);
  scan.bearing_step_rad = 0.5 * std::numbers::pi;
  scan.time_offsets_s = std::move(times_s);
  return scan;
}
const std::vector<float> kRight{0.0F, 0.05F, 0.10F, 0.15F};

/// What scans of a laser show that measures its beams in order `truth`.
class Scans {
 public:
  /// @param home  how much better than it should the present order fits: the map was made in it
  Scans(BeamOrder truth, std::vector<float> times_s, double home)
      : truth_(truth), times_s_(std::move(times_s)), home_(home) {}

  /// @returns the first thing found over so many scans
  std::optional<std::string> show(BeamOrderJudge& judge, int scans) {
    std::optional<std::string> found;
    for (int i = 0; i < scans && !found; ++i) {
      LaserScan scan = four_beams(times_s_);
      const BeamVerdict verdict = judge.look(scan, kTurnPeriodS);
      if (verdict.rivals.empty()) return found;
      std::vector<double> misfits_m2{misfit_m2(*verdict.order) * std::exp(-home_)};
      for (const BeamOrder rival : verdict.rivals) misfits_m2.push_back(misfit_m2(rival));
      if (judge.note(verdict, misfits_m2)) found = judge.description();
    }
    return found;
  }

 private:
  // How many directions an order is off: forwards, at once, backwards.
  static int place(BeamOrder order) {
    return order == BeamOrder::forwards ? 1 : order == BeamOrder::backwards ? -1 : 0;
  }
  double misfit_m2(BeamOrder order) {
    const int off = std::abs(place(order) - place(truth_));
    return 1e-3 * std::exp(0.1 * off * off + 0.2 * normal_(random_));
  }

  BeamOrder truth_;
  std::vector<float> times_s_;
  double home_;
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_{0.0, 1.0};
};

TEST(ReorderedTimes, ThatSpanATurnAreTurnedRound) {
  const auto times_s = [](BeamOrder order) {
    return reordered_times_s(four_beams(kRight), kTurnPeriodS, BeamOrder::forwards, order);
  };
  EXPECT_THAT(times_s(BeamOrder::forwards), Pointwise(FloatNear(1e-6F), kRight));
  EXPECT_THAT(times_s(BeamOrder::backwards),
              Pointwise(FloatNear(1e-6F), {0.15F, 0.10F, 0.05F, 0.0F}));
  EXPECT_THAT(times_s(BeamOrder::at_once), Pointwise(FloatNear(1e-6F), {0.0F, 0.0F, 0.0F, 0.0F}));
}

TEST(ReorderedTimes, ThatAreMissingOrEqualAreSpreadFromTheStampOn) {
  for (const float stamp_s : {0.0F, 0.1F}) {
    const auto times_s = [stamp_s](BeamOrder order) {
      const std::vector<float> told_s(stamp_s > 0.0F ? 4 : 0, stamp_s);
      return reordered_times_s(four_beams(told_s), kTurnPeriodS, BeamOrder::at_once, order);
    };
    EXPECT_THAT(
        times_s(BeamOrder::forwards),
        Pointwise(FloatNear(1e-6F), {stamp_s, stamp_s + 0.05F, stamp_s + 0.1F, stamp_s + 0.15F}));
    EXPECT_THAT(
        times_s(BeamOrder::backwards),
        Pointwise(FloatNear(1e-6F), {stamp_s + 0.15F, stamp_s + 0.1F, stamp_s + 0.05F, stamp_s}));
  }
}

TEST(BeamOrderJudge, FindsTheDirectionOfBeamsWithoutTimes) {
  for (const std::vector<float>& times_s : {std::vector<float>{}, std::vector<float>(4, 0.1F)}) {
    BeamOrderJudge judge;
    EXPECT_THAT(Scans(BeamOrder::forwards, times_s, 0.15).show(judge, 100).value_or(""),
                HasSubstr("first to last"));
    LaserScan scan = four_beams(times_s);
    EXPECT_EQ(judge.look(scan, kTurnPeriodS).order, BeamOrder::forwards);
    EXPECT_NEAR(scan.time_offsets_s.back() - scan.time_offsets_s.front(), 0.15, 1e-6);
    BeamOrderJudge other;
    EXPECT_THAT(Scans(BeamOrder::backwards, times_s, 0.15).show(other, 100).value_or(""),
                HasSubstr("last to first"));
  }
}

TEST(BeamOrderJudge, ReversesTimesThatRunBackwards) {
  BeamOrderJudge judge;
  EXPECT_THAT(Scans(BeamOrder::backwards, kRight, 0.1).show(judge, 100).value_or(""),
              HasSubstr("backwards: reversed"));
  LaserScan scan = four_beams(kRight);
  judge.look(scan, kTurnPeriodS);
  EXPECT_THAT(scan.time_offsets_s, Pointwise(FloatNear(1e-6F), {0.15F, 0.10F, 0.05F, 0.0F}));
}

// Jitter: no turn fits between the first two stamps.
TEST(BeamOrderJudge, JudgesOnWhenThePeriodWasTooShortAtFirst) {
  BeamOrderJudge judge;
  LaserScan first = four_beams(kRight);
  ASSERT_EQ(judge.look(first, 0.4 * kTurnPeriodS).order, BeamOrder::at_once);
  EXPECT_THAT(Scans(BeamOrder::backwards, kRight, 0.1).show(judge, 100).value_or(""),
              HasSubstr("backwards: reversed"));
}

TEST(BeamOrderJudge, LeavesRightTimesAndStopsJudging) {
  for (const double home : {0.0, 0.1}) {
    BeamOrderJudge judge;
    EXPECT_FALSE(Scans(BeamOrder::forwards, kRight, home).show(judge, 400));
    LaserScan scan = four_beams(kRight);
    EXPECT_THAT(judge.look(scan, kTurnPeriodS).rivals, IsEmpty());
    EXPECT_EQ(scan.time_offsets_s, kRight);
  }
}

TEST(BeamOrderJudge, LeavesBeamsThatAreMeasuredAtOnce) {
  BeamOrderJudge judge;
  EXPECT_FALSE(Scans(BeamOrder::at_once, {}, 0.0).show(judge, 400));
  LaserScan scan = four_beams({});
  EXPECT_THAT(judge.look(scan, kTurnPeriodS).rivals, IsEmpty());
  EXPECT_THAT(scan.time_offsets_s, IsEmpty());
}

TEST(BeamOrderJudge, TakesBackWhatItFoundByChance) {
  BeamOrderJudge judge;
  ASSERT_TRUE(Scans(BeamOrder::forwards, {}, 0.0).show(judge, 100));
  EXPECT_THAT(Scans(BeamOrder::at_once, {}, 0.0).show(judge, 300).value_or(""),
              HasSubstr("unchanged"));
}

TEST(BeamOrderJudge, SaysNothingOfFewScans) {
  BeamOrderJudge judge;
  EXPECT_FALSE(Scans(BeamOrder::backwards, kRight, 0.0).show(judge, 19));
}

TEST(BeamOrderJudge, JudgesNoLaserThatSeesOneSideNorAnUnknownPeriod) {
  BeamOrderJudge judge;
  LaserScan side = four_beams({}), unknown = four_beams({});
  side.bearing_step_rad *= 0.7;
  EXPECT_THAT(judge.look(side, kTurnPeriodS).rivals, IsEmpty());
  EXPECT_THAT(judge.look(unknown, 0.0).rivals, IsEmpty());
  EXPECT_THAT(judge.look(unknown, kTurnPeriodS).rivals,
              ElementsAre(BeamOrder::forwards, BeamOrder::backwards));
}

TEST(BeamOrderJudge, IgnoresScansOfAnotherOrderThanThePresent) {
  BeamOrderJudge judge;
  LaserScan scan = four_beams({});
  BeamVerdict waited = judge.look(scan, kTurnPeriodS);
  waited.order = BeamOrder::backwards;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(judge.note(waited, {1e-3, 1e-4 * (1 + i % 3), 1e-2}));
}

}  // namespace
}  // namespace marco
