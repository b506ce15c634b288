#include "plan/drawing/drawing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;
using marco::testing::complaint;
using ::testing::HasSubstr;

// Pairs of group codes and values, one each a word.
std::string dxf(const std::string& words) {
  std::string text;
  for (const char c : words) text += c == ' ' ? '\n' : c;
  return text + "\n0\nENDSEC\n0\nEOF\n";
}

std::string entities(const std::string& words) { return dxf("0 SECTION 2 ENTITIES " + words); }

void expect_line(const DrawnLine& line, const Vector& from, const Vector& to) {
  EXPECT_LT((line.from - from).norm(), 1e-9) << line.from.transpose();
  EXPECT_LT((line.to - to).norm(), 1e-9) << line.to.transpose();
}

// All lines lie on a circle, and go round it by so much.
void expect_arc(const Drawing& drawing, const Vector& centre, double radius, double span_rad) {
  double length = 0.0;
  for (const DrawnLine& line : drawing.lines) {
    EXPECT_TRUE(line.curved);
    EXPECT_NEAR((line.from - centre).norm(), radius, 1e-9 * radius + 1e-9);
    EXPECT_NEAR((line.to - centre).norm(), radius, 1e-9 * radius + 1e-9);
    length += (line.to - line.from).norm();
  }
  // Chords of 2.5 degrees are 8e-5 shorter.
  EXPECT_NEAR(length, radius * span_rad, 1e-4 * radius * span_rad);
}

TEST(ReadDxf, ReadsLinesAndTheirUnitAndLayer) {
  const Drawing drawing =
      read_drawing(dxf("0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES "
                       "0 LINE 8 A-WALL 10 1 20 2 11 4.5 21 -2e0 0 TEXT 8 NOTES 10 0 20 0"));
  ASSERT_EQ(drawing.lines.size(), 1U);
  expect_line(drawing.lines[0], {1, 2}, {4.5, -2});
  EXPECT_EQ(drawing.unit_m, 0.001);
  EXPECT_EQ(drawing.layers[static_cast<std::size_t>(drawing.lines[0].layer)], "A-WALL");
  EXPECT_EQ(drawing.left_out.at("TEXT"), 1);
}

TEST(ReadDxf, AUnitThatIsNotSaidIsNotGuessed) {
  const std::string line = "0 SECTION 2 ENTITIES 0 LINE 8 W 10 0 20 0 11 1 21 0";
  EXPECT_FALSE(read_drawing(dxf(line)).unit_m.has_value());
  EXPECT_FALSE(
      read_drawing(dxf("0 SECTION 2 HEADER 9 $INSUNITS 70 0 0 ENDSEC " + line)).unit_m.has_value());
}

// A bulge of 1 is half a circle, to the right of the chord: counter-clockwise.
TEST(ReadDxf, ClosesPolylinesAndBendsThem) {
  const Drawing square =
      read_drawing(entities("0 LWPOLYLINE 8 W 70 1 10 0 20 0 10 2 20 0 10 2 20 3"));
  ASSERT_EQ(square.lines.size(), 3U);
  expect_line(square.lines[2], {2, 3}, {0, 0});
  EXPECT_EQ(square.lines[0].shape, square.lines[2].shape);
  const Drawing half = read_drawing(entities("0 LWPOLYLINE 8 W 10 0 20 0 42 1 10 2 20 0"));
  expect_arc(half, {1, 0}, 1, std::numbers::pi);
  EXPECT_LT(half.lines[half.lines.size() / 2].from.y(), -0.99);
  const Drawing old = read_drawing(entities(
      "0 POLYLINE 8 W 66 1 70 0 0 VERTEX 8 W 10 0 20 0 42 1 0 VERTEX 8 W 10 2 20 0 0 SEQEND"));
  expect_arc(old, {1, 0}, 1, std::numbers::pi);
}

