#include "plan/known_plan/known_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "plan/known_plan/plan_sight.hpp"

namespace marco::plan {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Drawing drawing_of(double size, const std::vector<std::string>& layers) {
  Drawing drawing;
  drawing.layers = layers;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    drawing.lines.push_back({{0, 0}, {size, 0}, static_cast<int>(i), static_cast<int>(i), false});
  }
  return drawing;
}

std::string complaint_of(const Drawing& drawing, const PlanWish& wish) {
  return marco::testing::complaint([&] { known_plan_of(drawing, wish); });
}

TEST(ChooseLayers, TakesWhatSoundsLikeWalls) {
  EXPECT_THAT(choose_layers({"A-WALL", "A-WALL-PATT", "A-DOOR", "S-COLS", "0"}, ""),
              ElementsAre(true, false, false, true, false));
  EXPECT_THAT(choose_layers({"W\xC3\xA4nde", "T\xC3\xBCren"}, ""), ElementsAre(true, false));
}

TEST(ChooseLayers, ElseAllButWhatSoundsLikeSomethingElse) {
  EXPECT_THAT(choose_layers({"0", "Dimensions", "furniture", "Layer 2"}, ""),
              ElementsAre(true, false, false, true));
}

TEST(ChooseLayers, TakesWhatIsAskedFor) {
  EXPECT_THAT(choose_layers({"a", "WALL", "b"}, "b,a"), ElementsAre(true, false, true));
  EXPECT_THAT(complaint_of(drawing_of(10, {"a"}), {"c", "m"}), HasSubstr("no layer \"c\""));
}

TEST(KnownPlan, WantsAScale) {
  EXPECT_THAT(complaint_of(drawing_of(12000, {"0"}), {}),
              HasSubstr("Its size would be 12 m in mm"));
  EXPECT_THAT(complaint_of(drawing_of(12000, {"0"}), {"", "m"}), HasSubstr("right --unit"));
  EXPECT_THAT(complaint_of(drawing_of(12000, {"0"}), {"", "1:100"}), HasSubstr("paper"));
  EXPECT_THAT(complaint_of(drawing_of(12000, {"0"}), {"", "yards"}), HasSubstr("yards"));
}

TEST(KnownPlan, TakesWhatIsSaidUnlessAnotherIsGiven) {
  Drawing drawing = drawing_of(12, {"0"});
  drawing.unit_m = 1.0;
  drawing.paper_unit_m = 0.01;
  EXPECT_EQ(known_plan_of(drawing, {}).lines[0].to.x(), 12.0);
  EXPECT_NEAR(known_plan_of(drawing, {"", "ft"}).lines[0].to.x(), 3.6576, 1e-9);
  EXPECT_NEAR(known_plan_of(drawing, {"", "1:200"}).lines[0].to.x(), 24.0, 1e-9);
  EXPECT_NEAR(known_plan_of(drawing, {"", "0.5"}).lines[0].to.x(), 6.0, 1e-9);
}

// A room of 3.4 x 3 m in walls of 0.45 m, with a line along the axis of one of them: of it nothing
// is seen, of the walls the inner faces look inwards and the outer ones outwards.
TEST(LookAbout, SeesFacesFromWhereThereIsRoom) {
  KnownPlan plan;
  const auto box = [&plan](double x0, double y0, double x1, double y1) {
    const Eigen::Vector2d corners[] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    for (int i = 0; i < 4; ++i) plan.lines.push_back({corners[i], corners[(i + 1) % 4], 0, false});
  };
  box(0, 0, 3.4, 3);
  box(-0.45, -0.45, 3.85, 3.45);
  plan.lines.push_back({{3.625, 0}, {3.625, 3}, 1, false});
  const PlanSight sight = look_about(plan);
  double inside_m = 0.0;
  for (const DrawnFace& drawn : sight.faces) {
    const Eigen::Vector2d middle = drawn.face.at((drawn.face.low_m + drawn.face.high_m) / 2);
    EXPECT_GT(std::abs(middle.x() - 3.625), 0.05);
    const bool is_inner =
        middle.x() > -0.1 && middle.x() < 3.5 && middle.y() > -0.1 && middle.y() < 3.1;
    const double inwards = drawn.face.normal.dot(Eigen::Vector2d(1.7, 1.5) - middle);
    EXPECT_EQ(inwards > 0, is_inner) << middle.transpose();
    if (is_inner) inside_m += drawn.face.length_m();
  }
  EXPECT_NEAR(inside_m, 12.8, 0.4);
  EXPECT_NO_THROW(check(map_of_plan(sight)));
}

}  // namespace
}  // namespace marco::plan
