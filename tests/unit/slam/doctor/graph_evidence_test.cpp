#include "slam/doctor/graph_evidence.hpp"

#include <gtest/gtest.h>

#include "tests/support/two_rounds.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::TwoRounds;

Diagnosis examined(const MapEvidence& map) {
  Diagnosis diagnosis;
  diagnosis.figures.has_odometry = true;
  examine_graph(map, diagnosis);
  return diagnosis;
}

const Reason* find(const Diagnosis& diagnosis, Reason::Cause cause) {
  for (const Reason& reason : diagnosis.reasons) {
    if (reason.cause == cause) return &reason;
  }
  return nullptr;
}

Pose2 true_relation(int from, int to) {
  return between(TwoRounds::place(from), TwoRounds::place(to));
}

TEST(GraphEvidence, LoopsThatFitAreNoReason) {
  TwoRounds rounds;
  for (const int key : {0, 10, 20, 30})
    rounds.add_loop(key, 40 + key, true_relation(key, 40 + key), true);
  const Diagnosis diagnosis = examined(rounds.map);
  EXPECT_TRUE(diagnosis.reasons.empty());
  EXPECT_NEAR(diagnosis.figures.loop_surprise, 0.0, 1e-9);
  // No step is known worse than its edge says.
  EXPECT_LT(diagnosis.figures.joint_m, 0.0101);
}

TEST(GraphEvidence, RefusedLoopsThatWouldMendTheMapAreAReasonAndTheirOwnRemedy) {
  TwoRounds rounds({0.8, 0.3, 0.1});
  rounds.add_loop(5, 45, true_relation(5, 45), false);
  EXPECT_TRUE(examined(rounds.map).reasons.empty());  // one may be the search's mistake
  rounds.add_loop(6, 46, true_relation(6, 46), false);
  rounds.map.loops.back().overlap = 0.7;
  const Diagnosis diagnosis = examined(rounds.map);
  ASSERT_EQ(diagnosis.reasons.size(), 1U);
  const Reason& reason = diagnosis.reasons[0];
  EXPECT_EQ(reason.cause, Reason::Cause::refused_loops);
  EXPECT_EQ(diagnosis.figures.refused_loops, 2);
  EXPECT_GT(diagnosis.figures.refused_loop_m, 0.5);
  ASSERT_EQ(reason.remedies.size(), 1U);
  EXPECT_EQ(reason.remedies[0].kind, MapEdit::Kind::add_loop);
  EXPECT_EQ(reason.remedies[0].from, rounds.map.keys[5].utime);
  EXPECT_NEAR(reason.remedies[0].from_from_to.x_m, true_relation(5, 45).x_m, 1e-12);
}

// Rooms that look alike give loops that are rightly refused.
TEST(GraphEvidence, LoopsThatWouldSpoilTheMapAreRightlyRefused) {
  TwoRounds rounds;
  for (const int key : {5, 6, 7}) {
    rounds.add_loop(key, 40 + key, true_relation(key, 40 + key) * Pose2{0.8, 0.0, 0.0}, false);
  }
  EXPECT_TRUE(examined(rounds.map).reasons.empty());
}

TEST(GraphEvidence, ALoopInForceThatTheRestContradictsIsToBeForbidden) {
  TwoRounds rounds;
  for (const int key : {0, 20, 30})
    rounds.add_loop(key, 40 + key, true_relation(key, 40 + key), true);
  rounds.add_loop(10, 50, true_relation(10, 50) * Pose2{1.0, 0.0, 0.0}, true);
  const Diagnosis diagnosis = examined(rounds.map);
  const Reason* surprising = find(diagnosis, Reason::Cause::surprising_loop);
  ASSERT_NE(surprising, nullptr);
  ASSERT_EQ(surprising->remedies.size(), 1U);
  EXPECT_EQ(surprising->remedies[0].kind, MapEdit::Kind::forbid_loop);
  EXPECT_EQ(surprising->remedies[0].to, rounds.map.keys[50].utime);
}

// A loop that is sure of itself to a millimetre, and 3 cm off: nobody will see it on the map.
TEST(GraphEvidence, ALoopThatWouldNotMoveTheMapIsNoReason) {
  TwoRounds rounds;
  for (const int key : {0, 20, 30})
    rounds.add_loop(key, 40 + key, true_relation(key, 40 + key), true);
  rounds.add_loop(10, 50, true_relation(10, 50) * Pose2{0.03, 0.0, 0.0}, true);
  rounds.map.edges.back().information =
      information_of(diagonal_covariance(0.001, deg_to_rad(0.01)));
  for (PoseGraphEdge& edge : rounds.map.edges) {
    if (!edge.is_loop) edge.information = information_of(diagonal_covariance(5e-4, 1e-4));
  }
  EXPECT_TRUE(examined(rounds.map).reasons.empty());
}

