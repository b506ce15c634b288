#include "viewer/detail_levels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "common/mesh_distance.hpp"
#include "tests/unit/viewer/tiny_room.hpp"
#include "viewer/renderer.hpp"

namespace marco::viewer {
namespace {

constexpr PictureSize kLevelSize{320, 180};

std::size_t count(const std::vector<DetailLevels::Range>& ranges) {
  return std::accumulate(ranges.begin(), ranges.end(), std::size_t{0},
                         [](std::size_t sum, const auto& range) { return sum + range.count; });
}

Eigen::Matrix4d clip_from_world(const Camera& camera) {
  return clip_from_camera(camera, kLevelSize.aspect()) * camera_from_world(camera);
}

// Clip space of a camera that sees all of it.
Eigen::Matrix4d everything() {
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(3, 3) = 1.0;
  return clip;
}

TEST(DetailLevels, ZeroIsEveryTriangleInViewAndMoreIsFewer) {
  const SceneGeometry geometry = build_geometry(testing::room_scene(0.1F, 0.003F));
  const std::size_t all = geometry.surfaces.indices.size();
  const DetailLevels levels(geometry.surfaces);
  const Camera over =
      fit_camera({}, bounding_box(testing::room_scene()), 0.3, 0.9, kLevelSize.aspect());
  const auto indices = [&](const Camera& camera, double allowed_px) {
    return count(levels.choose({clip_from_world(camera), camera.eye_m, 100.0, true, allowed_px}));
  };
  EXPECT_EQ(indices(over, 0.0), all);
  // Parts keep their rims, so that a net of 10 cm is spared a half.
  EXPECT_LT(indices(over, 2.0), all / 2);
  // From the room's middle two thirds lie behind or beside.
  const Camera inside = camera_at(make_pose3({5.9, 2.0, 1.2}), deg_to_rad(40.0));
  EXPECT_LT(indices(inside, 0.0), all / 2);
  EXPECT_GT(indices(inside, 0.0), 0U);
}

const Geometry& noisy_room() {
  static const Geometry kSurfaces = build_geometry(testing::room_scene(0.08F, 0.003F)).surfaces;
  return kSurfaces;
}

const DetailLevels& levels_of_noisy_room() {
  static const DetailLevels kLevels(noisy_room());
  return kLevels;
}

// Edges that one triangle only stands on.
std::set<std::pair<uint32_t, uint32_t>> rims(const std::vector<uint32_t>& indices) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const uint32_t a = indices[i], b = indices[i % 3 == 2 ? i - 2 : i + 1];
    ++edges[std::minmax(a, b)];
  }
  std::set<std::pair<uint32_t, uint32_t>> once;
  for (const auto& [edge, times] : edges) {
    if (times == 1) once.insert(edge);
  }
  return once;
}

TEST(DetailLevels, PartsOfDifferentLevelsMeet) {
  const Geometry& surfaces = noisy_room();
  const DetailLevels& levels = levels_of_noisy_room();
  for (const double allowed_px : {0.3, 1.0, 3.0}) {
    // From a corner with the whole room in the picture: near parts fine, far ones coarse.
    const auto ranges =
        levels.choose({everything(), Eigen::Vector3d(0.5, 0.5, 1.2), 200.0, true, allowed_px});
    std::vector<uint32_t> drawn;
    for (const DetailLevels::Range& range : ranges) {
      const auto from = levels.indices().begin() + static_cast<std::ptrdiff_t>(range.first);
      drawn.insert(drawn.end(), from, from + static_cast<std::ptrdiff_t>(range.count));
    }
    EXPECT_GT(ranges.size(), 4U);
    EXPECT_LT(drawn.size(), surfaces.indices.size());
    // The faces' own borders, and no crack besides.
    EXPECT_EQ(rims(drawn), rims(surfaces.indices)) << allowed_px << " px";
  }
}

TEST(DetailLevels, PackedVerticesMakeTheSameTriangles) {
  const Geometry& surfaces = noisy_room();
  const DetailLevels& levels = levels_of_noisy_room();
  const Geometry packed = levels.packed(surfaces);
  ASSERT_EQ(packed.indices.size(), levels.indices().size());
  using Triangle = std::array<std::array<float, 3>, 3>;
  for (const DetailLevels::Range& range :
       levels.choose({everything(), Eigen::Vector3d(0.5, 0.5, 1.2), 200.0, true, 1.0})) {
    std::multiset<Triangle> expected, found;
    const auto add = [](std::multiset<Triangle>& to, const Geometry& from, const uint32_t* at) {
      Triangle triangle{from.vertices[at[0]].position_m, from.vertices[at[1]].position_m,
                        from.vertices[at[2]].position_m};
      std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                  triangle.end());
      to.insert(triangle);
    };
    for (std::size_t i = range.first; i < range.first + range.count; i += 3) {
      add(expected, surfaces, &levels.indices()[i]);
      add(found, packed, &packed.indices[i]);
    }
    EXPECT_EQ(expected, found);
  }
}