TEST(ReadDxf, ReadsCirclesArcsAndEllipses) {
  expect_arc(read_drawing(entities("0 CIRCLE 8 W 10 3 20 4 40 0.5")), {3, 4}, 0.5,
             2 * std::numbers::pi);
  const Drawing arc = read_drawing(entities("0 ARC 8 W 10 0 20 0 40 2 50 350 51 80"));
  expect_arc(arc, {0, 0}, 2, std::numbers::pi / 2);
  expect_arc(
      read_drawing(entities("0 ELLIPSE 8 W 10 1 20 1 11 0 21 2 40 1 41 0 42 3.14159265358979")),
      {1, 1}, 2, std::numbers::pi);
}

// Twice as large, turned by 90 degrees, about the block's base; on layer 0 a block takes the
// insert's.
TEST(ReadDxf, InsertsBlocksInBlocks) {
  const Drawing drawing = read_drawing(
      dxf("0 SECTION 2 BLOCKS 0 BLOCK 2 INNER 10 1 20 1 0 LINE 8 0 10 1 20 1 11 2 21 1 0 ENDBLK "
          "0 BLOCK 2 OUTER 10 0 20 0 0 INSERT 8 0 2 INNER 10 5 20 0 0 ENDBLK 0 ENDSEC "
          "0 SECTION 2 ENTITIES 0 INSERT 8 WALLS 2 OUTER 10 10 20 10 41 2 42 2 50 90"));
  ASSERT_EQ(drawing.lines.size(), 1U);
  expect_line(drawing.lines[0], {10, 20}, {10, 22});
  EXPECT_EQ(drawing.layers[static_cast<std::size_t>(drawing.lines[0].layer)], "WALLS");
}

TEST(ReadDxf, MirrorsWhatIsSeenFromBelow) {
  const Drawing drawing =
      read_drawing(entities("0 CIRCLE 8 W 10 3 20 4 40 0.5 210 0 220 0 230 -1"));
  expect_arc(drawing, {-3, 4}, 0.5, 2 * std::numbers::pi);
}

TEST(ReadDxf, LeavesOutWhatIsHidden) {
  const Drawing drawing = read_drawing(
      dxf("0 SECTION 2 TABLES 0 TABLE 2 LAYER 0 LAYER 2 OFF 70 0 62 -7 0 LAYER 2 FROZEN 70 1 62 7 "
          "0 ENDTAB 0 ENDSEC 0 SECTION 2 ENTITIES 0 LINE 8 OFF 10 0 20 0 11 1 21 0 "
          "0 LINE 8 FROZEN 10 0 20 0 11 1 21 0 0 LINE 8 W 67 1 10 0 20 0 11 1 21 0 "
          "0 LINE 8 W 10 0 20 0 11 1 21 1"));
  ASSERT_EQ(drawing.lines.size(), 1U);
  expect_line(drawing.lines[0], {0, 0}, {1, 1});
  EXPECT_EQ(drawing.left_out.at("on a hidden layer"), 2);
  EXPECT_EQ(drawing.left_out.at("on paper space"), 1);
}

TEST(ReadDxf, RefusesWhatWouldNeverEnd) {
  const std::string self =
      dxf("0 SECTION 2 BLOCKS 0 BLOCK 2 A 0 INSERT 8 0 2 A 0 ENDBLK 0 ENDSEC "
          "0 SECTION 2 ENTITIES 0 INSERT 8 0 2 A");
  EXPECT_THAT(complaint([&] { read_dxf(self); }), HasSubstr("deep"));
  // Each block holds a hundred of the next: 10^12 lines.
  std::string blocks = "0 SECTION 2 BLOCKS ";
  for (int i = 0; i < 6; ++i) {
    blocks += "0 BLOCK 2 B" + std::to_string(i) + " 0 INSERT 8 0 2 B" + std::to_string(i + 1) +
              " 70 10 71 10 0 ENDBLK ";
  }
  blocks += "0 BLOCK 2 B6 0 LINE 8 0 10 0 20 0 11 1 21 1 0 ENDBLK 0 ENDSEC ";
  EXPECT_THAT(complaint([&] { read_dxf(dxf(blocks + "0 SECTION 2 ENTITIES 0 INSERT 8 0 2 B0")); }),
              HasSubstr("endlessly"));
}