// Scans moved the map's poses after the graph's last word: stiff edges do not fit them, and are no
// evidence against each other.
TEST(GraphEvidence, LoopsAreJudgedWhereTheGraphHasItsOptimum) {
  TwoRounds rounds;
  for (const int key : {0, 10, 20, 30})
    rounds.add_loop(key, 40 + key, true_relation(key, 40 + key), true);
  for (std::size_t key = 40; key < 80; ++key) {
    Pose2& pose = rounds.map.keys[key].world_from_robot;
    pose = Pose2{0.2, 0.0, 0.0} * pose;
  }
  const Diagnosis diagnosis = examined(rounds.map);
  EXPECT_TRUE(diagnosis.reasons.empty());
  EXPECT_NEAR(diagnosis.figures.loop_surprise, 0.0, 1e-6);
}

TEST(GraphEvidence, AMapThatItsScansPulledAwayFromStepsAndLoopsIsAReason) {
  TwoRounds rounds;
  for (std::size_t key = 40; key < 80; ++key) {
    Pose2& pose = rounds.map.keys[key].world_from_robot;
    pose = Pose2{0.01 * static_cast<double>(key), 0.0, 0.0} * pose;
  }
  const Diagnosis diagnosis = examined(rounds.map);
  ASSERT_NE(find(diagnosis, Reason::Cause::disagreement), nullptr);
  EXPECT_GT(diagnosis.figures.disagreement_m, 0.3);
  // Moved as a whole it is the same map.
  TwoRounds whole;
  for (Keyframe& key : whole.map.keys) {
    key.world_from_robot = Pose2{5.0, 1.0, 0.7} * key.world_from_robot;
  }
  EXPECT_NEAR(examined(whole.map).figures.disagreement_m, 0.0, 1e-6);
}

// Each step is known well enough, all of them together are not.
TEST(GraphEvidence, WhatStepsLeaveOpenIsAReasonUntilLoopsHoldIt) {
  TwoRounds rounds;
  for (PoseGraphEdge& edge : rounds.map.edges)
    edge.information = information_of(diagonal_covariance(0.1, deg_to_rad(3.0)));
  const Diagnosis diagnosis = examined(rounds.map);
  ASSERT_EQ(diagnosis.reasons.size(), 1U);
  EXPECT_EQ(diagnosis.reasons[0].cause, Reason::Cause::spread);
  EXPECT_EQ(diagnosis.reasons[0].verdict, Verdict::doubtful);
  EXPECT_GT(diagnosis.figures.spread_m, 0.3);
  for (int key = 0; key < 40; ++key) {
    rounds.add_loop(key, 40 + key, true_relation(key, 40 + key), true);
    if (key >= 10) rounds.add_loop(key - 10, key, true_relation(key - 10, key), true);
  }
  EXPECT_TRUE(examined(rounds.map).reasons.empty());
}

TEST(GraphEvidence, AStepThatNothingKnowsIsNamedUnlessALoopBridgesIt) {
  TwoRounds rounds;
  rounds.map.edges[59].information =
      information_of(diagonal_covariance(1.0, deg_to_rad(0.15)));  // 59 to 60
  Diagnosis diagnosis = examined(rounds.map);
  ASSERT_EQ(diagnosis.reasons.size(), 1U);
  EXPECT_EQ(diagnosis.reasons[0].cause, Reason::Cause::weak_joint);
  EXPECT_EQ(diagnosis.reasons[0].to, rounds.map.keys[60].utime);
  EXPECT_NEAR(diagnosis.figures.joint_m, 1.0, 1e-3);
  rounds.add_loop(15, 55, true_relation(15, 55), true);
  rounds.add_loop(25, 65, true_relation(25, 65), true);
  EXPECT_TRUE(examined(rounds.map).reasons.empty());
}

// The first scans are matched before the odometry is believed.
TEST(GraphEvidence, AStepThatAGoodOdometryConfirmsIsNoReason) {
  TwoRounds rounds;
  rounds.map.edges[0].information = information_of(diagonal_covariance(1.0, deg_to_rad(0.15)));
  EXPECT_NE(find(examined(rounds.map), Reason::Cause::weak_joint), nullptr);
  Diagnosis diagnosis;
  diagnosis.figures.has_odometry = true;
  diagnosis.figures.turn_correlation = diagnosis.figures.way_correlation = 0.99;
  examine_graph(rounds.map, diagnosis);
  EXPECT_TRUE(diagnosis.reasons.empty());
  rounds.map.paths[0].odometry[0].world_from_robot.x_m += 0.8;
  examine_graph(rounds.map, diagnosis);
  EXPECT_NE(find(diagnosis, Reason::Cause::weak_joint), nullptr);
}

// Where no odometry would contradict scans that slide, they are to be surer.
TEST(GraphEvidence, WithoutOdometryAStepMustBeKnownBetter) {
  TwoRounds rounds;
  rounds.map.edges[59].information = information_of(diagonal_covariance(0.08, deg_to_rad(0.15)));
  EXPECT_TRUE(examined(rounds.map).reasons.empty());
  Diagnosis diagnosis;
  examine_graph(rounds.map, diagnosis);
  ASSERT_EQ(diagnosis.reasons.size(), 1U);
  EXPECT_EQ(diagnosis.reasons[0].cause, Reason::Cause::weak_joint);
}

}  // namespace
}  // namespace marco::slam
