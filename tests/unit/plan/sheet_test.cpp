#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "plan/make_plan.hpp"
#include "plan/sheet/plan_export.hpp"
#include "plan/sheet/plan_sheet.hpp"
#include "tests/unit/plan/two_rooms.hpp"

namespace marco::plan {
namespace {

using ::testing::HasSubstr;

FloorPlan a_room() {
  FloorPlan plan;
  PlanRoom room;
  room.name = "Hall (a)";
  const Eigen::Vector2d a(0, 0), b(5, 0), c(5, 3), d(0, 3);
  room.loops = {{{a, b, EdgeKind::wall, -1},
                 {b, c, EdgeKind::wall, -1},
                 {c, d, EdgeKind::unseen, -1},
                 {d, a, EdgeKind::wall, -1}}};
  room.area_m2 = 15;
  room.label_at = {2.5, 1.5};
  room.size_m = {5, 3};
  plan.rooms.push_back(room);
  return plan;
}

// 5 m are 50 mm at 1:100.
TEST(PlanSheet, IsToScale) {
  const Sheet sheet = draw_sheet(a_room(), {100, "", "Test", ""});
  double longest_mm = 0;
  for (const Sheet::Path& path : sheet.paths) {
    if (path.style.width_mm == 0.5 && path.points[0].y() > 60) {
      longest_mm = std::max(longest_mm, (path.points[1] - path.points[0]).norm());
    }
  }
  EXPECT_NEAR(longest_mm, 50.0, 1e-9);
  EXPECT_EQ(sheet.width_mm, 297);
  EXPECT_THAT(
      sheet_svg(sheet),
      HasSubstr("width=\"297.000mm\" height=\"210.000mm\" viewBox=\"0 0 297.000 210.000\""));
}

TEST(PlanSheet, SaysWhatFits) {
  EXPECT_THROW(draw_sheet(a_room(), {100, "A9", "", ""}), std::invalid_argument);
  try {
    draw_sheet(a_room(), {10, "A4", "", ""});
    FAIL() << "5 m at 1:10 fit on A4";
  } catch (const std::invalid_argument& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("1:50 fits"));
  }
}

FloorPlan a_round_room() {
  FloorPlan plan = a_room();
  const Eigen::Vector2d a(0, 0), b(4, 0);
  plan.rooms[0].loops = {{{a, b, EdgeKind::wall, -1, 1.0}, {b, a, EdgeKind::wall, -1, 0.0}}};
  plan.rooms[0].label_at = {2, -1};
  plan.rooms[0].size_from = {0, -2};
  plan.rooms[0].size_m = {4, 2};
  return plan;
}

// Half a circle below the x axis, on paper and in CAD.
TEST(PlanSheet, DrawsCurvedWallsAsArcs) {
  const Sheet sheet = draw_sheet(a_round_room(), {100, "", "Test", ""});
  EXPECT_THAT(sheet_svg(sheet), HasSubstr("A20.000 20.000 0 0 0 "));
  EXPECT_THAT(plan_dxf(a_round_room()),
              HasSubstr("0\nARC\n8\nWALLS\n10\n2.000000\n20\n0.000000\n30\n0.0\n40\n2.000000\n50\n"
                        "180.000000\n51\n0.000000\n"));
}

TEST(PlanDxf, HasDimensionsThatCadProgramsMeasure) {
  const std::string dxf = plan_dxf(a_round_room());
  // The room's two clear sizes and the plan's two; each with a block to draw.
  std::size_t dimensions = 0;
  for (std::size_t at = dxf.find("\n0\nDIMENSION\n"); at != std::string::npos;
       at = dxf.find("\n0\nDIMENSION\n", at + 1)) {
    ++dimensions;
  }
  EXPECT_EQ(dimensions, 4U);
  EXPECT_THAT(dxf, HasSubstr("0\nBLOCK\n8\n0\n2\n*D4\n70\n1\n"));
  EXPECT_THAT(dxf,
              HasSubstr("13\n0.000000\n23\n-1.000000\n33\n0.0\n14\n4.000000\n24\n-1.000000\n"));
}

TEST(PlanDxf, HasLayersUnitsAndBlocks) {
  FloorPlan plan = a_room();
  plan.openings.push_back({});
  plan.openings[0].from = {1, 0};
  plan.openings[0].to = {1.9, 0};
  plan.openings[0].has_leaf = true;
  plan.openings[0].hinge = {1, 0};
  plan.openings[0].leaf_end = {1, -0.9};
  const std::string dxf = plan_dxf(plan);
  EXPECT_THAT(dxf, HasSubstr("9\n$INSUNITS\n70\n6\n"));
  EXPECT_THAT(dxf,
              HasSubstr("0\nLINE\n8\nWALLS\n10\n0.000000\n20\n0.000000\n30\n0.0\n11\n5.000000\n"));
  EXPECT_THAT(dxf, HasSubstr("0\nLINE\n8\nWALLS_UNSEEN\n10\n5.000000\n20\n3.000000\n"));
  // Opens downwards: mirrored.
  EXPECT_THAT(dxf, HasSubstr("0\nINSERT\n8\nDOORS\n2\nDOOR\n10\n1.000000\n20\n0.000000\n30\n0."
                             "0\n41\n0.900000\n42\n-0.900000\n"));
  EXPECT_TRUE(dxf.ends_with("0\nEOF\n"));
}

// R12 is ASCII; letters beyond 16 bits are pairs, controls and what is no UTF-8 are as nothing.
TEST(PlanDxf, KeepsEveryLetter) {
  FloorPlan plan = a_room();
  plan.rooms[0].name = "Łazienka Кухня المطبخ 厨房 𠮷\t";
  EXPECT_THAT(plan_dxf(plan),
              HasSubstr("\n1\n\\U+0141azienka \\U+041A\\U+0443\\U+0445\\U+043D\\U+044F "
                        "\\U+0627\\U+0644\\U+0645\\U+0637\\U+0628\\U+062E \\U+53A8\\U+623F "
                        "\\U+D842\\U+DFB7\n50\n"));
}

// A wall that beams went through as well.
TEST(PlanDxf, GlassHasALayerOfItsOwn) {
  FloorPlan plan = a_room();
  plan.faces.resize(2);
  plan.faces[1].glass = true;
  plan.rooms[0].loops[0][0].index = 0;
  plan.rooms[0].loops[0][1].index = 1;
  const std::string dxf = plan_dxf(plan);
  EXPECT_THAT(dxf, HasSubstr("0\nLINE\n8\nWINDOWS\n10\n5.000000\n20\n0.000000\n"));
  EXPECT_THAT(dxf, HasSubstr("0\nLINE\n8\nWALLS\n10\n0.000000\n20\n0.000000\n"));
}

TEST(PlanJson, IsAFeatureCollection) {
  const auto root = nlohmann::json::parse(plan_json(a_room()));
  EXPECT_EQ(root["type"], "FeatureCollection");
  const auto& room = root["features"][0];
  EXPECT_EQ(room["geometry"]["coordinates"][0].size(), 5U);
  EXPECT_EQ(room["properties"]["area_m2"], 15.0);
  EXPECT_EQ(room["properties"]["edges"][2], "not seen");
}

}  // namespace
}  // namespace marco::plan