TEST(ReadDrawing, SaysWhatAFileIs) {
  EXPECT_THAT(complaint([] { read_drawing("AC1027\x01"); }), HasSubstr("DWG"));
  EXPECT_THAT(complaint([] { read_drawing("%PDF-1.4"); }), HasSubstr("PDF"));
  EXPECT_THAT(complaint([] { read_drawing("AutoCAD Binary DXF\r\n"); }), HasSubstr("binary"));
  EXPECT_THAT(complaint([] { read_drawing("hello"); }), HasSubstr("line 1 is not a group code"));
  EXPECT_THAT(complaint([] { read_drawing(entities("0 LINE 10 abc")); }), HasSubstr("no number"));
  EXPECT_THAT(complaint([] { read_drawing(entities("0 LINE 10 1e12")); }), HasSubstr("farther"));
  EXPECT_THAT(complaint([] { read_drawing("<html></html>"); }), HasSubstr("not an SVG file"));
  EXPECT_THAT(complaint([] { read_drawing("<svg><path d=\"M0 0"); }), HasSubstr("is truncated"));
  EXPECT_THAT(complaint([] { read_drawing("<svg><path d=\"M0 0 X\"/></svg>"); }),
              HasSubstr("unknown command"));
}

std::string svg(const std::string& inside) {
  return "<?xml version=\"1.0\"?><!DOCTYPE svg [<!ENTITY a \"b\">]><!-- <line/> --><svg "
         "width=\"420mm\" viewBox=\"0 0 840 594\">" +
         inside + "</svg>";
}

TEST(ReadSvg, TurnsYUpAndKnowsThePaper) {
  const Drawing drawing = read_drawing(svg("<line x1='1' y1='2' x2='3' y2='4'/>"));
  ASSERT_EQ(drawing.lines.size(), 1U);
  expect_line(drawing.lines[0], {1, -2}, {3, -4});
  EXPECT_FALSE(drawing.unit_m.has_value());
  EXPECT_NEAR(drawing.paper_unit_m.value(), 0.0005, 1e-12);
}

TEST(ReadSvg, ReadsOurOwnScale) {
  EXPECT_EQ(read_drawing("<svg data-metres-per-unit=\"0.05\"/>").unit_m, 0.05);
}

TEST(ReadSvg, ReadsEachKindOfShape) {
  const auto count = [](const std::string& shape) { return read_drawing(svg(shape)).lines.size(); };
  EXPECT_EQ(count("<polyline points=\"0,0 1,0 1,1\"/>"), 2U);
  EXPECT_EQ(count("<polygon points=\"0,0 1,0 1,1\"/>"), 3U);
  EXPECT_EQ(count("<rect x=\"1\" y=\"1\" width=\"2\" height=\"1\"/>"), 4U);
  EXPECT_EQ(count("<rect width=\"100%\" height=\"100%\"/>"), 0U);
  EXPECT_EQ(count("<text>M0 0 L1 1</text>"), 0U);
  expect_arc(read_drawing(svg("<circle cx=\"5\" cy=\"6\" r=\"2\"/>")), {5, -6}, 2,
             2 * std::numbers::pi);
}

TEST(ReadSvg, FollowsPaths) {
  const Drawing drawing = read_drawing(svg("<path d=\"m1-1.5.5 0h2v1H0L5 5z\"/>"));
  ASSERT_EQ(drawing.lines.size(), 6U);
  expect_line(drawing.lines[0], {1, 1.5}, {1.5, 1.5});
  expect_line(drawing.lines[1], {1.5, 1.5}, {3.5, 1.5});
  expect_line(drawing.lines[2], {3.5, 1.5}, {3.5, 0.5});
  expect_line(drawing.lines[3], {3.5, 0.5}, {0, 0.5});
  expect_line(drawing.lines[5], {5, -5}, {1, 1.5});
}

