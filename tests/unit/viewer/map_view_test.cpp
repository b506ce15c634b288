#include "viewer/map_view.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/viewer/tiny_map.hpp"
#include "viewer/map_extent.hpp"
#include "viewer/map_picture.hpp"
#include "viewer/process/render_command.hpp"

namespace marco::viewer {
namespace {

using testing::fill;
using testing::room_map;
using testing::room_map_scene;

constexpr PictureSize kSize{320, 180};

RenderRequest request_for(const std::string& camera) {
  RenderRequest request;
  request.size = kSize;
  request.camera = camera;
  return request;
}

bool is_background(Rgb pixel) { return pixel == Look{}.background; }

double part_filled(const Picture& picture) {
  const auto empty = std::count_if(picture.pixels.begin(), picture.pixels.end(), is_background);
  return 1.0 - static_cast<double>(empty) / static_cast<double>(picture.pixels.size());
}

// The slow oracle: where a horizontal ray from inside the room meets wall or pillar.
double distance_to_walls_m(const Eigen::Vector2d& from_m, const Eigen::Vector2d& direction) {
  for (double distance_m = 0.0;; distance_m += 0.001) {
    const Eigen::Vector2d at = from_m + distance_m * direction;
    const bool pillar = at.x() > 5.0 && at.x() < 5.4 && at.y() > 3.0 && at.y() < 3.4;
    if (pillar || at.x() < 0.0 || at.x() > 6.0 || at.y() < 0.0 || at.y() > 4.0) return distance_m;
  }
}

struct Seen {
  ViewPlan plan;
  std::vector<float> depths_m;

