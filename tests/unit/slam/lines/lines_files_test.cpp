#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/files/line_map_files.hpp"

namespace marco::files {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Walls two_walls() {
  Walls walls(2);
  walls[0].id = 4;
  walls[0].start_m = {0.25, 1.5};
  walls[0].end_m = {3.0, -2.0};
  for (int k = 0; k < 16; ++k) walls[0].covariance(k / 4, k % 4) = 1.0 / (k + 3.0);
  walls[0].existence = 0.9;
  walls[0].times_seen = 11;
  walls[0].end_seen = true;
  walls[1].end_m = {1.0, 0.0};
  return walls;
}

TEST(LinesJson, HoldsEveryFieldToTheLastBit) {
  const auto json = nlohmann::json::parse(lines_json({two_walls(), {}, {}}));
  EXPECT_EQ(json["unit"], "m");
  ASSERT_EQ(json["walls"].size(), 2U);
  const auto& wall = json["walls"][0];
  EXPECT_EQ(wall["id"], 4);
  EXPECT_EQ(wall["start_m"], nlohmann::json({0.25, 1.5}));
  EXPECT_EQ(wall["end_m"], nlohmann::json({3.0, -2.0}));
  for (unsigned k = 0; k < 16; ++k) EXPECT_EQ(wall["covariance_m2"][k / 4][k % 4], 1.0 / (k + 3.0));
  EXPECT_EQ(wall["existence"], 0.9);
  EXPECT_EQ(wall["times_seen"], 11);
  EXPECT_EQ(wall["start_seen"], false);
  EXPECT_EQ(wall["end_seen"], true);
}

RoundWalls post_and_arc() {
  RoundWalls walls(2);
  walls[0].id = 7;
  walls[0].centre_m = {2.0, 1.0};
  walls[0].radius_m = 0.125;
  walls[0].covariance(0, 2) = 0.25;
  walls[1].radius_m = 4.0;
  walls[1].from_inside = true;
  walls[1].from_rad = 0.5;
  walls[1].span_rad = 1.5;
  return walls;
}

TEST(LinesFiles, HoldPostsAndCurvedWalls) {
  const auto json = nlohmann::json::parse(lines_json({{}, post_and_arc(), {}}));
  ASSERT_EQ(json["round_walls"].size(), 2U);
  EXPECT_EQ(json["round_walls"][0]["centre_m"], nlohmann::json({2.0, 1.0}));
  EXPECT_EQ(json["round_walls"][0]["covariance_m2"][0][2], 0.25);
  EXPECT_EQ(json["round_walls"][1]["span_rad"], 1.5);
  const std::string dxf = lines_dxf({{}, post_and_arc(), {}});
  EXPECT_THAT(dxf, HasSubstr("0\nCIRCLE\n8\nPOSTS\n10\n2.000000\n20\n1.000000\n30\n0.0\n"
                             "40\n0.125000\n0\nARC\n8\nWALLS\n"));
  EXPECT_THAT(dxf, HasSubstr("40\n4.000000\n50\n28.647890\n51\n114.591559\n"));
  // 4 m (cos 0.5, sin 0.5), y downwards.
  EXPECT_THAT(lines_svg({{}, post_and_arc(), {}}, {}), HasSubstr("points=\"3.5103,-1.9177 "));
}

TEST(LinesFiles, HoldCorners) {
  LineMap map;
  CornerPoint& corner = map.corners.emplace_back();
  corner.at_m = {2.0, 1.5};
  corner.covariance << 0.25, 0.125, 0.125, 0.5;
  corner.wall_ids[0] = 7;
  corner.wall_ids[1] = 3;
  corner.convex = true;
  const auto json = nlohmann::json::parse(lines_json(map))["corners"];
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json[0]["at_m"], nlohmann::json({2.0, 1.5}));
  EXPECT_EQ(json[0]["covariance_m2"], nlohmann::json({{0.25, 0.125}, {0.125, 0.5}}));
  EXPECT_EQ(json[0]["walls"], nlohmann::json({7, 3}));
  EXPECT_EQ(json[0]["convex"], true);
  EXPECT_THAT(lines_dxf(map), HasSubstr("0\nPOINT\n8\nCORNERS\n10\n2.000000\n20\n1.500000\n"));
  EXPECT_THAT(lines_svg(map, {}), HasSubstr("class=\"corner\""));
}

TEST(LinesDxf, HasALineAWallInMetres) {
  const std::string dxf = lines_dxf({two_walls(), {}, {}});
  EXPECT_THAT(dxf, HasSubstr("0\nLINE\n8\nWALLS\n10\n0.250000\n20\n1.500000\n30\n0.0\n"
                             "11\n3.000000\n21\n-2.000000\n"));
  EXPECT_EQ(dxf.substr(dxf.size() - 6), "0\nEOF\n");
}

TEST(LinesSvg, DrawsWallsAndPathWithYUp) {
  const std::string svg =
      lines_svg({two_walls(), {}, {}}, {{Utime{}, {0.5, 0.25, 0.0}}, {Utime{}, {1.0, 0.25, 0.0}}});
  EXPECT_THAT(svg, HasSubstr("class=\"wall\" opacity=\"0.90\" x1=\"0.2500\" y1=\"-1.5000\" "
                             "x2=\"3.0000\" y2=\"2.0000\""));
  EXPECT_THAT(svg, HasSubstr("points=\"0.5000,-0.2500 1.0000,-0.2500 \""));
}

TEST(LinesSvg, AnEmptyPlanIsAPictureOfAMetre) {
  EXPECT_THAT(lines_svg({}, {}), HasSubstr("viewBox=\"-0.500 -0.500 1.000 1.000\" width=\"40\""));
}

TEST(LinesSvg, LiesOnAGridOfMetres) {
  Walls walls(1);
  walls[0].start_m = {0.25, 0.25};
  walls[0].end_m = {2.5, 1.5};
  const std::string svg = lines_svg({walls, {}, {}}, {});
  // x = 0 .. 3, from the lower edge to the upper one.
  EXPECT_THAT(svg,
              HasSubstr("class=\"grid\" x1=\"3.0000\" y1=\"0.5000\" x2=\"3.0000\" y2=\"-2.5000\""));
  EXPECT_THAT(svg, Not(HasSubstr("x1=\"4.0000\"")));
}

}  // namespace
}  // namespace marco::files
