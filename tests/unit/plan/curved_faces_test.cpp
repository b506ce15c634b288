#include "plan/curved_faces.hpp"

#include <gtest/gtest.h>

#include "plan/make_plan.hpp"
#include "tests/unit/plan/round_rooms.hpp"

namespace marco::plan {
namespace {

using testing::RoundRooms;
using Vector = Eigen::Vector2d;

TEST(Bulge, IsTheArcThatItsChordAndTurnSay) {
  // A quarter turn about (1, 2) with radius 2, counter-clockwise and back.
  const Vector from(3, 2), to(1, 4);
  for (const double side : {1.0, -1.0}) {
    const Vector a = side > 0 ? from : to, b = side > 0 ? to : from;
    const double bulge = bulge_of(side * std::numbers::pi / 2);
    const BulgeArc arc = bulge_arc(a, b, bulge);
    EXPECT_LT((arc.centre - Vector(1, 2)).norm(), 1e-12);
    EXPECT_NEAR(arc.radius, 2.0, 1e-12);
    EXPECT_LT((arc.at(0.5) - Vector(1 + std::sqrt(2.0), 2 + std::sqrt(2.0))).norm(), 1e-12);
    EXPECT_NEAR(bulge_length_m(a, b, bulge), std::numbers::pi, 1e-12);
    EXPECT_NEAR(bulge_area_m2(a, b, bulge), side * (std::numbers::pi - 2), 1e-12);
    double farthest = 0;
    std::vector<Vector> points = bulge_points(a, b, bulge, 0.001);
    points.push_back(b);
    for (std::size_t i = 1; i < points.size(); ++i) {
      farthest = std::max(farthest, 2 - ((points[i] + points[i - 1]) / 2 - arc.centre).norm());
    }
    EXPECT_LE(farthest, 0.001);
    EXPECT_GT(farthest, 0.0003);
  }
  EXPECT_EQ(bulge_points(from, to, 0.0).size(), 1U);
}

TEST(CurvedFaces, RoundRoomsHaveTheirAreasAndTheirDoor) {
  const FloorPlan plan = make_plan(RoundRooms::keyframes());
  ASSERT_EQ(plan.rooms.size(), 2U);
  const std::size_t inner = plan.rooms[0].area_m2 < plan.rooms[1].area_m2 ? 0 : 1;
  const double room_m2 = std::numbers::pi * 9.0;
  const double corridor_m2 = std::numbers::pi * (25.0 - 3.2 * 3.2);
  EXPECT_NEAR(plan.rooms[inner].area_m2, room_m2, 0.01 * room_m2);
  EXPECT_NEAR(plan.rooms[1 - inner].area_m2, corridor_m2, 0.01 * corridor_m2);
  ASSERT_EQ(plan.openings.size(), 1U);
  EXPECT_NEAR(plan.openings[0].width_m(), RoundRooms::kDoorM, 0.02);
  // Three circles, to millimetres.
  const Pose2 plan_from_map = plan.map_from_plan.inverse();
  std::vector<double> radii;
  for (const RoundWall& arc : plan.arcs) {
    EXPECT_LT((arc.centre_m - plan_from_map * Vector(0, 0)).norm(), 0.004);
    EXPECT_EQ(arc.from_inside, std::abs(arc.radius_m - RoundRooms::kCorridorFromM) > 0.1);
    radii.push_back(arc.radius_m);
  }
  std::sort(radii.begin(), radii.end());
  ASSERT_EQ(radii.size(), 3U);
  EXPECT_NEAR(radii[0], RoundRooms::kRoomM, 0.003);
  EXPECT_NEAR(radii[1], RoundRooms::kCorridorFromM, 0.003);
  EXPECT_NEAR(radii[2], RoundRooms::kCorridorToM, 0.003);
  // Each is one edge: two with a door, and the corridor's outer wall; what the cupboard hides of it
  // continues the circle.
  std::size_t bent = 0;
  double straight_m = 0, unseen_m = 0;
  for (const PlanRoom& room : plan.rooms) {
    for (const RoomEdge& edge : room.edges()) {
      bent += edge.bulge != 0.0 ? 1 : 0;
      if (edge.kind != EdgeKind::opening && edge.bulge == 0.0) straight_m += edge.length_m();
      if (edge.kind == EdgeKind::unseen) unseen_m += edge.length_m();
    }
  }
  EXPECT_NEAR(unseen_m, 1.0, 0.25);
  EXPECT_EQ(plan.objects.size(), 1U);
  EXPECT_EQ(bent, 4U);
  EXPECT_LT(straight_m, 0.3);
}

TEST(CurvedFaces, OfTwoConcentricFacesOneWallIsMade) {
  const FloorPlan plan = make_plan(RoundRooms::keyframes());
  double length_m = 0;
  for (const PlanWall& wall : plan.walls) {
    if (wall.assumed) continue;
    EXPECT_NE(wall.bulge, 0.0);
    EXPECT_NEAR(wall.thickness_m, 0.2, 0.006);
    EXPECT_NEAR((wall.back(wall.from) - wall.from).norm(), wall.thickness_m, 1e-9);
    length_m += bulge_length_m(wall.from, wall.to, wall.bulge);
  }
  EXPECT_NEAR(length_m, 2 * std::numbers::pi * 3.0 - 0.9, 0.1);
}

TEST(CurvedFaces, StraightRoomsHaveNone) {
  for (const double turn_rad : {0.0, 0.3, -0.6}) {
    EXPECT_TRUE(make_plan(testing::two_rooms(turn_rad)).arcs.empty());
  }
}

}  // namespace
}  // namespace marco::plan
