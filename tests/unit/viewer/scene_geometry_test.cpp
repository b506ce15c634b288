#include "viewer/scene_geometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <limits>

#include "tests/unit/viewer/tiny_map.hpp"
#include "tests/unit/viewer/tiny_room.hpp"

namespace marco::viewer {
namespace {

TEST(SceneGeometry, LeavesOutTrianglesThatPointNowhere) {
  TriangleMesh mesh = testing::make_room();
  const std::size_t whole = mesh.triangles.size();
  mesh.triangles.push_back({0, 1, 1000000});
  mesh.vertices_m.push_back(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  mesh.triangles.push_back({0, 1, static_cast<uint32_t>(mesh.vertices_m.size() - 1)});
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh)});
  EXPECT_EQ(build_geometry(scene).surfaces.indices.size(), 3 * whole);
}

TEST(SceneGeometry, ComputesNormalsOfTheFacesTheyBelongTo) {
  const Scene scene = testing::room_scene();
  const TriangleMesh& mesh = *scene.meshes.front().mesh;
  const SceneGeometry geometry = build_geometry(scene);
  ASSERT_EQ(geometry.surfaces.vertices.size(), mesh.vertices_m.size());
  ASSERT_EQ(geometry.surfaces.indices.size(), 3 * mesh.triangles.size());
  // Faces share no vertices, so that each vertex has its face's normal, to a bit of 16.
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3f &a = mesh.vertices_m[triangle[0]], &b = mesh.vertices_m[triangle[1]],
                          &c = mesh.vertices_m[triangle[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized();
    for (const uint32_t corner : triangle)
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(geometry.surfaces.vertices[corner].normal[static_cast<std::size_t>(axis)],
                    32767.0F * normal[axis], 1.0F);
  }
}

TEST(SceneGeometry, AMapIsPartOfTheSurfacesAndStandsUpWhenAsked) {
  Scene scene;
  scene.grid = testing::room_map();
  const auto highest = [&] {
    float top_m = -1.0F;
    for (const Vertex& vertex : build_geometry(scene).surfaces.vertices)
      top_m = std::max(top_m, vertex.position_m[2]);
    return top_m;
  };
  EXPECT_EQ(highest(), 0.0F);
  scene.grid_wall_height_m = 2.0;
  EXPECT_EQ(highest(), 2.0F);
}

TEST(EllipseItem, EveryCornerIsSigmasFromTheCentre) {
  EllipseItem item;
  item.center_m = {2.0, -1.0};
  item.sigmas = 2.0;
  for (const double correlation : {-0.9, 0.0, 0.7}) {
    item.covariance_m2 << 0.04, 0.02 * correlation, 0.02 * correlation, 0.01;
    const std::vector<Eigen::Vector2d> corners_m = item.outline_m();
    ASSERT_EQ(corners_m.size(), 49U);
    double highest_m = -1e9;
    for (const Eigen::Vector2d& corner_m : corners_m) {
      const Eigen::Vector2d off_m = corner_m - item.center_m;
      EXPECT_NEAR(off_m.dot(item.covariance_m2.inverse() * off_m), 4.0, 1e-9) << correlation;
      highest_m = std::max(highest_m, off_m.y());
    }
    EXPECT_NEAR(highest_m, 0.2, 0.002) << "two standard deviations of y";
  }
}

}  // namespace
}  // namespace marco::viewer
