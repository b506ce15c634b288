#include "plan/known_plan/deviations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plan/known_plan/deviation_sheet.hpp"
#include "plan/make_plan.hpp"
#include "plan/sheet/plan_export.hpp"
#include "plan/sheet/plan_sheet.hpp"
#include "tests/unit/plan/two_rooms.hpp"

namespace marco::plan {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using State = WallDeviation::State;

constexpr double kTurnRad = 0.3;

// The two rooms as drawn: walls as rectangles, the column as a circle; the cupboard is furniture.
class Drawn {
 public:
  Drawn() {
    box(-0.2, -0.2, 7.32, 3.2);
    box(0, 0, 7.12, 3);
  }
  Drawn& middle_wall(double x) {
    box(x, 0, x + 0.12, 1);
    box(x, 1.88, x + 0.12, 3);
    return *this;
  }
  Drawn& wall(double x0, double y0, double x1, double y1) {
    box(x0, y0, x1, y1);
    return *this;
  }
  Drawn& column(double x, double y) {
    ++shape_;
    for (int i = 0; i < 144; ++i) {
      const auto at = [&](int k) {
        return Eigen::Vector2d(x + 0.15 * std::cos(k * std::numbers::pi / 72),
                               y + 0.15 * std::sin(k * std::numbers::pi / 72));
      };
      plan.lines.push_back({at(i), at(i + 1), shape_, true});
    }
    return *this;
  }
  KnownPlan plan;

