#include "slam/doctor/doctor.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/matchers.hpp"
#include "tests/support/two_rounds.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;
using ::marco::testing::TwoRounds;

TEST(Doctor, ARightMapIsGood) {
  const Diagnosis diagnosis = examine(TwoRounds().map);
  EXPECT_EQ(diagnosis.verdict, Verdict::good);
  EXPECT_TRUE(diagnosis.reasons.empty());
  EXPECT_TRUE(diagnosis.figures.has_odometry);
  EXPECT_GT(diagnosis.figures.confirmed_keyframes, 0.3);
}

TEST(Doctor, ADoubledRoomIsWrongAndTheLoopThatMendsItIsNamed) {
  const TwoRounds rounds({0.8, 0.3, 0.1});
  const Diagnosis diagnosis = examine(rounds.map);
  ASSERT_EQ(diagnosis.verdict, Verdict::wrong);
  const Reason& worst = diagnosis.reasons.front();
  EXPECT_EQ(worst.cause, Reason::Cause::contradiction);
  EXPECT_GE(worst.from, rounds.map.keys[TwoRounds::kOfRound].utime);
  ASSERT_FALSE(worst.remedies.empty());
  const MapEdit& remedy = worst.remedies.front();
  ASSERT_EQ(remedy.kind, MapEdit::Kind::add_loop);
  const auto key_at = [](Utime utime) { return static_cast<int>(utime.us / 1'000'000); };
  EXPECT_THAT(remedy.from_from_to, IsNear(between(TwoRounds::place(key_at(remedy.from)),
                                                  TwoRounds::place(key_at(remedy.to))),
                                          0.02, 0.01));
}

TEST(Doctor, APassOverAMovedBoxIsGood) {
  testing::FlatWorld moved = testing::small_room();
  moved.add_box(-3.2, -2.4, -2.6, -1.8);
  EXPECT_EQ(examine(TwoRounds({}, moved).map).verdict, Verdict::good);
}

TEST(Doctor, ScansThatAreNotFoundOnTheMapSpeakAgainstIt) {
  TwoRounds rounds;
  rounds.map.scans = 100;
  rounds.map.matched_scans = 85;
  EXPECT_EQ(examine(rounds.map).verdict, Verdict::good);
  rounds.map.matched_scans = 75;
  EXPECT_EQ(examine(rounds.map).verdict, Verdict::doubtful);
  // A log whose scans see too little makes no map at all.
  MapEvidence nothing;
  nothing.paths = rounds.map.paths;
  nothing.scans = 100;
  const Diagnosis diagnosis = examine(nothing);
  EXPECT_EQ(diagnosis.verdict, Verdict::wrong);
  ASSERT_EQ(diagnosis.reasons.size(), 1U);
  EXPECT_EQ(diagnosis.reasons[0].cause, Reason::Cause::unmatched_scans);
  EXPECT_EQ(diagnosis.reasons[0].to, rounds.map.keys.back().utime);
}

// A laser that sees 5 m, in a hall: wheels alone carry the path.
TEST(Doctor, ScansThatSeeNothingAreNoneThatContradict) {
  TwoRounds rounds;
  rounds.map.scans = rounds.map.matched_scans = 60;
  rounds.map.blind_scans = 40;
  EXPECT_EQ(examine(rounds.map).verdict, Verdict::good);
  rounds.map.blind_scans = 140;
  const Diagnosis diagnosis = examine(rounds.map);
  EXPECT_EQ(diagnosis.verdict, Verdict::doubtful);
  EXPECT_NEAR(diagnosis.figures.blind, 0.7, 1e-12);
  MapEvidence nothing;
  nothing.blind_scans = 100;
  EXPECT_EQ(examine(nothing).verdict, Verdict::wrong);
}

TEST(Doctor, TwoKindsOfReasonsMakeAMapWrong) {
  TwoRounds rounds;
  rounds.map.scans = 100;
  rounds.map.matched_scans = 75;
  rounds.map.edges[59].information = information_of(diagonal_covariance(0.6, deg_to_rad(0.15)));
  rounds.map.paths[0].odometry.clear();
  EXPECT_EQ(examine(rounds.map).verdict, Verdict::wrong);
}

TEST(Doctor, NothingSeenIsNothingAgainstIt) {
  EXPECT_EQ(examine({}).verdict, Verdict::good);
  MapEvidence one;
  one.keys.push_back(TwoRounds().map.keys.front());
  EXPECT_EQ(examine(one).verdict, Verdict::good);
}

TEST(Doctor, NamesAreThoseOfTheReport) {
  EXPECT_STREQ(to_string(Verdict::doubtful), "doubtful");
  EXPECT_STREQ(to_string(Reason::Cause::odometry_break), "odometry_break");
}

}  // namespace
}  // namespace marco::slam
