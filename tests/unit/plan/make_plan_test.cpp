#include "plan/make_plan.hpp"

#include <gtest/gtest.h>

#include "tests/unit/plan/two_rooms.hpp"

namespace marco::plan {
namespace {

class MakePlan : public ::testing::TestWithParam<double> {};

// The clear sizes are the world's; a turned building lies level on its plan.
TEST_P(MakePlan, FindsRoomsDoorCupboardAndColumn) {
  const FloorPlan plan = make_plan(testing::two_rooms(GetParam()));
  EXPECT_NEAR(plan.map_from_plan.theta_rad, GetParam(), 0.001);
  ASSERT_EQ(plan.rooms.size(), 2U);
  const std::size_t larger = plan.rooms[0].area_m2 > plan.rooms[1].area_m2 ? 0 : 1;
  const PlanRoom& left = plan.rooms[larger];
  const PlanRoom& right = plan.rooms[1 - larger];
  EXPECT_NEAR(left.area_m2, 12.0, 0.12);
  EXPECT_NEAR(right.area_m2, 9.0, 0.09);
  EXPECT_NEAR(left.size_m.x(), 4.0, 0.02);
  EXPECT_NEAR(right.size_m.x(), 3.0, 0.02);
  EXPECT_NEAR(right.size_m.y(), 3.0, 0.02);
  ASSERT_EQ(plan.openings.size(), 1U);
  EXPECT_NEAR(plan.openings[0].width_m(), 0.88, 0.02);
  EXPECT_NEAR(plan.openings[0].depth_m, 0.12, 0.02);
  EXPECT_TRUE(plan.openings[0].is_door());
  // Where the cupboard stands, the wall was not seen; nothing else is missing.
  double unseen_m = 0.0;
  for (const RoomEdge& edge : left.edges()) {
    if (edge.kind == EdgeKind::unseen) unseen_m += (edge.to - edge.from).norm();
  }
  EXPECT_NEAR(unseen_m, 1.0, 0.25);
  EXPECT_NEAR(right.seen, 1.0, 1e-9);
  std::vector<PlanObject> columns;
  for (const PlanObject& object : plan.objects) {
    if (object.round) columns.push_back(object);
  }
  ASSERT_EQ(columns.size(), 1U);
  // By all rays that hit it: the column's place and size to millimetres.
  const Eigen::Vector2d column_m =
      Pose2{0.0, 0.0, GetParam()}.inverse() * (plan.map_from_plan * columns[0].centre);
  EXPECT_LT((column_m - Eigen::Vector2d(5.8, 1.0)).norm(), 0.003);
  EXPECT_NEAR(columns[0].radius_m, 0.15, 0.003);
  EXPECT_GT(columns[0].radius_sigma_m, 0.0);
  EXPECT_EQ(plan.objects.size(), 2U);
}

// The wall between the rooms was seen from both.
TEST_P(MakePlan, MeasuresTheThicknessWhereBothFacesWereSeen) {
  const FloorPlan plan = make_plan(testing::two_rooms(GetParam()));
  double length_m = 0.0;
  for (const PlanWall& wall : plan.walls) {
    if (wall.assumed) continue;
    EXPECT_NEAR(wall.thickness_m, 0.12, 0.02);
    length_m += (wall.to - wall.from).norm();
  }
  EXPECT_NEAR(length_m, 3.0 - 0.88, 0.05);
}

// The leaf's face continues beyond the jamb: the wall's cap and the thing are in line with it.
TEST_P(MakePlan, AnOpenLeafIsNoWall) {
  const FloorPlan plan = make_plan(testing::two_rooms(GetParam(), true));
  ASSERT_EQ(plan.rooms.size(), 2U);
  const std::size_t larger = plan.rooms[0].area_m2 > plan.rooms[1].area_m2 ? 0 : 1;
  EXPECT_NEAR(plan.rooms[larger].area_m2, 12.0, 0.12);
  EXPECT_NEAR(plan.rooms[1 - larger].area_m2, 9.0, 0.09);
  ASSERT_EQ(plan.openings.size(), 1U);
  EXPECT_TRUE(plan.openings[0].has_leaf);
  EXPECT_NEAR((plan.openings[0].leaf_end - plan.openings[0].hinge).norm(), 0.9, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Turned, MakePlan, ::testing::Values(0.0, 0.3, -0.6));

TEST(MakePlan, OfNothingIsRefused) { EXPECT_THROW(make_plan({}), std::invalid_argument); }

}  // namespace
}  // namespace marco::plan
