#include "viewer/detail_levels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

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

TEST(DetailLevels, ZeroIsEveryTriangleInViewAndMoreIsFewer) {
  const SceneGeometry geometry = build_geometry(testing::room_scene(0.1F, 0.003F));
  const std::size_t all = geometry.surfaces.indices.size();
  const DetailLevels levels(geometry.surfaces);
  const Camera over =
      fit_camera({}, bounding_box(testing::room_scene()), 0.3, 0.9, kLevelSize.aspect());
  const auto indices = [&](const Camera& camera, double allowed_px) {
    return count(levels.choose(clip_from_world(camera), camera.eye_m, 100.0, true, allowed_px));
  };
  EXPECT_EQ(indices(over, 0.0), all);
  // Parts of 800 triangles keep their rims, so that a net of 10 cm is spared a quarter.
  EXPECT_LT(indices(over, 2.0), 3 * all / 4);
  // From the room's middle two thirds lie behind or beside.
  const Camera inside = camera_at(make_pose3({5.9, 2.0, 1.2}), deg_to_rad(40.0));
  EXPECT_LT(indices(inside, 0.0), all / 2);
  EXPECT_GT(indices(inside, 0.0), 0U);
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
