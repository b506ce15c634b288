#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "common/files/relations.hpp"
#include "common/relations_metric.hpp"
#include "common/trajectory_fit.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/matchers.hpp"

namespace marco {
namespace {

Trajectory straight_drive() {
  Trajectory path;
  for (int i = 0; i <= 100; ++i) {
    path.push_back({Utime::from_seconds(i), {0.5 * i, 0.1 * std::sin(0.3 * i), 0.02 * i}});
  }
  return path;
}

TEST(RelationsMetric, APathThatFulfilsItsRelationsHasNoError) {
  const Trajectory path = straight_drive();
  std::vector<PoseRelation> relations;
  for (int i = 0; i + 70 <= 100; i += 5) {
    relations.push_back({1.0 * i, i + 70.0,
                         between(path[static_cast<std::size_t>(i)].world_from_robot,
                                 path[static_cast<std::size_t>(i + 70)].world_from_robot)});
  }
  const RelationsReport report = compare_with_relations(path, relations);
  EXPECT_EQ(report.all.count, relations.size());
  EXPECT_EQ(report.far_apart.count, relations.size());
  EXPECT_NEAR(report.all.translation_m.max, 0.0, 1e-9);
  EXPECT_NEAR(report.all.rotation_deg.max, 0.0, 1e-9);
}

TEST(RelationsMetric, ErrorsAreMeasuredInTheFirstPosesFrame) {
  const Trajectory path = {{Utime::from_seconds(1), {0, 0, deg_to_rad(90)}},
                           {Utime::from_seconds(2), {0, 1, deg_to_rad(100)}}};
  // Truly 0.3 m farther and 0.4 m aside, and 10 deg less turned.
  const std::vector<PoseRelation> relations = {{1.0, 2.0, {1.3, 0.4, 0.0}}, {1.0, 99.0, {}}};
  const RelationsReport report = compare_with_relations(path, relations);
  EXPECT_EQ(report.all.count, 1U);
  EXPECT_EQ(report.skipped, 1U);
  EXPECT_EQ(report.far_apart.count, 0U);
  // relative to the second pose's frame or the first's, the length of (0.3, 0.4) is 0.5
  EXPECT_NEAR(report.all.translation_m.mean, 0.5, 1e-9);
  EXPECT_NEAR(report.all.rotation_deg.mean, 10.0, 1e-9);
}

TEST(RelationsMetric, SpreadsAreAboutTheMeanAndFarApartIsAMinute) {
  const Trajectory still = {
      {Utime::from_seconds(0), {}}, {Utime::from_seconds(59), {}}, {Utime::from_seconds(61), {}}};
  const std::vector<PoseRelation> relations = {
      {0, 59, {0.1, 0, 0}}, {59, 0, {0.3, 0, deg_to_rad(2)}}, {61, 0, {0, 0.8, deg_to_rad(-4)}}};
  const RelationsReport report = compare_with_relations(still, relations);
  EXPECT_EQ(report.all.count, 3U);
  EXPECT_NEAR(report.all.translation_m.mean, 0.4, 1e-12);
  EXPECT_NEAR(report.all.translation_m.std, std::sqrt((0.09 + 0.01 + 0.16) / 3.0), 1e-12);
  EXPECT_NEAR(report.all.translation_m.p95, 0.3, 1e-12);  // the second of three
  EXPECT_NEAR(report.all.translation_m.max, 0.8, 1e-12);
  EXPECT_NEAR(report.all.rotation_deg.mean, 2.0, 1e-9);
  EXPECT_EQ(report.far_apart.count, 1U);
  EXPECT_NEAR(report.far_apart.translation_m.mean, 0.8, 1e-12);
  EXPECT_NEAR(report.far_apart.translation_m.std, 0.0, 1e-12);
}

TEST(RelationsMetric, AFileOfRelationsIsReadLineByLine) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "a.relations").string();
  std::ofstream(path) << "# by hand\n1.5 2.5 0.3 0.4 0 0 0 0.1\n\n";
  const std::vector<PoseRelation> relations = files::read_relations(path);
  ASSERT_EQ(relations.size(), 1U);
  EXPECT_EQ(relations[0].second_time_s, 2.5);
  EXPECT_THAT(relations[0].first_from_second, testing::IsNear(Pose2{0.3, 0.4, 0.1}, 0, 0));
  std::ofstream(path, std::ios::app) << "1.5 2.5 0.3\n";
  EXPECT_THROW(files::read_relations(path), std::invalid_argument);
}

