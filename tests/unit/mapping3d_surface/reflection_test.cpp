#include <gtest/gtest.h>

#include "mapping3d/surface/surface_model.hpp"
#include "tests/unit/mapping3d_surface/box_world.hpp"

namespace marco::mapping3d {
namespace {

using testing::kRoom;
using testing::smoothed;
using testing::Sweep;

const testing::Box kBehind{{3.3, -2, 0}, {5, 2, 2.6}};
const testing::Box kWall{{2.95, -1, 0.3}, {3.05, 1, 1.5}};

double area_in_m2(const TriangleMesh& mesh, const testing::Box& box) {
  double area_m2 = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto& v = mesh.vertices_m;
    const Eigen::Vector3d at = ((v[t[0]] + v[t[1]] + v[t[2]]) / 3.0F).cast<double>();
    if ((at - box.low).minCoeff() <= 0.0 || (box.high - at).minCoeff() <= 0.0) continue;
    area_m2 += 0.5 * static_cast<double>((v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm());
  }
  return area_m2;
}

ScenePoints seen_from(double x, double y, unsigned seed) {
  Sweep by;
  by.from = {x, y, 0.9};
  by.seed = seed;
  return sweep(kRoom, {}, by);
}

/// Lets the beams that meet the wall ahead where `passes` says so end a metre behind it.
template <class Passes>
void pass(ScenePoints& scene, const Passes& passes) {
  for (std::size_t row = 0; row < scene.rows; ++row) {
    for (std::size_t column = 0; column < scene.columns; ++column) {
      Eigen::Vector3f& end = scene.points_m[scene.index(row, column)];
      const Eigen::Vector3f way = end - scene.origins_m[row];
      if (end.x() < 2.9F || std::abs(end.y()) > 0.9F || end.z() > 1.8F) continue;
      if (passes(way.normalized())) end += way / way.x();
    }
  }
}

// A glass door beside the robot throws its beams elsewhere: they measure a longer way.
TEST(Reflection, WhatABeamMeasuresThroughTheMiddleOfAWallIsLeftOut) {
  std::vector<ScenePoints> scenes;
  for (unsigned i = 0; i < 6; ++i) scenes.push_back(seen_from(0.3 * i, 0.2 * i - 0.5, i));
  const double wall_m2 = area_in_m2(fuse(scenes), kWall);
  scenes.push_back(seen_from(-0.5, 0.3, 7));
  pass(scenes.back(), [](const auto&) { return true; });
  EXPECT_GT(area_in_m2(fuse({scenes.back()}), kBehind), 1.0) << "alone it has nothing against it";
  const TriangleMesh mesh = fuse(scenes);
  EXPECT_LT(area_in_m2(mesh, kBehind), 0.05);
  EXPECT_NEAR(area_in_m2(mesh, kWall), wall_m2, 0.02 * wall_m2);
}

// A pane answers where beams meet it squarely; through the rest of it another room is seen.
TEST(Reflection, WhatIsSeenThroughAWindowStays) {
  std::vector<ScenePoints> scenes;
  for (unsigned i = 0; i < 16; ++i) {
    scenes.push_back(seen_from(0.1 * i, 0.1 * i - 0.8, i));
    pass(scenes.back(), [](const Eigen::Vector3f& way) { return way.x() < 0.94F; });
  }
  EXPECT_GT(area_in_m2(fuse(scenes), kBehind), 1.3);
}

TEST(Reflection, WhatIsTakenOutLeavesNoTrace) {
  const SmoothScene kept = smoothed(seen_from(0.0, 0.0, 1));
  const SmoothScene taken = smoothed(seen_from(1.0, 0.5, 2));
  SurfaceModel never, twice;
  never.add(kept);
  twice.add(kept);
  twice.add(taken);
  twice.remove(taken);
  const TriangleMesh expected = never.take_mesh(), mesh = twice.take_mesh();
  ASSERT_EQ(mesh.triangles, expected.triangles);
  double worst_m = 0.0;
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    worst_m = std::max(worst_m,
                       static_cast<double>((mesh.vertices_m[i] - expected.vertices_m[i]).norm()));
  }
  EXPECT_LT(worst_m, 1e-3);
}

}  // namespace
}  // namespace marco::mapping3d
