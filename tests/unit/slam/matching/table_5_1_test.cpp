#include <gtest/gtest.h>

#include "slam/matching/nlm_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"
#include "tests/support/matching_table.hpp"

namespace marco::slam {
namespace {

using testing::match_table;
using testing::MatchTrial;

// Table 5.1 of the thesis in short: tests/experiments/table_5_1 prints the whole of it.
TEST(Table51, LorentzianHoldsWhereLeastSquaresIsLost) {
  const auto with = [](const char* estimator) {
    NlmOptions options;
    options.estimator = estimator;
    options.max_pair_m = 40.0;
    options.min_overlap = 0.0;
    return [matcher = NlmMatcher(options)](const MatchTrial& trial) {
      return matcher.match(NlmTarget(trial.target), trial.source, trial.start).target_from_source;
    };
  };
  const auto squares = match_table(0.2, 20, 7, with("least_squares"));
  const auto robust = match_table(0.2, 20, 7, with("lorentzian"));
  // The thesis: 5.1 deg and 11 cm against 1.4 deg and 1.8 cm.
  EXPECT_GT(squares.angle_deg.mean, 3.0);
  EXPECT_GT(squares.translation_cm.mean, 10.0);
  EXPECT_LT(robust.angle_deg.mean, 0.6);
  EXPECT_LT(robust.translation_cm.mean, 1.8);
}

TEST(Table51, TheFastMatcherComesNearTheCramerRaoBound) {
  const auto local = [](const MatchTrial& trial) {
    SurfelPyramid map({}, {0, 0});
    map.add(orient(trial.target, {0, 0}, {}), Pose2{});
    return SurfelMatcher()
        .match(map, orient(trial.source, {0, 0}, {}), trial.start, nullptr)
        .map_from_robot;
  };
  for (const double outlier_part : {0.02, 0.2}) {
    const auto table = match_table(outlier_part, 100, 8, local);
    // Like the matcher, this bound knows of the walls what the two scans show; unlike it, that they
    // are straight for metres, and how much better a grazing beam tells the distance across one.
    EXPECT_LT(table.translation_cm.mean, 1.35 * table.honest_bound.translation_cm);
    EXPECT_LT(table.angle_deg.mean, 1.7 * table.honest_bound.angle_deg);
    EXPECT_GT(table.honest_bound.translation_cm, table.bound.translation_cm);
  }
}

}  // namespace
}  // namespace marco::slam
