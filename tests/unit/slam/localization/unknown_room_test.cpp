// A map that does not hold the whole building.
#include <gmock/gmock.h>

#include "recorded_drive.hpp"
#include "slam/localization/localizer.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

// Two different rooms, 20 x 6 m, and a door of 1.5 m between them.
testing::FlatWorld room_beyond_a_door() {
  testing::FlatWorld world;
  world.add_chain({{-4, -3}, {12, -3}, {12, 3}, {-4, 3}, {-4, -3}});
  world.add_chain({{4, -3}, {4, -0.75}});
  world.add_chain({{4, 0.75}, {4, 3}});
  world.add_box(-3.0, 1.0, -2.2, 1.6);
  world.add_box(0.5, -3.0, 1.5, -2.2);
  world.add_box(8.0, 1.5, 8.5, 2.6);
  world.add_box(10.5, -2.0, 11.2, -1.2);
  world.add_box(6.0, -2.6, 6.9, -2.2);
  return world;
}

void drive(std::vector<Pose2>& path, int steps, const Pose2& step) {
  for (int i = 0; i < steps; ++i) path.push_back(path.back() * step);
}

class UnknownRoom : public ::testing::Test {
 protected:
  // Odometry that is 5 % long and turns 3 % too far.
  std::vector<SlamInput> record(const std::vector<Pose2>& path, uint32_t seed) const {
    return recorded_drive(world_, path, seed, 1'000'000LL * seed, {1.05, 1.03});
  }
  // Of the left room, its door closed.
  std::vector<Keyframe> map_of_left_room() {
    const testing::FlatWorld open = world_;
    std::vector<Pose2> path{start_};
    drive(path, 40, {0.1, 0, 0});
    drive(path, 30, {0, 0, deg_to_rad(6)});
    drive(path, 40, {0.1, 0, 0});
    Slam mapper;
    world_.add_chain({{4, -0.75}, {4, 0.75}});
    for (const SlamInput& input : record(path, 1)) mapper.process(input);
    world_ = open;
    mapper.finish();
    return mapper.keys();
  }
  testing::FlatWorld world_ = room_beyond_a_door();
  Pose2 start_{-2.5, -0.6, 0.0};
};

// The door has been opened since: behind it the map knows nothing. The robot goes there and back.
TEST_F(UnknownRoom, WhereTheMapKnowsNothingItGoesOnByItsOwnAndComesBackRight) {
  Localizer localizer(map_of_left_room());
  std::vector<Pose2> path{{-2.8, 0.1, 0.0}};
  drive(path, 120, {0.1, 0, 0});
  const std::size_t far = path.size() - 1;
  drive(path, 30, {0, 0, deg_to_rad(6)});
  drive(path, 110, {0.1, 0, 0});
  localizer.set_pose(between(start_, path.front()));
  std::vector<SlamUpdate> updates;
  for (const SlamInput& input : record(path, 2)) updates.push_back(localizer.process(input));
  EXPECT_EQ(localizer.times_lost(), 0);
  // 10 m by scan matching alone; 5 % of odometry would be 0.5 m.
  EXPECT_THAT(updates[far].world_from_robot, IsNear(between(start_, path[far]), 0.10, 0.03));
  EXPECT_THAT(updates.back().world_from_robot, IsNear(between(start_, path.back()), 0.03, 0.01));
  // It knows that it knows less there.
  EXPECT_GT(updates[far].covariance(0, 0) + updates[far].covariance(1, 1),
            1.5 * (updates.back().covariance(0, 0) + updates.back().covariance(1, 1)));
}

// Carried there while it was switched off, it never says that it is in the left room.
TEST_F(UnknownRoom, CarriedToWhereTheMapKnowsNothingItIsNotSureOfAnotherPlace) {
  Localizer localizer(map_of_left_room());
  std::vector<Pose2> path{{-2.8, 0.1, 0.0}};
  drive(path, 30, {0.1, 0, 0});
  localizer.set_pose(between(start_, path.front()));
  for (const SlamInput& input : record(path, 2)) localizer.process(input);
  ASSERT_TRUE(localizer.is_localized());
  world_.add_chain({{4, -0.75}, {4, 0.75}});
  std::vector<Pose2> there{{6.0, 1.0, 0.5}};
  drive(there, 25, {0.1, 0, 0});
  drive(there, 30, {0, 0, deg_to_rad(6)});
  drive(there, 40, {0.1, 0, 0});
  for (const SlamInput& input : record(there, 100)) localizer.process(input);
  EXPECT_FALSE(localizer.is_localized());
  EXPECT_EQ(localizer.findings().size(), 0U);
}

}  // namespace
}  // namespace marco::slam
