// Keyframes that add nothing to older ones of their place.
#include <gmock/gmock.h>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "slam/map/keyframe_culling.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::IsNear;
using ::testing::HasSubstr;

class RedundantKeyframe : public ::testing::Test {
 protected:
  /// Takes a keyframe at `truth`, and believes it elsewhere.
  void add(const Pose2& truth, double path_m, const Pose2& off = {}) {
    Keyframe key;
    key.points_in_robot = orient(world_.hits(truth, 0.01, &random_), {0, 0}, {});
    key.world_from_robot = truth * off;
    key.path_m = path_m;
    keys_.push_back(key);
  }
  /// What the newest is merged into.
  std::optional<MergedKeyframe> found(bool loop_closed = true) {
    return find_redundant_keyframe(keys_, static_cast<int>(keys_.size()) - 1, loop_closed, matcher_,
                                   options_);
  }
  /// The same, after it alone was taken at `second`.
  std::optional<MergedKeyframe> found_at(const Pose2& second, double path_m, bool loop_closed) {
    keys_.resize(1);
    add(second, path_m);
    return found(loop_closed);
  }

  testing::FlatWorld world_ = testing::small_room();
  std::mt19937 random_{3};
  SurfelMatcher matcher_;
  CullingOptions options_;
  std::vector<Keyframe> keys_;
};

TEST_F(RedundantKeyframe, IsOneWhoseNeighbourOfAnotherPassLooksTheSameWayOnceTheLoopIsClosed) {
  const Pose2 first{-1, -1, 0.3};
  add(first, 0.0);
  EXPECT_TRUE(found_at(first * Pose2{0.4, 0, 0.0}, 50.0, true));
  EXPECT_TRUE(found_at(first * Pose2{0, 0, deg_to_rad(-22)}, 50.0, true));
  EXPECT_FALSE(found_at(first * Pose2{0.4, 0, 0.0}, 50.0, false)) << "nobody knows";
  EXPECT_FALSE(found_at(first * Pose2{0.4, 0.4, 0.0}, 50.0, true)) << "too far";
  EXPECT_FALSE(found_at(first * Pose2{0, 0, deg_to_rad(28)}, 50.0, true)) << "turned";
  EXPECT_FALSE(found_at(first * Pose2{0, 0, deg_to_rad(-28)}, 50.0, true)) << "turned";
  keys_[1] = keys_[0];
  keys_[1].path_m = 50.0;
  EXPECT_TRUE(found());
  for (const double panned_deg : {-28.0, 28.0}) {
    keys_[1].sensor_heading_rad = deg_to_rad(panned_deg);
    EXPECT_FALSE(found()) << "panned";
  }
}

TEST_F(RedundantKeyframe, OnItsOwnPassIsOneAtHalfTheDistanceLoopOrNot) {
  const Pose2 first{-1, -1, 0.3};
  add(first, 100.0);
  for (const bool loop_closed : {false, true}) {
    EXPECT_TRUE(found_at(first * Pose2{0.2, 0, 0.0}, 106.0, loop_closed));
    EXPECT_FALSE(found_at(first * Pose2{0.3, 0, 0.0}, 106.0, loop_closed));
  }
}

TEST_F(RedundantKeyframe, GoesIntoTheNearestWhereItsScanSaysThatItIs) {
  const Pose2 place{-1, -1, 0.3};
  add(place * Pose2{0.30, 0, 0.1}, 0.0);
  add(place * Pose2{-0.10, 0.1, -0.05}, 1.0);
  add(place * Pose2{-0.30, 0, 0.0}, 2.0);
  add({2.9, 1.0, 1.0}, 8.0);
  add(place, 50.0, {0.05, -0.04, 0.01});
  const auto merged = found();
  ASSERT_TRUE(merged);
  EXPECT_EQ(merged->into, 1);
  EXPECT_THAT(merged->into_from_key,
              IsNear(between(keys_[1].world_from_robot, place), 0.01, deg_to_rad(0.3)));
}

// Its loop is not closed yet, or it saw something new: it is kept.
TEST_F(RedundantKeyframe, IsNotOneThatAMatchMovesOrThatSawSomethingNew) {
  const Pose2 place{-1, -1, 0.3};
  for (const Pose2& off : {Pose2{0.15, 0.1, 0}, Pose2{0, 0, deg_to_rad(3)}}) {
    keys_.clear();
    add(place, 0.0);
    add(place, 50.0, off);
    EXPECT_FALSE(found());
  }
  keys_.resize(1);
  world_.add_box(-0.5, -2.2, 0.0, 0.4);
  add(place, 50.0);
  EXPECT_FALSE(found());
}

