#include "viewer/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/viewer/tiny_room.hpp"

namespace marco::viewer {
namespace {

using testing::room_scene;

constexpr PictureSize kSmall{160, 90};

Camera in_the_room() { return camera_at(make_pose3({1.0, 2.0, 1.25})); }

Look plain(Coloring coloring) {
  Look look;
  look.coloring = coloring;
  look.occlusion_radius_m = 0.0;
  return look;
}

// Where a ray through the pixel's middle meets the six walls of the empty room: the slow oracle.
double distance_to_room_m(const Camera& camera, PictureSize size, int x, int y) {
  const Eigen::Matrix3d world_from_camera =
      camera_from_world(camera).topLeftCorner<3, 3>().transpose();
  const double half = std::tan(0.5 * camera.field_of_view_rad);
  const Eigen::Vector3d ray =
      world_from_camera *
      Eigen::Vector3d((2.0 * (x + 0.5) / size.width_px - 1.0) * half * size.aspect(),
                      (1.0 - 2.0 * (y + 0.5) / size.height_px) * half, -1.0);
  const Eigen::Vector3d low = Eigen::Vector3d::Zero(), high(6.0, 4.0, 2.5);
  double nearest = 1e9;
  for (int axis = 0; axis < 3; ++axis)
    if (ray[axis] != 0.0)
      nearest = std::min(nearest,
                         ((ray[axis] > 0.0 ? high : low)[axis] - camera.eye_m[axis]) / ray[axis]);
  return nearest;  // the ray's part along the line of sight is 1
}

int count_pixels(const Picture& picture, bool (*wanted)(Rgb)) {
  int sum = 0;
  for (const Rgb& pixel : picture.pixels) sum += wanted(pixel) ? 1 : 0;
  return sum;
}

TEST(Renderer, DepthIsThatOfTheKnownRoom) {
  using Eigen::Vector3f;
  TriangleMesh walls;
  const Vector3f x(6, 0, 0), y(0, 4, 0), z(0, 0, 2.5F), origin(0, 0, 0);
  testing::add_face(walls, origin, x, y, 0.5F);
  testing::add_face(walls, z, y, x, 0.5F);
  testing::add_face(walls, origin, z, x, 0.5F);
  testing::add_face(walls, y, x, z, 0.5F);
  testing::add_face(walls, origin, y, z, 0.5F);
  testing::add_face(walls, x, z, y, 0.5F);
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(walls)});
  Renderer renderer;
  renderer.load(scene);
  const Camera camera =
      camera_at(make_pose3({1.0, 2.2, 1.1}, 0.0, deg_to_rad(10.0), deg_to_rad(35.0)));
  const std::vector<float> depths = renderer.draw_depth_m(camera, plain(Coloring::grey), kSmall);
  for (int row = 0; row < kSmall.height_px; ++row)
    for (int column = 0; column < kSmall.width_px; ++column)
      // A float depth buffer over 0.05..200 m resolves 6 m to some 0.05 mm.
      ASSERT_NEAR(depths[static_cast<std::size_t>(row * kSmall.width_px + column)],
                  distance_to_room_m(camera, kSmall, column, row), 2e-3)
          << column << "," << row;
}

TEST(Renderer, NormalsTellFloorFromCeilingAndWalls) {
  Renderer renderer;
  renderer.load(room_scene(0.1F));
  Look look = plain(Coloring::normal);
  look.light = Light::thesis;
  look.lamp_m = {1.0, 2.0, 1.25};
  const Picture picture = renderer.draw(in_the_room(), look, kSmall);
  const auto bluish = [](Rgb c) { return c.blue > c.red && c.blue > c.green; };
  EXPECT_TRUE(bluish(picture.at(30, 80)));                      // floor: normal up = blue
  EXPECT_FALSE(bluish(picture.at(30, 8)));                      // ceiling: normal down
  EXPECT_LT(picture.at(80, 40).red, picture.at(80, 40).green);  // far wall: normal -x
}

TEST(Renderer, CutPlaneTakesTheCeilingOff) {
  Renderer renderer;
  renderer.load(room_scene());
  Camera camera;
  camera.eye_m = {3.0, 2.0, 12.0};
  camera.target_m = {3.0, 2.0, 0.0};
  camera.up = Eigen::Vector3d::UnitY();
  Look look = plain(Coloring::grey);
  const auto depth = [&] {
    return renderer.draw_depth_m(camera, look, kSmall)[45 * 160 + 86];  // beside the table
  };
  EXPECT_NEAR(depth(), 9.5, 0.01);
  look.cut_height_m = 2.0;
  EXPECT_NEAR(depth(), 12.0, 0.01);
  look.cut_height_m = std::numeric_limits<double>::infinity();
  look.back_faces = BackFaces::hide;
  EXPECT_NEAR(depth(), 12.0, 0.01);  // the ceiling shows its back to us
}

TEST(Renderer, FaintBackFacesLetThreeQuartersThrough) {
  TriangleMesh mesh;
  testing::add_face(mesh, {-5, -5, 1}, {0, 10, 0}, {10, 0, 0}, 10.0F);  // faces down
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh)});
  Renderer renderer;
  renderer.load(scene);
  Camera camera;
  camera.eye_m = {0.0, 0.0, 3.0};
  camera.up = Eigen::Vector3d::UnitY();
  Look look = thesis_look();
  look.lamp_m = {0.0, 0.0, 3.0};
  look.background = {0, 0, 0};
  const int shown = renderer.draw(camera, look, {40, 40}).at(20, 20).red;
  look.back_faces = BackFaces::faint;
  EXPECT_NEAR(renderer.draw(camera, look, {40, 40}).at(20, 20).red, 0.25 * shown, 2.0);
  look.back_faces = BackFaces::hide;
  EXPECT_EQ(renderer.draw(camera, look, {40, 40}).at(20, 20).red, 0);
}

