#include "viewer/standing_map.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/viewer/tiny_map.hpp"
#include "viewer/cell_outlines.hpp"

namespace marco::viewer {
namespace {

using testing::fill;
using testing::room_map;
using testing::unknown_map;

TEST(CellAreas, CellsThatTouchAreOneArea) {
  CellMask mask(6, 4);
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 1}, {5, 3}}) mask.set(x, y, true);
  const std::vector<CellArea> areas = connected_areas(mask);
  ASSERT_EQ(areas.size(), 2U);
  EXPECT_EQ(areas[0].size(), 2U);  // by a corner
  EXPECT_EQ(areas[1].size(), 1U);
}

CellMask random_mask(std::mt19937& random, unsigned one_of) {
  CellMask mask(17, 11);
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 17; ++x) mask.set(x, y, random() % one_of != 0);
  return mask;
}

// How many of a cell and its eight neighbours are set.
int set_near(const CellMask& mask, int x, int y) {
  int count = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) count += mask.at(x + dx, y + dy) ? 1 : 0;
  return count;
}

// By the definitions: a cell is set where its neighbourhood is, first all of it and then any.
TEST(CellAreas, OpeningKeepsBlocksAndClosingFillsGaps) {
  std::mt19937 random(6);
  int kept = 0, filled = 0;
  for (int round = 0; round < 20; ++round) {
    const CellMask mask = random_mask(random, round % 2 == 0 ? 12 : 2);
    CellMask all(17, 11), any(17, 11);
    for (int y = 0; y < 11; ++y)
      for (int x = 0; x < 17; ++x) {
        all.set(x, y, set_near(mask, x, y) == 9);
        any.set(x, y, set_near(mask, x, y) > 0);
      }
    const CellMask open = opened(mask), whole = closed(mask);
    for (int y = 0; y < 11; ++y)
      for (int x = 0; x < 17; ++x) {
        EXPECT_EQ(open.at(x, y), set_near(all, x, y) > 0) << x << ' ' << y;
        EXPECT_EQ(whole.at(x, y), mask.at(x, y) || set_near(any, x, y) == 9) << x << ' ' << y;
        kept += open.at(x, y) ? 1 : 0;
        filled += whole.at(x, y) && !mask.at(x, y) ? 1 : 0;
      }
  }
  EXPECT_GT(kept, 100);
  EXPECT_GT(filled, 100);
  EXPECT_EQ(opened(CellMask(0, 0)).width(), 0);
  EXPECT_TRUE(connected_areas(CellMask(0, 0)).empty());
}

TEST(CellAreas, RectanglesCoverEachCellOnce) {
  std::mt19937 random(4);
  for (int round = 0; round < 20; ++round) {
    const CellMask mask = random_mask(random, 4);
    std::vector<int> covered(17 * 11, 0);
    for (const CellRectangle& part : cover_by_rectangles(mask))
      for (int y = part.min_cell.y(); y < part.end_cell.y(); ++y)
        for (int x = part.min_cell.x(); x < part.end_cell.x(); ++x)
          ++covered[static_cast<std::size_t>(17 * y + x)];
    for (int y = 0; y < 11; ++y)
      for (int x = 0; x < 17; ++x)
        EXPECT_EQ(covered[static_cast<std::size_t>(17 * y + x)], mask.at(x, y) ? 1 : 0);
  }
}