TEST_F(RedundantKeyframe, IsTheFourthAtAPlaceHoweverBadlyItFitsAndItsPlaceIsLessSure) {
  const Pose2 place{-1, -1, 0.3};
  add(place, 0.0);
  add(place * Pose2{0.1, 0, 0}, 50.0);
  const auto sure = found();
  keys_.resize(1);
  for (const double ahead_m : {0.1, 0.2}) add(place * Pose2{ahead_m, 0, 0}, 1.0);
  world_.add_box(-0.5, -2.2, 0.0, 0.4);
  add(place * Pose2{0.01, 0, 0}, 50.0);
  const auto unsure = found();
  ASSERT_TRUE(sure && unsure);
  EXPECT_EQ(unsure->into, 0);
  EXPECT_THAT(unsure->into_from_key, IsNear(Pose2{0.01, 0, 0}, 1e-9, 1e-9)) << "as the graph says";
  for (int i = 0; i < 3; ++i) EXPECT_GT(unsure->covariance(i, i), 4.0 * sure->covariance(i, i));
}

TEST_F(RedundantKeyframe, IsOneOnlyBesideAsManyAsAPlaceKeeps) {
  options_.keyframes_per_place = 3;
  const Pose2 place{-1, -1, 0.3};
  for (const double ahead_m : {0.0, 0.1}) add(place * Pose2{ahead_m, 0, 0}, 1.0);
  add(place, 50.0);
  EXPECT_FALSE(found());
  add(place, 80.0);
  EXPECT_TRUE(found());
}

// Along a bare corridor a match knows nothing: seen by a robot that looks across it, to its side.
TEST_F(RedundantKeyframe, TellsInItsOwnFrameWhichWayItsPlaceIsNotKnown) {
  world_ = {};
  world_.add_chain({{-50, -1}, {50, -1}});
  world_.add_chain({{-50, 1}, {50, 1}});
  add({0, 0, deg_to_rad(45)}, 0.0);
  add({0.1, 0, deg_to_rad(45)}, 50.0);
  const auto merged = found();
  ASSERT_TRUE(merged);
  // The corridor lies at -45 degrees, seen from the robot.
  EXPECT_LT(merged->covariance(0, 1), -0.9 * merged->covariance(0, 0));
  EXPECT_NEAR(merged->covariance(0, 0), merged->covariance(1, 1), 0.1 * merged->covariance(0, 0));
}

class CullingRounds : public RedundantKeyframe {
 protected:
  /// Examines keyframes until none is left, and removes what is merged.
  void run(KeyframeCulling& culling) {
    while (culling.is_pending()) {
      const int at = culling.next();
      if (culling.step(keys_, true, matcher_)) keys_.erase(keys_.begin() + at);
    }
  }
};

TEST_F(CullingRounds, BeginWhenTheMapHasGrownAndLeaveTheLastKeyframesAlone) {
  options_.after_keyframes = 8;
  options_.recent_keyframes = 4;
  KeyframeCulling culling(options_);
  EXPECT_FALSE(culling.is_due(7));
  EXPECT_TRUE(culling.is_due(8));
  // Twice along the same four places, and twice more.
  for (int i = 0; i < 16; ++i) add({-2.4 + 1.0 * (i % 4), -1, 0}, 10.0 * i);
  culling.begin_round(12);
  EXPECT_TRUE(culling.is_pending());
  EXPECT_FALSE(culling.is_due(16)) << "one is under way";
  run(culling);
  // Of the first eight four are left; those after them wait.
  EXPECT_EQ(keys_.size(), 12U);
  EXPECT_FALSE(culling.is_due(11));
  EXPECT_TRUE(culling.is_due(12));
  culling.begin_round(12);
  run(culling);
  EXPECT_EQ(keys_.size(), 8U);
  EXPECT_EQ(culling.state().kept, 4);
  culling.begin_round(3);  // fewer than were examined before
  EXPECT_FALSE(culling.is_pending());
  culling.skip_to(8);
  EXPECT_FALSE(culling.is_due(15));
  EXPECT_TRUE(culling.is_due(16));
}

TEST_F(CullingRounds, OfMoreKeyframesThanThereAreAreRefused) {
  const KeyframeSet two{std::vector<Keyframe>(2), 0};
  EXPECT_EQ(complaint([&] { check(CullingState{2, 2, 2}, two); }), "");
  for (const CullingState& wrong :
       {CullingState{3, 0, 0}, CullingState{-1, 0, 0}, CullingState{0, 3, 0}, CullingState{0, 0, 3},
        CullingState{0, 0, -1}}) {
    EXPECT_THAT(complaint([&] { check(wrong, two); }), HasSubstr("more keyframes were culled"));
  }
}

}  // namespace
}  // namespace marco::slam