// A floor that is folded up to a low step. The normals along the crease are means of both, and on a
// triangle of a metre would shade all of it.
TEST(DetailLevels, LargeTrianglesAreNotLitAsTheCreasesTheyEndAt) {
  TriangleMesh folded;
  testing::add_face(folded, {0, 0, 0}, {4, 0, 0}, {0, 2, 0}, 0.03F);
  std::mt19937 random(11);
  std::normal_distribution<float> noise(0.0F, 0.001F);
  for (Eigen::Vector3f& vertex : folded.vertices_m) {
    if (vertex.x() > 3.7F) vertex = {3.7F, vertex.y(), vertex.x() - 3.7F};
    vertex += noise(random) * Eigen::Vector3f(-1, 0, 1);
  }
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(folded)});
  const Geometry surfaces = build_geometry(scene).surfaces;
  const DetailLevels levels(surfaces);
  const Geometry packed = levels.packed(surfaces);
  double all_m2 = 0.0, wrong_m2 = 0.0;
  for (const DetailLevels::Range& range :
       levels.choose({everything(), Eigen::Vector3d::Zero(), 100.0, false, 1.0})) {
    for (std::size_t i = range.first; i < range.first + range.count; i += 3) {
      const auto at = [&](std::size_t k) -> const Vertex& {
        return packed.vertices[packed.indices[i + k]];
      };
      const Eigen::Vector3f a(at(0).position_m.data()), b(at(1).position_m.data()),
          c(at(2).position_m.data());
      const Eigen::Vector3f normal = (b - a).cross(c - a);
      const double area_m2 = 0.5 * static_cast<double>(normal.norm());
      all_m2 += area_m2;
      const auto is_wrong = [&](const Vertex& corner) {
        return corner.unit_normal().dot(normal.normalized()) < 0.8F;  // 37 deg
      };
      if (is_wrong(at(0)) || is_wrong(at(1)) || is_wrong(at(2))) wrong_m2 += area_m2;
    }
  }
  EXPECT_GT(all_m2, 7.9);
}

// A noisy wall across the very middle of a floor, where parts would be divided: kept whole, all of
// it but its rims can go.
TEST(DetailLevels, AWallIsNotTornByABorderThatRunsAlongIt) {
  TriangleMesh mesh;
  testing::add_face(mesh, {0, 0, 0}, {4, 0, 0}, {0, 1, 0}, 0.05F);
  testing::add_face(mesh, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0.02F);
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0F, 0.003F);
  for (Eigen::Vector3f& vertex : mesh.vertices_m)
    vertex += noise(random) * Eigen::Vector3f(1, 1, 1);
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh)});
  const Geometry surfaces = build_geometry(scene).surfaces;
  const DetailLevels levels(surfaces);
  // An error of 3 cm, ten times the noise, anywhere. Torn, a fifth is left.
  const auto ranges = levels.choose({everything(), Eigen::Vector3d::Zero(), 100.0, false, 3.2});
  EXPECT_LT(count(ranges), surfaces.indices.size() / 7);
}

// A quadric calls a wall whose points scatter by 3 mm off by centimetres once few triangles are
// left.
TEST(DetailLevels, ALevelIsAsFarFromTheSurfaceAsIsMeasured) {
  TriangleMesh wall;
  testing::add_face(wall, {0, 0, 0}, {3, 0, 0}, {0, 0, 3}, 0.03F);
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.0F, 0.003F);
  for (Eigen::Vector3f& vertex : wall.vertices_m) vertex.y() += noise(random);
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(wall)});
  const Geometry surfaces = build_geometry(scene).surfaces;
  const DetailLevels levels(surfaces);
  for (const double allowed_m : {0.008, 0.012, 0.016}) {
    const auto ranges =
        levels.choose({everything(), Eigen::Vector3d::Zero(), 1.0, false, allowed_m});
    TriangleMesh drawn{wall.vertices_m, {}, {}, {}};
    for (const DetailLevels::Range& range : ranges) {
      for (std::size_t i = range.first; i < range.first + range.count; i += 3) {
        const uint32_t* const at = &levels.indices()[i];
        drawn.triangles.push_back({at[0], at[1], at[2]});
      }
    }
    const MeshDistance distance(drawn, 0.1F);
    float farthest_m = 0.0F;
    for (const Eigen::Vector3f& vertex : wall.vertices_m) {
      farthest_m = std::max(farthest_m, distance(vertex));
    }
    // Of a large part, every few corners are looked at.
    EXPECT_LT(farthest_m, 1.3 * allowed_m);
    // What scatters by 3 mm is 12 mm from a plane at most: two triangles and the rim.
    if (allowed_m > 0.015) {
      EXPECT_LT(count(ranges), surfaces.indices.size() / 30);
    }
  }
}

TEST(DetailLevels, NothingHasNone) {
  EXPECT_TRUE(DetailLevels(Geometry{}).choose(DetailLevels::View{}).empty());
}

TEST(DetailLevels, ThePictureKeepsItsDepths) {
  const Scene scene = testing::room_scene(0.05F, 0.002F);
  Renderer renderer;
  renderer.load(scene);
  const Camera camera = camera_at(make_pose3({0.4, 2.0, 1.4}));
  Look look;
  const std::vector<float> whole = renderer.draw_depth_m(camera, look, kLevelSize);
  look.detail_px = 1.0;
  const std::vector<float> fewer = renderer.draw_depth_m(camera, look, kLevelSize);
  std::size_t near = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (std::isinf(whole[i]) && std::isinf(fewer[i])) ++near;
    // A pixel is 9 mm wide at a metre, and floors and side walls are seen at a slant of 1 in 3 or
    // flatter: 1 px across is some 3 % of the distance along the sight.
    if (std::abs(whole[i] - fewer[i]) < 0.03F * whole[i]) ++near;
  }
  // But for edges of things, where a pixel's shift changes what is seen.
  EXPECT_GT(static_cast<double>(near), 0.97 * static_cast<double>(whole.size()));
  look.detail_px = 0.0;
  EXPECT_EQ(renderer.draw_depth_m(camera, look, kLevelSize), whole);
}

}  // namespace
}  // namespace marco::viewer
