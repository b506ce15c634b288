#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/files/lines_dxf.hpp"
#include "common/files/lines_json.hpp"
#include "common/files/lines_svg.hpp"

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
  const auto json = nlohmann::json::parse(lines_json(two_walls()));
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

TEST(LinesDxf, HasALineAWallInMetres) {
  const std::string dxf = lines_dxf(two_walls());
  EXPECT_THAT(dxf, HasSubstr("0\nLINE\n8\nWALLS\n10\n0.250000\n20\n1.500000\n30\n0.0\n"
                             "11\n3.000000\n21\n-2.000000\n"));
  EXPECT_EQ(dxf.substr(dxf.size() - 6), "0\nEOF\n");
}

TEST(LinesSvg, DrawsWallsAndPathWithYUp) {
  const std::string svg =
      lines_svg(two_walls(), {{Utime{}, {0.5, 0.25, 0.0}}, {Utime{}, {1.0, 0.25, 0.0}}});
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
  const std::string svg = lines_svg(walls, {});
  // x = 0 .. 3, from the lower edge to the upper one.
  EXPECT_THAT(svg,
              HasSubstr("class=\"grid\" x1=\"3.0000\" y1=\"0.5000\" x2=\"3.0000\" y2=\"-2.5000\""));
  EXPECT_THAT(svg, Not(HasSubstr("x1=\"4.0000\"")));
}

}  // namespace
}  // namespace marco::files
