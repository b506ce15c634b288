#include "slam/session/mending.hpp"

#include <gtest/gtest.h>

#include "common/covariance.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/two_rounds.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;
using ::marco::testing::TwoRounds;

constexpr double kTurnRad = 0.14;  // 8 deg
const Pose2 kOff{0.5, 0.2, kTurnRad};

// Nothing but the step between the rounds holds them together.
Slam finished(TwoRounds rounds, double sigma_m, double sigma_deg) {
  rounds.map.edges[TwoRounds::kOfRound - 1].information =
      information_of(diagonal_covariance(sigma_m, deg_to_rad(sigma_deg)));
  SlamState state;
  state.keyframes.keys = rounds.map.keys;
  state.back_end.edges = rounds.map.edges;
  state.back_end.loops = rounds.map.loops;
  state.estimate.world_from_robot = rounds.map.keys.back().world_from_robot;
  for (int key = 0; key < 2 * TwoRounds::kOfRound; ++key) {
    state.path.scans.push_back({rounds.map.keys[static_cast<std::size_t>(key)].utime, key, {}});
  }
  state.path.keyframe_poses = state.path.scans;
  Slam slam;
  slam.restore(state);
  slam.finish();
  return slam;
}

double largest_error_m(const Slam& slam) {
  double largest = 0.0;
  for (int key = 0; key < 2 * TwoRounds::kOfRound; ++key) {
    const Pose2 off =
        between(TwoRounds::place(key), slam.keys()[static_cast<std::size_t>(key)].world_from_robot);
    largest = std::max(largest, off.translation_m().norm());
  }
  return largest;
}

TEST(Mending, ClosesTheLoopThatTheSearchMissed) {
  Slam slam = finished(TwoRounds(kOff), 0.05, 1.0);
  EXPECT_GT(largest_error_m(slam), 0.3);
  const MapEdits done = mend(slam);
  ASSERT_FALSE(done.empty());
  EXPECT_EQ(done.front().kind, MapEdit::Kind::add_loop);
  EXPECT_LT(largest_error_m(slam), 0.06);
}

TEST(Mending, LeavesAMapThatAgreesWithItself) {
  Slam slam = finished(TwoRounds(), 0.05, 1.0);
  const int64_t revision = slam.revision();
  EXPECT_TRUE(mend(slam).empty());
  EXPECT_EQ(slam.revision(), revision);
}

// Another building was seen in the second round: nothing fits, and nothing is bent.
TEST(Mending, LeavesWhatNoLoopWouldMend) {
  testing::FlatWorld other;
  other.add_chain({{2.2, 0.6}, {0, 2.9}, {-2.3, 0.4}, {-0.2, -1.7}, {2.2, 0.6}});
  Slam slam = finished(TwoRounds({}, other), 0.3, 5.0);
  const Trajectory before = slam.key_trajectory();
  mend(slam);
  for (std::size_t key = 0; key < before.size(); ++key) {
    EXPECT_THAT(slam.key_trajectory()[key].world_from_robot,
                IsNear(before[key].world_from_robot, 0.05, 0.02));
  }
}

// A loop in force that is wrong bends a map that was right.
TEST(Mending, TakesAWrongLoopOutOfTheMap) {
  TwoRounds rounds;
  for (int i = 0; i < 3; ++i) {
    rounds.add_loop(10 + i, TwoRounds::kOfRound + 10 + i, Pose2{0.6, 0.3, 0.2}, true);
  }
  Slam slam = finished(rounds, 0.3, 5.0);
  const double before_m = largest_error_m(slam);
  mend(slam);
  EXPECT_GT(before_m, 0.3);
  EXPECT_LT(largest_error_m(slam), 0.06);
}

}  // namespace
}  // namespace marco::slam