TEST(RelationsMetric, WhatIsNoFiniteNumberIsRefusedWithItsLine) {
  const testing::TemporaryFolder folder;
  for (const char* bad : {"nan", "-inf", "0.4x", "1e999"}) {
    const auto path = folder.write(
        "bad", "# by hand\n1 2 0.3 0.4 0 0 0 0.1\n1 2 0.3 " + std::string(bad) + " 0 0 0 0.1\n");
    EXPECT_THAT([&] { files::read_relations(path); },
                ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr(
                    "bad:3: '" + std::string(bad) + "' is not a finite number")));
  }
}

TEST(TrajectoryFit, ARigidlyMovedPathFitsExactly) {
  const Trajectory truth = straight_drive();
  const Pose2 estimate_from_truth{3.0, -7.0, 2.0};
  Trajectory estimate;
  for (const StampedPose2& pose : truth) {
    estimate.push_back({pose.utime, estimate_from_truth * pose.world_from_robot});
  }
  const TrajectoryFit fit = fit_to_truth(estimate, truth);
  EXPECT_EQ(fit.count, truth.size());
  EXPECT_NEAR(fit.rms_m, 0.0, 1e-9);
  EXPECT_THAT(fit.truth_from_estimate, testing::IsNear(estimate_from_truth.inverse(), 1e-9, 1e-9));
}

TEST(TrajectoryFit, ReportsWhatNoMotionCanTakeAway) {
  const Trajectory truth = straight_drive();
  Trajectory estimate = truth;
  // Every other pose 2 cm ahead, the rest 2 cm behind: the fit's mean shift is (nearly) none.
  for (std::size_t i = 0; i < 100; ++i) {
    estimate[i].world_from_robot.x_m += i % 2 == 0 ? 0.02 : -0.02;
  }
  const TrajectoryFit fit = fit_to_truth(estimate, truth);
  EXPECT_NEAR(fit.rms_m, 0.02, 0.001);
  EXPECT_NEAR(fit.max_m, 0.02, 0.001);
}

TEST(TrajectoryFit, TheDelayOfAnotherClocksTruthIsFoundToAMillisecond) {
  Trajectory truth, late;
  for (int i = 0; i < 200; ++i) {
    const double t_s = 0.1 * i;
    truth.push_back({Utime::from_seconds(t_s), {std::sin(t_s), std::cos(1.7 * t_s), 0.0}});
    late.push_back({Utime::from_seconds(t_s + 0.17), truth.back().world_from_robot});
  }
  EXPECT_GT(fit_to_truth(truth, late).rms_m, 0.05);
  const TrajectoryFit fit = fit_to_truth(truth, RecordedTruth{late, true});
  EXPECT_NEAR(fit.truth_late.seconds(), 0.17, 0.002);
  EXPECT_LT(fit.rms_m, 0.003);
}

TEST(TrajectoryFit, PosesInAGapOfTheTruthDoNotCount) {
  const Trajectory truth = {{Utime::from_seconds(0), {}}, {Utime::from_seconds(10), {1, 0, 0}}};
  const Trajectory estimate = {{Utime::from_seconds(5), {}}};
  EXPECT_EQ(fit_to_truth(estimate, truth).count, 0U);
}

}  // namespace
}  // namespace marco