  float at(int x, int y) const {
    return depths_m[static_cast<std::size_t>(y) * kSize.width_px + x];
  }
};

Seen see(const std::string& camera) {
  const Scene scene = scene_in_space(room_map_scene(), request_for(camera));
  Renderer renderer;
  renderer.load(scene);
  Seen seen{plan_request(scene, request_for(camera), renderer), {}};
  seen.depths_m = renderer.draw_depth_m(seen.plan.camera, seen.plan.look, kSize);
  return seen;
}

TEST(MapView, TheEyeSeesTheWallsWhereTheMapHasThem) {
  for (const char* camera : {"eye", "robot", "1.5,1,1,70,0"}) {
    const Seen seen = see(camera);
    const Camera& eye = seen.plan.camera;
    const Eigen::Vector3d ahead = (eye.target_m - eye.eye_m).normalized();
    const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ());
    const double half = std::tan(0.5 * eye.field_of_view_rad) * kSize.aspect();
    int columns = 0;
    for (int x = 5; x < kSize.width_px; x += 10, ++columns) {
      const double slope = (2.0 * (x + 0.5) / kSize.width_px - 1.0) * half;
      const Eigen::Vector2d ray = (ahead + slope * right).head<2>();
      const double expected_m = distance_to_walls_m(eye.eye_m.head<2>(), ray.normalized());
      // Depth is along the line of sight; walls lie where their cells are, a pixel is wide.
      EXPECT_NEAR(static_cast<double>(seen.at(x, 89)), expected_m / ray.norm(), 0.12)
          << camera << " column " << x;
    }
    EXPECT_EQ(columns, 32);
  }
}

TEST(MapView, WallsEndAtTheirHeightAndTheFloorLiesBelow) {
  constexpr double kWallM = 2.0, kEyeM = 0.9;  // the wall at x = 6 is 2 m ahead
  const Seen seen = see("4,1.5,0.9,0,0");
  const auto row_of = [](double height_m, double distance_m) {
    const double focal_px = 0.5 * kSize.height_px / std::tan(deg_to_rad(40.0));
    return static_cast<int>(0.5 * kSize.height_px - focal_px * (height_m - kEyeM) / distance_m);
  };
  for (const int row : {row_of(2.5, kWallM) + 3, 90, row_of(0.0, kWallM) - 3})
    EXPECT_NEAR(static_cast<double>(seen.at(160, row)), kWallM, 0.02) << row;
  EXPECT_TRUE(std::isinf(seen.at(160, 0)));  // above the wall, 2.5 m high
  for (const double distance_m : {1.8, 1.5, 1.2})
    EXPECT_NEAR(static_cast<double>(seen.at(160, row_of(0.0, distance_m))), distance_m, 0.05);
  RenderRequest low = request_for("4,1.5,0.9,0,0");
  low.wall_height_m = 1.2;
  const Picture picture = render_scene(room_map_scene(), low);
  EXPECT_TRUE(is_background(picture.at(160, row_of(1.2, kWallM) - 3)));
  EXPECT_FALSE(is_background(picture.at(160, row_of(1.2, kWallM) + 3)));
}

TEST(MapView, TheEyesPictureIsNotEmpty) {
  EXPECT_GT(part_filled(render_scene(room_map_scene(), request_for("eye"))), 0.6);
}

TEST(MapView, AboveIsTurnedAsTheFlatMap) {
  const Scene scene = room_map_scene();
  const MapFrame flat = draw_map(scene).frame;
  const Camera above = see("above").plan.camera;
  const auto px = [&](double x, double y) -> Eigen::Vector2d {
    return project(above, {x, y, 0.0}, kSize.width_px, kSize.height_px).head<2>();
  };
  for (const double y : {0.0, 4.0}) {  // a step east leads right in both, and nowhere else
    EXPECT_GT(flat.to_px({6.0, y}).x(), flat.to_px({0.0, y}).x());
    EXPECT_GT(px(6.0, y).x(), px(0.0, y).x() + 50.0);
    EXPECT_NEAR(px(6.0, y).y(), px(0.0, y).y(), 1e-6);
  }
  EXPECT_LT(flat.to_px({3.0, 4.0}).y(), flat.to_px({3.0, 0.0}).y());
  EXPECT_LT(px(3.0, 4.0).y(), px(3.0, 0.0).y() - 50.0);
  EXPECT_NEAR(px(3.0, 4.0).x(), px(3.0, 0.0).x(), 1e-6);
  // The pillar stands in the picture's upper right: its top hides the floor behind it.
  const Seen seen = see("above");
  const Eigen::Vector3d top = project(above, {5.2, 3.2, 2.5}, kSize.width_px, kSize.height_px);
  EXPECT_NEAR(static_cast<double>(seen.at(static_cast<int>(top.x()), static_cast<int>(top.y()))),
              top.z(), 0.1);
}

TEST(MapView, TheSheetHasFourFilledPanesThatDiffer) {
  RenderRequest request = request_for("sheet");
  const Picture sheet = render_sheet(room_map_scene(), request);
  const int gap = (sheet.width_px - 2 * kSize.width_px) / 3;
  std::vector<Picture> panes;
  for (int i = 0; i < 4; ++i) {
    Picture pane(kSize.width_px, kSize.height_px, {});
    const int left = gap + (i % 2) * (kSize.width_px + gap);
    const int top = gap + (i / 2) * (kSize.height_px + gap);
    for (int y = 0; y < kSize.height_px; ++y)
      for (int x = 0; x < kSize.width_px; ++x) pane.at(x, y) = sheet.at(left + x, top + y);
    EXPECT_GT(part_filled(pane), 0.2) << i;
    for (const Picture& other : panes) EXPECT_NE(pane.pixels, other.pixels) << i;
    panes.push_back(pane);
  }
}

TEST(MapView, AWalkThroughAMapSeesItsWalls) {
  std::vector<Picture> seen;
  const std::string keys = "aai";
  std::size_t at = 0;
  render_walk_by_keys(
      room_map_scene(), request_for(""), [&] { return at < keys.size() ? keys[at++] : '\0'; },
      [&](const Picture& picture) { seen.push_back(picture); });
  ASSERT_EQ(seen.size(), 4U);
  for (const Picture& picture : seen) EXPECT_GT(part_filled(picture), 0.6);
  EXPECT_NE(seen[0].pixels, seen[2].pixels);
}

TEST(BestOutlook, LooksDownTheCorridorFromAFreePlaceOnThePath) {
  GridMap grid = testing::unknown_map(24.0, 24.0);
  fill(grid, {2.9, -0.1}, {5.1, 20.1}, 100);
  fill(grid, {3.0, 0.0}, {5.0, 20.0}, 5);
  Trajectory path;
  for (int i = 0; i < 50; ++i) path.push_back({Utime::from_us(i), {3.1, 4.0, 0.0}});  // at the wall
  path.push_back({Utime::from_us(60), {4.0, 2.0, 0.0}});
  path.push_back({Utime::from_us(70), {40.0, 2.0, 0.0}});  // off the map
  const Pose2 place = best_outlook(grid, path);
  EXPECT_NEAR(place.x_m, 4.0, 1e-9);
  EXPECT_NEAR(place.y_m, 2.0, 1e-9);
  EXPECT_NEAR(place.theta_rad, deg_to_rad(90.0), deg_to_rad(5.1));
  const Pose2 anywhere = best_outlook(grid, {});
  EXPECT_GT(anywhere.x_m, 3.4);
  EXPECT_LT(anywhere.x_m, 4.6);
}

// A beam through the door to a far place: a line of free cells with a hit at its end.
GridMap room_with_a_stray_beam() {
  GridMap grid = testing::unknown_map(42.0, 6.0);
  const GridMap room = room_map();
  for (int y = 0; y < room.height_cells; ++y)
    for (int x = 0; x < room.width_cells; ++x) testing::set_cell(grid, {x, y}, room.at(x, y));
  fill(grid, {5.9, 2.0}, {18.0, 2.05}, 40);
  fill(grid, {18.0, 2.0}, {18.05, 2.05}, 70);
  return grid;
}

TEST(MapExtent, OneStrayBeamLiesBeyondAndIsCounted) {
  const GridMap grid = room_with_a_stray_beam();
  const auto extent = find_extent(grid);
  ASSERT_TRUE(extent.has_value());
  EXPECT_NEAR(extent->max_m(grid).x(), 6.1, 1e-9);
  EXPECT_NEAR(extent->min_m(grid).x(), -0.1, 1e-9);
  EXPECT_EQ(extent->cells_beyond, 239U);  // 11.95 m in cells of 5 cm
  Scene scene = room_map_scene();
  scene.grid = grid;
  scene.points.push_back({{{18.0F, 2.0F, 0.0F}}, palette::kScanPoints, ""});
  EXPECT_LT(draw_map(scene).frame.max_m.x(), 6.7);
  EXPECT_LT(map_box(grid, 2.5).max_m.x(), 6.2);
  // The legend has a line more.
  const Picture cut = draw_map(scene).picture;
  scene.grid = room_map();
  scene.points.clear();
  EXPECT_NE(cut.pixels, draw_map(scene).picture.pixels);
}

TEST(MapExtent, AMapOfFewBeamsIsShownWhole) {
  GridMap grid = testing::unknown_map(20.0, 6.0);
  fill(grid, {0.0, 0.0}, {1.0, 1.0}, 40);
  for (const double y : {0.2, 0.4, 0.6}) fill(grid, {1.0, y}, {15.0, y + 0.05}, 40);
  const auto extent = find_extent(grid);
  ASSERT_TRUE(extent.has_value());
  EXPECT_NEAR(extent->max_m(grid).x(), 15.0, 1e-9);
  EXPECT_EQ(extent->cells_beyond, 0U);
  EXPECT_FALSE(find_extent(testing::unknown_map(2.0, 2.0)).has_value());
}

}  // namespace
}  // namespace marco::viewer
