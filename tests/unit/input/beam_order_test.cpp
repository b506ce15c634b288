#include "common/input/beam_order.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
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
  EXPECT_THAT(judge.look(scan, kTurnPeriodS).rivals, IsEmpty()) << "that is sure";
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
    EXPECT_FALSE(Scans(BeamOrder::forwards, kRight, home).show(judge, home > 0.0 ? 100 : 300));
    LaserScan scan = four_beams(kRight), without = four_beams({});
    EXPECT_THAT(judge.look(scan, kTurnPeriodS).rivals, IsEmpty());
    EXPECT_EQ(scan.time_offsets_s, kRight);
    EXPECT_FALSE(judge.look(without, kTurnPeriodS).order) << "one that lost its times";
    EXPECT_THAT(judge.look(scan, kTurnPeriodS).rivals, IsEmpty());
  }
}

TEST(BeamOrderJudge, LeavesBeamsThatAreMeasuredAtOnce) {
  BeamOrderJudge judge;
  EXPECT_FALSE(Scans(BeamOrder::at_once, {}, 0.0).show(judge, 400));
  LaserScan scan = four_beams({});
  EXPECT_THAT(judge.look(scan, kTurnPeriodS).rivals, IsEmpty());
  EXPECT_THAT(scan.time_offsets_s, IsEmpty());
  BeamOrderJudge sooner;
  EXPECT_FALSE(Scans(BeamOrder::at_once, {}, 0.3).show(sooner, 60));
  EXPECT_THAT(sooner.look(scan, kTurnPeriodS).rivals, IsEmpty());
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

// In which of so many alike scans another order is found.
std::optional<int> found_at(BeamOrderJudge& judge,
                            const std::vector<float>& times_s,
                            int scans,
                            const std::function<std::vector<double>(int)>& misfits_m2) {
  for (int i = 0; i < scans; ++i) {
    LaserScan scan = four_beams(times_s);
    if (judge.note(judge.look(scan, kTurnPeriodS), misfits_m2(i))) return i;
  }
  return std::nullopt;
}
double noise(int i) { return i % 2 == 0 ? 1.01 : 0.99; }

TEST(BeamOrderJudge, TwentyScansThatAgreeAreEnough) {
  BeamOrderJudge judge;
  EXPECT_EQ(found_at(judge, kRight, 100,
                     [](int i) {
                       return std::vector{3e-3 * noise(i), 1e-3, 2e-3};
                     }),
            19);
  EXPECT_EQ(judge.present(), BeamOrder::backwards);
}

TEST(BeamOrderJudge, OfARivalThatIsWorseTheOtherIsJudgedOn) {
  for (const bool backwards : {false, true}) {
    BeamOrderJudge judge;
    const auto misfits_m2 = [&](int i) {
      const double little = 0.9e-3 * (i % 2 == 0 ? 1.35 : 0.74), much = 2e-3 * noise(i);
      return backwards ? std::vector{1e-3, little, much} : std::vector{1e-3, much, little};
    };
    EXPECT_GT(found_at(judge, kRight, 250, misfits_m2).value_or(-1), 20);
    EXPECT_EQ(judge.present(), backwards ? BeamOrder::backwards : BeamOrder::at_once);
  }
}

// Were it measured in the better one's direction, that would have fitted nearly as well.
TEST(BeamOrderJudge, OfTwoDirectionsThatBothFitWorseNoneIsTaken) {
  BeamOrderJudge judge;
  EXPECT_FALSE(found_at(judge, {}, 400, [](int i) {
    return std::vector{1e-3, 1.35e-3 * noise(i), 1.5e-3};
  }));
}

TEST(BeamOrderJudge, TheDirectionThatLosesLessThanHalfOfWhatTheOtherDoesIsTaken) {
  for (const bool forwards : {true, false}) {
    BeamOrderJudge judge;
    EXPECT_TRUE(found_at(judge, {}, 100, [=](int i) {
      const double less = 1.185e-3 * noise(i), more = 1.5e-3;
      return forwards ? std::vector{1e-3, less, more} : std::vector{1e-3, more, less};
    }));
    EXPECT_EQ(judge.present(), forwards ? BeamOrder::forwards : BeamOrder::backwards);
  }
}

TEST(BeamOrderJudge, AScanThatFitsPerfectlyTellsNothing) {
  BeamOrderJudge judge;
  EXPECT_FALSE(found_at(judge, kRight, 100, [](int i) {
    return std::vector{1e-3 * noise(i), 0.0, 2e-3};
  }));
  LaserScan scan = four_beams(kRight);
  EXPECT_THAT(judge.look(scan, kTurnPeriodS).rivals,
              ElementsAre(BeamOrder::backwards, BeamOrder::at_once));
}

// Neither stops what is found: it may still be taken back.
TEST(BeamOrderJudge, ScansWithTimesAmongThoseWithoutAreLeftAsTheyAre) {
  BeamOrderJudge judge;
  ASSERT_TRUE(Scans(BeamOrder::forwards, {}, 0.15).show(judge, 100));
  LaserScan with = four_beams(kRight), without = four_beams({});
  EXPECT_FALSE(judge.look(with, kTurnPeriodS).order);
  EXPECT_EQ(with.time_offsets_s, kRight);
  EXPECT_EQ(judge.look(without, kTurnPeriodS).order, BeamOrder::forwards);
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