 private:
  void box(double x0, double y0, double x1, double y1) {
    const Eigen::Vector2d corners[] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    ++shape_;
    for (int i = 0; i < 4; ++i) {
      plan.lines.push_back({corners[i], corners[(i + 1) % 4], shape_, false});
    }
  }
  int shape_ = 0;
};

// From a start that is 20 cm and 3 degrees off.
PlanDeviations compare(const KnownPlan& plan) {
  return compare_with_plan(look_about(plan).faces, testing::two_rooms(kTurnRad),
                           Pose2{0.15, -0.12, deg_to_rad(3)} * Pose2{0, 0, -kTurnRad});
}

const WallDeviation& wall_at(const PlanDeviations& found, double x, double y) {
  const WallDeviation* nearest = nullptr;
  double least = 1e9;
  for (const WallDeviation& wall : found.walls) {
    const WallFace& face = wall.drawn[wall.drawn.size() / 2].face;
    const double off = (face.at((face.low_m + face.high_m) / 2) - Eigen::Vector2d(x, y)).norm();
    if (off < least) least = off, nearest = &wall;
  }
  return *nearest;
}

TEST(CompareWithPlan, ABuildingAsDrawnDeviatesNowhere) {
  const PlanDeviations found = compare(Drawn().middle_wall(4).column(5.8, 1).plan);
  EXPECT_NEAR(found.fit.drawing_from_map.x_m, 0.0, 0.003);
  EXPECT_NEAR(found.fit.drawing_from_map.y_m, 0.0, 0.003);
  EXPECT_NEAR(found.fit.drawing_from_map.theta_rad, -kTurnRad, 0.001);
  int measured = 0;
  for (const WallDeviation& wall : found.walls) {
    EXPECT_FALSE(wall.is_off()) << wall.number << " " << wall.off_m;
    EXPECT_NE(wall.state, State::missing) << wall.number;
    if (wall.state == State::measured) ++measured;
    // Three sigma hold the error of each, and do not say much more than there is.
    if (wall.state == State::measured) {
      EXPECT_LT(std::abs(wall.off_m), 3 * wall.sigma_m);
      EXPECT_LT(wall.sigma_m, 0.02);
    }
  }
  EXPECT_GE(measured, 9);
  for (const UndrawnWall& wall : found.undrawn) EXPECT_TRUE(wall.furniture);
  EXPECT_EQ(found.axis_thickness_m, 0.0);
}

// The wall between the rooms stands 12 cm to the left of where it is drawn: both its faces are off,
// one into its room and one away from it, and nothing else is.
TEST(CompareWithPlan, OneMovedWallDoesNotMoveTheOthers) {
  const PlanDeviations found = compare(Drawn().middle_wall(4.12).column(5.8, 1).plan);
  for (const WallDeviation& wall : found.walls) {
    const WallFace& face = wall.drawn.front().face;
    const double x = face.at(face.low_m).x();
    const bool is_moved = std::abs(face.normal.x()) > 0.9 && x > 4 && x < 4.3;
    if (wall.state != State::measured) continue;
    EXPECT_EQ(wall.is_off(), is_moved) << wall.number << " " << wall.off_m;
    if (is_moved) {
      EXPECT_NEAR(wall.off_m, -0.12 * face.normal.x(), 0.01);
    } else {
      EXPECT_NEAR(wall.off_m, 0.0, 0.01);
    }
  }
  EXPECT_THAT(deviation_table(found), HasSubstr("cm off the plan, into the room, sigma"));
}

TEST(CompareWithPlan, SaysWhatIsMissingAndWhatIsNotDrawn) {
  const PlanDeviations found = compare(Drawn().wall(2, 0, 2.12, 2).column(5.8, 1).plan);
  EXPECT_EQ(wall_at(found, 2.0, 1.0).state, State::missing);
  EXPECT_EQ(wall_at(found, 2.12, 1.0).state, State::missing);
  double undrawn_m = 0.0;
  for (const UndrawnWall& wall : found.undrawn) {
    if (!wall.furniture) undrawn_m += wall.face.length_m();
  }
  // Both faces of the wall with the door.
  EXPECT_NEAR(undrawn_m, 2 * (3 - 0.88), 0.3);
  const std::string table = deviation_table(found);
  EXPECT_THAT(table, HasSubstr("is missing"));
  EXPECT_THAT(table, HasSubstr("present, but not drawn:"));
}

TEST(CompareWithPlan, AColumnIsOffByItsCentre) {
  const PlanDeviations found = compare(Drawn().middle_wall(4).column(5.72, 1.06).plan);
  const auto column = std::find_if(found.walls.begin(), found.walls.end(),
                                   [](const WallDeviation& wall) { return wall.is_curve(); });
  ASSERT_NE(column, found.walls.end());
  EXPECT_TRUE(column->is_off());
  EXPECT_NEAR(column->shift_m.x(), 0.08, 0.015);
  EXPECT_NEAR(column->shift_m.y(), -0.06, 0.015);
}

// A plan of single lines, in the middle of walls of 12 cm: the moved one is off by what it was
// moved, from both its sides.
TEST(CompareWithPlan, TakesLinesInTheMiddleOfWallsForThat) {
  for (const double moved : {0.0, 0.05}) {
    KnownPlan plan;
    const auto add = [&plan](double x0, double y0, double x1, double y1) {
      plan.lines.push_back({{x0, y0}, {x1, y1}, static_cast<int>(plan.lines.size()), false});
    };
    add(-0.06, -0.06, 7.18, -0.06), add(7.18, -0.06, 7.18, 3.06);
    add(7.18, 3.06, -0.06, 3.06), add(-0.06, 3.06, -0.06, -0.06);
    const double x = 4.06 + moved;
    add(x, 0, x, 1), add(x, 1.88, x, 3);
    const PlanDeviations found = compare(plan);
    EXPECT_NEAR(found.axis_thickness_m, 0.12, 0.01);
    int off = 0;
    for (const WallDeviation& wall : found.walls) {
      if (wall.state != State::measured) continue;
      const WallFace& face = wall.drawn.front().face;
      const double from_middle = std::abs(face.at(face.low_m).x() - x);
      const bool is_moved = std::abs(face.normal.x()) > 0.9 && from_middle < 0.1;
      EXPECT_NEAR(wall.off_m, is_moved ? -moved * face.normal.x() : 0.0, 0.012) << wall.number;
      off += wall.is_off() ? 1 : 0;
    }
    EXPECT_EQ(off, moved > 0 ? 4 : 0);
  }
}

TEST(CompareWithPlan, RefusesAPlanOfSomethingElse) {
  KnownPlan plan;
  plan.lines.push_back({{50, 50}, {60, 50}, 0, false});
  EXPECT_THROW(compare(plan), std::invalid_argument);
}

// What `marco plan` draws is read again, and agrees with what it was made of.
TEST(CompareWithPlan, OurOwnPlansComeBack) {
  const std::vector<slam::Keyframe> keys = testing::two_rooms(kTurnRad);
  const FloorPlan plan = make_plan(keys);
  for (const std::string& text : {plan_dxf(plan), sheet_svg(draw_sheet(plan, {}))}) {
    const KnownPlan known = known_plan_of(read_drawing(text), {});
    EXPECT_NEAR((known.high_m() - known.low_m()).x(), 7.12, 0.02);
    const PlanSight sight = look_about(known);
    const PlanDeviations found = compare_with_plan(
        sight.faces, keys, Pose2{known.low_m().x(), known.low_m().y(), 0} * Pose2{0, 0, -kTurnRad});
    for (const WallDeviation& wall : found.walls) EXPECT_FALSE(wall.is_off()) << wall.off_m;
    EXPECT_GT(found.fit.agreeing, 0.6);
    EXPECT_THAT(deviations_json(found, known), HasSubstr("\"layers_taken\""));
    EXPECT_THAT(deviations_svg(found, known), HasSubstr("class=\"agrees\""));
  }
}

}  // namespace
}  // namespace marco::plan