// The four arcs between two points on a circle; the flags stand without blanks.
TEST(ReadSvg, BendsArcsAsTheirFlagsSay) {
  const auto arc = [](const char* flags) {
    return read_drawing(svg(std::string("<path d=\"M1 0A1 1 0 ") + flags + "0-1\"/>"));
  };
  expect_arc(arc("00"), {0, 0}, 1, std::numbers::pi / 2);
  expect_arc(arc("11"), {0, 0}, 1, std::numbers::pi * 3 / 2);
  expect_arc(arc("01"), {1, 1}, 1, std::numbers::pi / 2);
  expect_arc(arc("10"), {1, 1}, 1, std::numbers::pi * 3 / 2);
}

// A quarter of a circle as drawing programs write it; 2.8e-4 off.
TEST(ReadSvg, BendsBezierCurves) {
  for (const char* path : {"M1 0C1 .5523 .5523 1 0 1", "M1 0c0 .5523-.4477 1-1 1"}) {
    const Drawing drawing = read_drawing(svg(std::string("<path d=\"") + path + "\"/>"));
    ASSERT_EQ(drawing.lines.size(), 24U);
    for (const DrawnLine& line : drawing.lines) EXPECT_NEAR(line.to.norm(), 1.0, 3e-4);
  }
}

// S and T steer by the mirror image of the curve before: half a circle, and a wave.
TEST(ReadSvg, ContinuesCurvesSmoothly) {
  const Drawing half = read_drawing(svg("<path d=\"M1 0C1 .5523 .5523 1 0 1S-1 .5523-1 0\"/>"));
  ASSERT_EQ(half.lines.size(), 48U);
  for (const DrawnLine& line : half.lines) EXPECT_NEAR(line.to.norm(), 1.0, 3e-4);
  const Drawing wave = read_drawing(svg("<path d=\"M0 0Q1 1 2 0T4 0\"/>"));
  expect_line(wave.lines[11], wave.lines[11].from, {1, -0.5});
  expect_line(wave.lines[35], wave.lines[35].from, {3, 0.5});
}

TEST(ReadSvg, AppliesTransformsFromTheOutside) {
  const Drawing drawing =
      read_drawing(svg("<g transform=\"translate(10 0) rotate(90)\"><line transform=\"scale(2)\" "
                       "x1=\"0\" y1=\"0\" x2=\"1\" y2=\"0\"/></g>"
                       "<line x2=\"1\" transform=\"matrix(0 1 -1 0 5 5)\"/>"));
  ASSERT_EQ(drawing.lines.size(), 2U);
  expect_line(drawing.lines[0], {10, 0}, {10, -2});
  expect_line(drawing.lines[1], {5, -5}, {5, -6});
}

TEST(ReadSvg, NamesLayersAndPassesOverWhatIsHidden) {
  const Drawing drawing = read_drawing(
      svg("<g inkscape:groupmode=\"layer\" inkscape:label=\"Walls &amp; more\"><g id=\"g1\"><line "
          "x2=\"1\"/></g></g><g id=\"doors\"><line x2=\"2\"/><line class=\"wall\" x2=\"3\"/></g>"
          "<g style=\"display: none\"><line x2=\"4\"/></g><defs><line x2=\"5\"/></defs>"));
  ASSERT_EQ(drawing.lines.size(), 3U);
  const auto layer = [&](std::size_t i) {
    return drawing.layers[static_cast<std::size_t>(drawing.lines[i].layer)];
  };
  EXPECT_EQ(layer(0), "Walls & more");
  EXPECT_EQ(layer(1), "doors");
  EXPECT_EQ(layer(2), "wall");
}

}  // namespace
}  // namespace marco::plan
