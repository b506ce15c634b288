#include "slam/localization/localizer.hpp"

#include <gmock/gmock.h>

#include "recorded_drive.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class LocalizerTest : public ::testing::Test {
 protected:
  static std::vector<Pose2> arc(const Pose2& from, int count, const Pose2& step) {
    std::vector<Pose2> path{from};
    while (std::ssize(path) < count) path.push_back(path.back() * step);
    return path;
  }
  std::vector<Keyframe> map() const {
    Slam mapper;
    for (const SlamInput& input : recorded_drive(room_, tour_, 1, 0)) mapper.process(input);
    mapper.finish();
    return mapper.keys();
  }
  Pose2 in_map(const Pose2& world_from_robot) const {
    return between(tour_.front(), world_from_robot);
  }
  std::vector<SlamUpdate> process(Localizer& localizer, uint32_t seed) const {
    std::vector<SlamUpdate> updates;
    for (const SlamInput& input : recorded_drive(room_, path_, seed, 1'000'000'000LL * seed)) {
      updates.push_back(localizer.process(input));
    }
    return updates;
  }

  testing::FlatWorld room_ = testing::small_room();
  std::vector<Pose2> tour_ = arc({0.0, -0.6, 0.0}, 90, {0.07, 0.0, 0.07});
  std::vector<Pose2> path_ = arc({-1.0, 0.0, 0.3}, 40, {0.05, 0.0, 0.02});
};

TEST_F(LocalizerTest, UntilItIsSureItIsLostAndThenThePathBeforeHasItsPlaceToo) {
  Localizer localizer(map());
  const std::vector<SlamUpdate> updates = process(localizer, 2);
  EXPECT_EQ(updates.front().status, SlamUpdate::Status::lost);
  EXPECT_EQ(updates.front().world_from_robot.vector(), Pose2{}.vector()) << "its own frame";
  EXPECT_EQ(updates.back().status, SlamUpdate::Status::matched);
  ASSERT_THAT(localizer.findings(), SizeIs(1));
  EXPECT_GE(localizer.findings()[0].path_m, 1.0);
  const auto poses = localizer.trajectory();
  ASSERT_THAT(poses, SizeIs(path_.size()));
  for (std::size_t i = 0; i < path_.size(); ++i) {
    ASSERT_TRUE(poses[i]) << i;
    EXPECT_THAT(*poses[i], IsNear(in_map(path_[i]), 0.05, 0.02)) << i;
  }
}

TEST_F(LocalizerTest, ToldWhereItIsItTracksFromTheFirstScanOn) {
  Localizer localizer(map());
  localizer.set_pose(in_map(path_.front()) * Pose2{0.05, -0.05, 0.02});
  EXPECT_TRUE(localizer.is_localized());
  const std::vector<SlamUpdate> updates = process(localizer, 3);
  for (std::size_t i = 0; i < path_.size(); ++i) {
    EXPECT_EQ(updates[i].status, SlamUpdate::Status::matched) << i;
    EXPECT_THAT(updates[i].world_from_robot, IsNear(in_map(path_[i]), 0.04, 0.01)) << i;
  }
  EXPECT_THAT(localizer.findings(), IsEmpty()) << "it did not look";
}

TEST_F(LocalizerTest, TheMapStaysAsItIs) {
  Localizer localizer(map());
  const std::vector<Keyframe> before = localizer.keys();
  process(localizer, 4);
  ASSERT_THAT(localizer.keys(), SizeIs(before.size()));
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(localizer.keys()[i].world_from_robot.vector(), before[i].world_from_robot.vector());
  }
}

TEST_F(LocalizerTest, ForgettingThePlaceBeginsAsIfJustSwitchedOn) {
  Localizer localizer(map());
  process(localizer, 5);
  ASSERT_TRUE(localizer.is_localized());
  localizer.forget_place();
  EXPECT_FALSE(localizer.is_localized());
  const std::vector<SlamUpdate> again = process(localizer, 6);
  EXPECT_EQ(again.front().status, SlamUpdate::Status::lost);
  EXPECT_THAT(localizer.findings(), SizeIs(2));
  EXPECT_THAT(again.back().world_from_robot, IsNear(in_map(path_.back()), 0.04, 0.01));
  EXPECT_EQ(localizer.times_lost(), 0) << "told, not carried away";
}

TEST_F(LocalizerTest, WithoutAPathItLocalizesTheSame) {
  Localizer localizer(map());
  localizer.keep_no_path();
  EXPECT_EQ(process(localizer, 7).back().status, SlamUpdate::Status::matched);
  EXPECT_THAT(localizer.trajectory(), IsEmpty());
}

TEST_F(LocalizerTest, AMapWithoutPointsIsRefused) {
  EXPECT_THROW(Localizer({}), std::invalid_argument);
  EXPECT_THROW(Localizer({Keyframe{}}), std::invalid_argument);
}

TEST(LocalizedPath, PartsWhosePlaceWasNeverFoundHaveNoPose) {
  LocalizedPath path;
  path.add_unplaced({1.0, 0.0, 0.0});
  path.begin_session();
  path.add_unplaced({2.0, 0.0, 0.0});
  path.place_session({0.0, 5.0, 0.0});
  path.add({9.0, 9.0, 0.0});
  const auto poses = path.poses();
  ASSERT_THAT(poses, SizeIs(3));
  EXPECT_FALSE(poses[0]);
  EXPECT_EQ(poses[1]->vector(), (Pose2{2.0, 5.0, 0.0}.vector()));
  EXPECT_EQ(poses[2]->vector(), (Pose2{9.0, 9.0, 0.0}.vector()));
}

}  // namespace
}  // namespace marco::slam
