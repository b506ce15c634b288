#include "mapping3d/scene_mesh.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "mapping3d/thesis_mesh.hpp"
#include "tests/support/slow_scene_mesh.hpp"

namespace marco::mapping3d {
namespace {

// A wall at x = 2 seen from the origin by a grid of beams a degree apart.
ScenePoints wall(std::size_t rows, std::size_t columns, double slant_deg = 0.0) {
  ScenePoints scene;
  scene.rows = rows;
  scene.columns = columns;
  const Eigen::Vector3d normal(std::cos(deg_to_rad(slant_deg)), std::sin(deg_to_rad(slant_deg)), 0);
  for (std::size_t row = 0; row < rows; ++row) {
    scene.origins_m.emplace_back(0, 0, 0);
    for (std::size_t column = 0; column < columns; ++column) {
      const double bearing =
          deg_to_rad(static_cast<double>(column) - 0.5 * static_cast<double>(columns));
      const double tilt = deg_to_rad(static_cast<double>(row) - 0.5 * static_cast<double>(rows));
      const Eigen::Vector3d ray(std::cos(bearing) * std::cos(tilt), std::sin(bearing),
                                std::cos(bearing) * std::sin(tilt));
      scene.points_m.push_back((ray * (2.0 / ray.dot(normal))).cast<float>());
      scene.valid.push_back(1);
    }
  }
  return scene;
}

TEST(ThesisRule, EveryQuadOfAWholeWallIsThere) {
  const ScenePoints scene = wall(10, 12);
  EXPECT_EQ(thesis_quads(scene).size(), 9U * 11U);
  EXPECT_EQ(thesis_triangles(scene).size(), 2U * 9U * 11U);
}

TEST(ThesisRule, AMissingBeamTakesItsFourQuadsAndTheirTrianglesThatTouchIt) {
  ScenePoints scene = wall(10, 12);
  scene.valid[scene.index(5, 5)] = 0;
  EXPECT_EQ(thesis_quads(scene).size(), 99U - 4U);
  // Of the eight triangles of those quads the point belongs to six: each diagonal runs from the
  // upper left to the lower right corner, so two of the quads have a triangle without it.
  EXPECT_EQ(thesis_triangles(scene).size(), 198U - 6U);
}

TEST(ThesisRule, DistancesAreMeasuredFromTheFirstVertexOnly) {
  ScenePoints scene;
  scene.rows = scene.columns = 2;
  scene.origins_m.assign(2, {0, 0, 0});
  scene.valid.assign(4, 1);
  // Second and fourth vertex 0.28 m from each other, but both 0.19 m and less from the first.
  scene.points_m = {{2, 0, 0}, {2, 0.19F, 0}, {2, 0, 0.19F}, {2, 0.13F, 0.13F}};
  EXPECT_EQ(thesis_quads(scene).size(), 1U);
  scene.points_m[3] = {2, 0.15F, 0.15F};  // 0.212 m from the first
  EXPECT_TRUE(thesis_quads(scene).empty());
  scene.points_m[3] = {2, 0.002F, 0.002F};  // nearer than 5 mm
  EXPECT_TRUE(thesis_quads(scene).empty());
}

TEST(MeshScene, AWallIsWholeAndFacesTheLaser) {
  const TriangleMesh mesh = mesh_scene(wall(10, 12));
  EXPECT_EQ(mesh.vertices_m.size(), 120U);
  EXPECT_EQ(mesh.triangles.size(), 198U);
  for (const Eigen::Vector3f& normal : mesh.normals) EXPECT_NEAR(normal.x(), -1.0F, 1e-4);
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f up = (mesh.vertices_m[t[1]] - mesh.vertices_m[t[0]])
                                   .cross(mesh.vertices_m[t[2]] - mesh.vertices_m[t[0]]);
    EXPECT_LT(up.x(), 0.0F);
  }
}

TEST(MeshScene, ADepthEdgeIsNotSkinnedOver) {
  ScenePoints scene = wall(10, 12);
  for (std::size_t row = 0; row < 10; ++row) {
    for (std::size_t column = 6; column < 12; ++column)
      scene.points_m[scene.index(row, column)] *= 2.0F;
  }
  const TriangleMesh mesh = mesh_scene(scene);
  EXPECT_EQ(mesh.triangles.size(), 2U * 9U * 5U * 2U);
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LT((mesh.vertices_m[t[i]] - mesh.vertices_m[t[(i + 1) % 3]]).norm(), 0.3F);
    }
  }
}

// Two rows of two beams, one column this much deeper than the other.
TEST(MeshScene, AnEdgeIsAllowedUpToItsLimitAndNoLonger) {
  SceneMeshOptions options;
  options.edge_factor = 0.001;  // only the floor counts
  options.edge_floor_m = 0.2;
  const auto triangles = [&](float edge_m) {
    ScenePoints scene;
    scene.rows = scene.columns = 2;
    for (int row = 0; row < 2; ++row) {
      scene.origins_m.emplace_back(0.0F, 0.0F, 0.0F);
      scene.points_m.emplace_back(2.0F, 0.0F, 0.01F * static_cast<float>(row));
      scene.points_m.emplace_back(2.0F + edge_m, -0.02F, 0.01F * static_cast<float>(row));
    }
    scene.valid.assign(4, 1);
    return mesh_scene(scene, options).triangles.size();
  };
  EXPECT_EQ(triangles(0.19F), 2U);
  EXPECT_EQ(triangles(0.21F), 0U);
  EXPECT_EQ(triangles(0.30F), 0U);
  options.edge_floor_m = 0.0;
  options.edge_factor = 1e6;
  options.max_edge_m = 0.2;
  EXPECT_EQ(triangles(0.19F), 2U);
  EXPECT_EQ(triangles(0.21F), 0U);
  EXPECT_EQ(triangles(0.30F), 0U);
}