double signed_area(const Outline& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

TEST(CellOutlines, KeepARectanglesCornersAndTurnRoundHoles) {
  CellMask mask(40, 30);
  for (int y = 2; y < 27; ++y)
    for (int x = 3; x < 33; ++x) mask.set(x, y, x < 8 || x >= 28 || y < 7 || y >= 22);
  std::vector<Outline> outlines = smooth_outlines(mask);
  ASSERT_EQ(outlines.size(), 2U);
  EXPECT_EQ(outlines[0].size(), 4U);
  EXPECT_EQ(outlines[1].size(), 4U);
  EXPECT_NEAR(signed_area(outlines[0]), 30.0 * 25.0, 1e-9);
  EXPECT_NEAR(signed_area(outlines[1]), -20.0 * 15.0, 1e-9);
}

TEST(CellOutlines, ASlantingWallIsNoStaircase) {
  // Thin, rising by one in three.
  CellMask mask(130, 60);
  for (int x = 5; x < 125; ++x)
    for (int y = 0; y < 3; ++y) mask.set(x, 5 + x / 3 + y, true);
  const std::vector<Outline> outlines = smooth_outlines(mask);
  ASSERT_EQ(outlines.size(), 1U);
  const Outline& outline = outlines.front();
  EXPECT_LT(outline.size(), 12U);
  EXPECT_NEAR(signed_area(outline), 360.0, 15.0);
  const Eigen::Vector2d slope = Eigen::Vector2d(3.0, 1.0).normalized();
  double along_m = 0.0, all_m = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
    all_m += edge.norm();
    if (std::abs(edge.normalized().dot(slope)) > std::cos(deg_to_rad(4.0))) along_m += edge.norm();
  }
  EXPECT_GT(along_m, 0.93 * all_m);  // but for its two ends
}

struct Faces {
  int upright = 0;
  double floor_m2 = 0.0;
  double tops_m2 = 0.0;
};

// Two triangles a face; checks that each is wound and lit as it faces.
Faces faces_of(const TriangleMesh& mesh, float top_m) {
  Faces faces;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3f &a = mesh.vertices_m[triangle[0]], &b = mesh.vertices_m[triangle[1]],
                          &c = mesh.vertices_m[triangle[2]];
    const Eigen::Vector3f twice = (b - a).cross(c - a);
    for (const uint32_t corner : triangle)
      EXPECT_GT(mesh.normals[corner].dot(twice.normalized()), 0.9F);
    const bool upright = std::abs(twice.z()) < 1e-6F;
    if (upright) {
      ++faces.upright;
      EXPECT_EQ(std::min({a.z(), b.z(), c.z()}), 0.0F);
      EXPECT_EQ(std::max({a.z(), b.z(), c.z()}), top_m);
    } else {
      (a.z() == 0.0F ? faces.floor_m2 : faces.tops_m2) += 0.5 * static_cast<double>(twice.z());
    }
  }
  faces.upright /= 2;
  return faces;
}

TEST(StandingMap, IsTwelveFacesForARoomWithAPillar) {
  const Faces faces = faces_of(standing_map(room_map(), 2.5), 2.5F);
  EXPECT_EQ(faces.upright, 4 + 4 + 4);  // outside, inside, pillar
  EXPECT_NEAR(faces.floor_m2, 6.2 * 4.2, 1e-3);
  EXPECT_NEAR(faces.tops_m2, 6.2 * 4.2 - 6.0 * 4.0 + 0.4 * 0.4, 1e-3);
}

TEST(StandingMap, ClosesGapsOfTwoCellsAndForgetsStrayHits) {
  GridMap grid = room_map();
  fill(grid, {2.0, -0.1}, {2.1, 0.0}, 30);  // a beam that grazed the wall
  fill(grid, {3.0, 2.0}, {3.1, 2.1}, 90);   // a chair's leg
  EXPECT_EQ(faces_of(standing_map(grid, 2.5), 2.5F).upright, 12);
  fill(grid, {2.0, -0.1}, {2.9, 0.0}, 30);  // a door stays
  EXPECT_NEAR(faces_of(standing_map(grid, 2.5), 2.5F).tops_m2, 6.2 * 4.2 - 24.0 + 0.16 - 0.09,
              1e-3);
}

TEST(StandingMap, LaysNoFloorWhereNothingIsKnown) {
  GridMap grid = unknown_map(10.0, 10.0);
  EXPECT_TRUE(standing_map(grid, 2.5).triangles.empty());
  fill(grid, {0.0, 0.0}, {2.0, 1.0}, 10);
  fill(grid, {2.0, 0.5}, {8.0, 0.55}, 40);  // one beam
  const Faces faces = faces_of(standing_map(grid, 2.5), 2.5F);
  EXPECT_EQ(faces.upright, 0);
  EXPECT_NEAR(faces.floor_m2, 2.0, 1e-3);
}

}  // namespace
}  // namespace marco::viewer