TEST(Renderer, ModesShowLessAndLess) {
  Renderer renderer;
  renderer.load(room_scene(0.5F));
  const auto covered = [&](Mode mode) {
    Look look = thesis_look(mode);
    look.background = {0, 0, 255};
    return count_pixels(renderer.draw(in_the_room(), look, kSmall),
                        [](Rgb c) { return c.blue < 250; });
  };
  const int filled = covered(Mode::filled), wire = covered(Mode::wire),
            points = covered(Mode::points);
  EXPECT_EQ(filled, kSmall.width_px * kSmall.height_px);
  EXPECT_LT(wire, filled);
  EXPECT_LT(points, wire / 2);
  EXPECT_GT(points, 50);
}

TEST(Renderer, ThesisLightIsAmbientPlusDiffuse) {
  Renderer renderer;
  renderer.load(room_scene());
  Look look = thesis_look();
  look.lamp_m = {1.0, 2.0, 1.25};
  const Picture picture = renderer.draw(in_the_room(), look, {161, 91});
  // The far wall is met head-on: 0.95 * (0.3 + 0.3) of 255; no other place is brighter.
  EXPECT_NEAR(picture.at(80, 45).red, 145, 2);
  for (const Rgb& pixel : picture.pixels) EXPECT_LE(pixel.red, 147);
}

TEST(Renderer, CornersAreDarkerWithOcclusion) {
  Renderer renderer;
  renderer.load(room_scene());
  Look look = plain(Coloring::grey);
  const Picture bare = renderer.draw(in_the_room(), look, {320, 180});
  look.occlusion_radius_m = 0.45;
  const Picture shaded = renderer.draw(in_the_room(), look, {320, 180});
  const Eigen::Vector3d corner = project(in_the_room(), {5.95, 3.95, 1.25}, 320, 180);
  const int x = static_cast<int>(corner.x()), y = static_cast<int>(corner.y());
  EXPECT_LT(shaded.at(x, y).red, 0.9 * bare.at(x, y).red);
  EXPECT_NEAR(shaded.at(160, 60).red, bare.at(160, 60).red, 8);  // amid the wall
}

TEST(Renderer, DrawsPathsRobotsAndPointsOverTheFloor) {
  Scene scene = room_scene();
  Trajectory path;
  for (int i = 0; i <= 40; ++i) path.push_back({Utime::from_us(i), {1.0 + 0.1 * i, 3.0, 0.0}});
  scene.paths.push_back({path, {255, 0, 0}, "estimate"});
  scene.robots.push_back({{5.0, 3.0, 0.0}, 0.3, 0.4, {0, 255, 0}});
  scene.points.push_back({{{1.5F, 0.7F, 0.1F}}, {255, 0, 255}, ""});
  Renderer renderer;
  renderer.load(scene);
  Look look = plain(Coloring::grey);
  look.cut_height_m = 2.0;
  look.point_size_px = 6.0;
  Camera camera;
  camera.eye_m = {3.0, 2.0, 9.0};
  camera.target_m = {3.0, 2.0, 0.0};
  camera.up = Eigen::Vector3d::UnitY();
  camera.field_of_view_rad = deg_to_rad(40.0);
  const PictureSize size{640, 480};
  const Picture picture = renderer.draw(camera, look, size);
  const auto at = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector3d px = project(camera, point, size.width_px, size.height_px);
    return picture.at(static_cast<int>(px.x()), static_cast<int>(px.y()));
  };
  EXPECT_GT(at({2.0, 3.0, 0.04}).red, 3 * at({2.0, 3.0, 0.04}).green);
  EXPECT_GT(at({5.1, 3.0, 0.4}).green, 150);
  EXPECT_LT(at({5.1, 3.0, 0.4}).red, 20);
  EXPECT_EQ(at({1.5, 0.7, 0.1}), (Rgb{255, 0, 255}));
}

TEST(Renderer, TilesMeetWithoutASeam) {
  Renderer renderer;
  renderer.load(room_scene());
  Look look = plain(Coloring::height);
  look.supersampling = 4;  // 2400 px wide are then 9600 samples: two tiles
  const PictureSize large{2400, 60}, once{2400, 60};
  const Picture tiled = renderer.draw(in_the_room(), look, large);
  look.supersampling = 1;
  const Picture whole = renderer.draw(in_the_room(), look, once);
  int different = 0;
  for (std::size_t i = 0; i < tiled.pixels.size(); ++i)
    different += std::abs(tiled.pixels[i].red - whole.pixels[i].red) > 25 ? 1 : 0;
  // Only edges, which supersampling smooths, may differ.
  EXPECT_LT(different, 0.03 * static_cast<double>(tiled.pixels.size()));
}

TEST(Renderer, DrawsAnEmptySceneAndRefusesBadRequests) {
  Renderer renderer;
  const Picture nothing = renderer.draw(in_the_room(), {}, kSmall);
  EXPECT_EQ(nothing.at(80, 45), Look{}.background);
  EXPECT_THROW(renderer.draw(in_the_room(), {}, {0, 10}), std::invalid_argument);
  EXPECT_THROW(renderer.draw(in_the_room(), {}, {70000, 10}), std::invalid_argument);
  Look look;
  look.supersampling = 9;
  EXPECT_THROW(renderer.draw(in_the_room(), look, kSmall), std::invalid_argument);
}

}  // namespace
}  // namespace marco::viewer