TEST(MeshScene, AMissingBeamLeavesAHoleNoLargerThanItself) {
  ScenePoints scene = wall(10, 12);
  scene.valid[scene.index(5, 5)] = 0;
  // Four quads lose a corner and keep one triangle each.
  EXPECT_EQ(mesh_scene(scene).triangles.size(), 198U - 4U);
}

TEST(MeshScene, NoiseTearsNoHolesAndNormalsStayNearTheWalls) {
  ScenePoints scene = wall(60, 60);
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, 0.010F);
  for (Eigen::Vector3f& point : scene.points_m) point += noise(random) * point.normalized();
  const TriangleMesh mesh = mesh_scene(scene);
  EXPECT_EQ(mesh.triangles.size(), 2U * 59U * 59U);
}

// A box in front of the wall, beams missing in places, a sensor that moves from row to row.
ScenePoints cluttered(uint32_t seed, std::size_t rows, std::size_t columns) {
  ScenePoints scene = wall(rows, columns, 20.0);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0F, 0.010F);
  std::uniform_int_distribution<int> one_of_ten(0, 9);
  for (std::size_t row = 0; row < rows; ++row) {
    scene.origins_m[row] = {0.01F * static_cast<float>(row), 0.0F, 0.0F};
    for (std::size_t column = 0; column < columns; ++column) {
      Eigen::Vector3f& point = scene.points_m[scene.index(row, column)];
      if (column > columns / 2 && row > rows / 3) point *= 0.6F;
      point += noise(random) * point.normalized();
      scene.valid[scene.index(row, column)] = one_of_ten(random) == 0 ? 0 : 1;
    }
  }
  return scene;
}

std::vector<std::array<Eigen::Vector3f, 3>> corners(const TriangleMesh& mesh) {
  std::vector<std::array<Eigen::Vector3f, 3>> all;
  for (const auto& t : mesh.triangles) {
    all.push_back({mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]});
  }
  return all;
}

TEST(MeshScene, EqualsTheMeshMadeQuadByQuad) {
  for (const auto& [rows, columns] : {std::pair{2U, 2U}, {2U, 9U}, {7U, 2U}, {40U, 61U}}) {
    for (uint32_t seed = 0; seed < 5; ++seed) {
      const ScenePoints scene = cluttered(seed, rows, columns);
      const TriangleMesh fast = mesh_scene(scene), slow = marco::testing::SlowMesher(scene).run();
      EXPECT_EQ(corners(fast), corners(slow));
      ASSERT_EQ(fast.vertices_m.size(), slow.vertices_m.size());
      // Vertices are numbered differently: normals are compared corner by corner. Sums of up to
      // eight floats in another order.
      for (std::size_t i = 0; i < fast.triangles.size(); ++i) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
          const Eigen::Vector3f& a = fast.normals[fast.triangles[i][corner]];
          const Eigen::Vector3f& b = slow.normals[slow.triangles[i][corner]];
          ASSERT_NEAR((a - b).norm(), 0.0F, 1e-5F);
        }
      }
    }
  }
}

// On a processor without eight lanes both are the same code.
TEST(MeshScene, EightLanesMakeTheSameBitsAsFour) {
  for (const std::size_t columns : {2U, 5U, 8U, 9U, 16U, 17U, 61U}) {
    const ScenePoints scene = cluttered(3, 20, columns);
    const TriangleMesh eight = mesh_scene(scene), four = mesh_scene(scene, {}, Lanes::four);
    EXPECT_EQ(eight.triangles, four.triangles);
    EXPECT_EQ(eight.vertices_m, four.vertices_m);
    EXPECT_EQ(eight.normals, four.normals);
  }
}

TEST(BeamSpacing, IsTheMeanAngleToTheDiagonalNeighbour) {
  const ScenePoints scene = wall(30, 40, 20.0);
  double sum = 0.0;
  for (std::size_t row = 0; row + 1 < 30; ++row) {
    for (std::size_t column = 0; column + 1 < 40; ++column) {
      const Eigen::Vector3d a = scene.points_m[scene.index(row, column)].cast<double>();
      const Eigen::Vector3d b = scene.points_m[scene.index(row + 1, column + 1)].cast<double>();
      sum += std::acos(a.normalized().dot(b.normalized()));
    }
  }
  // A sample of every second beam of a smooth field: well within two percent.
  EXPECT_NEAR(beam_spacing_rad(scene), sum / (29.0 * 39.0), 0.02 * deg_to_rad(1.4));
}

TEST(MeshScene, NothingMakesNothing) {
  EXPECT_TRUE(mesh_scene(ScenePoints{}).triangles.empty());
  ScenePoints scene = wall(5, 5);
  scene.valid.assign(25, 0);
  EXPECT_TRUE(mesh_scene(scene).vertices_m.empty());
}

TEST(AppendMesh, IndicesOfThePartMoveBehindTheWhole) {
  TriangleMesh whole = mesh_scene(wall(3, 3));
  const TriangleMesh part = mesh_scene(wall(3, 3));
  append_mesh(whole, part);
  EXPECT_EQ(whole.vertices_m.size(), 18U);
  EXPECT_EQ(whole.triangles.size(), 16U);
  EXPECT_EQ(whole.triangles[8][0], part.triangles[0][0] + 9U);
}

}  // namespace
}  // namespace marco::mapping3d
