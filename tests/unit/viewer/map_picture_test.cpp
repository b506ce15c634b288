#include "viewer/map_picture.hpp"

#include <gtest/gtest.h>

namespace marco::viewer {
namespace {

// 6 x 4 m: walls round free floor, one unknown block, cells of 0.1 m.
GridMap small_map() {
  GridMap grid;
  grid.origin_m = {-2.0, 1.0};
  grid.resolution_m = 0.1;
  grid.width_cells = 60;
  grid.height_cells = 40;
  grid.occupancy.assign(60 * 40, 0);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      uint8_t& cell = grid.occupancy[static_cast<std::size_t>(y * 60 + x)];
      if (x == 0 || y == 0 || x == 59 || y == 39) cell = 100;
      if (x > 40 && x < 50 && y > 20 && y < 30) cell = GridMap::kUnknown;
    }
  }
  return grid;
}

Trajectory straight(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  Trajectory trajectory;
  for (int i = 0; i <= 20; ++i) {
    const Eigen::Vector2d at = from + (to - from) * (i / 20.0);
    trajectory.push_back({Utime::from_us(i), {at.x(), at.y(), 0.0}});
  }
  return trajectory;
}

Rgb pixel_at(const MapPicture& map, const Eigen::Vector2d& point_m) {
  const Eigen::Vector2d px = map.frame.to_px(point_m);
  return map.picture.at(static_cast<int>(px.x()), static_cast<int>(px.y()));
}

// Antialiasing and rounding may move a grey by a step or two.
bool is_like(Rgb a, Rgb b, int tolerance = 6) {
  return std::abs(a.red - b.red) <= tolerance && std::abs(a.green - b.green) <= tolerance &&
         std::abs(a.blue - b.blue) <= tolerance;
}

int count_like(const Picture& picture, Rgb color) {
  int count = 0;
  for (const Rgb& pixel : picture.pixels) count += is_like(pixel, color, 20) ? 1 : 0;
  return count;
}

TEST(MapPicture, ShowsFloorWallsAndTheUnknownWhereTheyAre) {
  Scene scene;
  scene.grid = small_map();
  const MapPicture map = draw_map(scene);
  EXPECT_TRUE(is_like(pixel_at(map, {0.05, 3.05}), palette::kFree));
  EXPECT_TRUE(is_like(pixel_at(map, {2.55, 3.55}), palette::kUnknown));  // the block
  EXPECT_TRUE(is_like(pixel_at(map, {-2.3, 3.0}), palette::kUnknown));   // beyond the grid
  EXPECT_TRUE(is_like(pixel_at(map, {-1.95, 3.05}), palette::kOccupied));
  EXPECT_TRUE(is_like(pixel_at(map, {1.05, 4.95}), palette::kOccupied));
  EXPECT_TRUE(is_like(pixel_at(map, {1.05, 1.05}), palette::kOccupied));
}

TEST(MapPicture, TheFreerACellTheLighterWithTheUnknownInTheMiddle) {
  Scene scene;
  GridMap grid;
  grid.resolution_m = 0.1;
  grid.width_cells = 101;
  grid.height_cells = 20;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 101; ++x)
      grid.occupancy.push_back(y < 10 ? static_cast<uint8_t>(x) : GridMap::kUnknown);
  scene.grid = grid;
  const MapPicture map = draw_map(scene);
  const auto tone = [&](int percent) { return pixel_at(map, {0.1 * percent + 0.05, 0.5}).green; };
  const int unknown = pixel_at(map, {5.0, 1.2}).green;
  for (int percent = 1; percent <= 100; ++percent) {
    EXPECT_LE(tone(percent), tone(percent - 1)) << percent;
    if (percent <= 50) {
      EXPECT_GE(tone(percent), unknown) << percent;
    } else {
      EXPECT_LE(tone(percent), unknown) << percent;
    }
  }
  // One beam through a cell gives 40 %, one hit 70 %: both are told from the unknown at a glance.
  EXPECT_GT(tone(40), unknown + 12);
  EXPECT_LT(tone(70), unknown - 60);
  EXPECT_GT(tone(0), tone(40) + 12);
}

TEST(MapPicture, NorthIsUpAndEastIsRight) {
  Scene scene;
  scene.grid = small_map();
  const MapFrame frame = draw_map(scene).frame;
  EXPECT_GT(frame.to_px({0.0, 2.0}).y(), frame.to_px({0.0, 4.0}).y());
  EXPECT_LT(frame.to_px({0.0, 2.0}).x(), frame.to_px({3.0, 2.0}).x());
  EXPECT_NEAR(frame.to_px({1.0, 2.0}).x() - frame.to_px({0.0, 2.0}).x(), frame.px_per_m, 1e-9);
}

TEST(MapPicture, DrawsPathsInTheirColoursAndNamesThem) {
  Scene scene;
  scene.grid = small_map();
  const int without = count_like(draw_map(scene).picture, palette::kOdometry);
  scene.paths.push_back({straight({-1.0, 2.0}, {3.0, 2.0}), palette::kOdometry, "odometry"});
  scene.paths.push_back({straight({-1.0, 3.0}, {1.0, 3.0}), palette::kEstimate, "estimate"});
  const MapPicture map = draw_map(scene);
  EXPECT_TRUE(is_like(pixel_at(map, {1.0, 2.0}), palette::kOdometry));
  EXPECT_TRUE(is_like(pixel_at(map, {0.0, 3.0}), palette::kEstimate));
  EXPECT_EQ(without, 0);
  // The legend repeats both colours below the map.
  Picture footer = map.picture;
  const int below = static_cast<int>(map.frame.to_px(map.frame.min_m).y()) + 2;
  for (int y = 0; y < below; ++y)
    for (int x = 0; x < footer.width_px; ++x) footer.at(x, y) = palette::kPaper;
  EXPECT_GT(count_like(footer, palette::kOdometry), 30);
  EXPECT_GT(count_like(footer, palette::kEstimate), 30);
}

TEST(MapPicture, NoLineIsDrawnBetweenPosesFarApart) {
  Scene scene;
  scene.grid = small_map();
  const Trajectory west = straight({-1.0, 2.0}, {0.0, 2.0}),
                   east = straight({2.0, 2.0}, {3.0, 2.0});
  Trajectory both = west;
  both.insert(both.end(), east.begin(), east.end());
  scene.paths.push_back({both, palette::kEstimate, "joined"});
  EXPECT_TRUE(is_like(pixel_at(draw_map(scene), {1.0, 2.0}), palette::kEstimate));
  scene.paths.back().longest_step_m = 1.0;
  const MapPicture parted = draw_map(scene);
  EXPECT_FALSE(is_like(pixel_at(parted, {1.0, 2.0}), palette::kEstimate));
  EXPECT_TRUE(is_like(pixel_at(parted, {-0.5, 2.0}), palette::kEstimate));
  EXPECT_TRUE(is_like(pixel_at(parted, {2.5, 2.0}), palette::kEstimate));
}

TEST(MapPicture, WordsAndBarsStayInsideTheMargins) {
  for (const int width_cells : {3, 12, 60}) {
    Scene scene;
    GridMap grid;
    grid.width_cells = width_cells;
    grid.height_cells = 60;
    grid.occupancy.assign(static_cast<std::size_t>(width_cells) * 60, 0);
    scene.grid = grid;
    for (const char* label : {"odometry", "estimate", "a very long name of a trajectory", "truth"})
      scene.paths.push_back({straight({0.0, 0.0}, {0.1, 2.0}), palette::kTruth, label});
    const Picture picture = draw_map(scene).picture;
    for (int y = 0; y < picture.height_px; ++y) {
      EXPECT_EQ(picture.at(0, y), palette::kPaper);
      EXPECT_EQ(picture.at(picture.width_px - 1, y), palette::kPaper);
    }
    for (int x = 0; x < picture.width_px; ++x) {
      EXPECT_EQ(picture.at(x, 0), palette::kPaper);
      EXPECT_EQ(picture.at(x, picture.height_px - 1), palette::kPaper);
    }
  }
}

TEST(MapPicture, OdometryFarOffDoesNotMakeTheMapSmall) {
  Scene scene;
  scene.grid = small_map();
  scene.paths.push_back({straight({0.0, 2.0}, {500.0, 900.0}), palette::kOdometry, "odometry"});
  const MapFrame frame = draw_map(scene).frame;
  EXPECT_LT((frame.max_m - frame.min_m).maxCoeff(), 10.0);
}

TEST(MapPicture, SizeFollowsFromTheExtentAndStaysReadable) {
  for (const double resolution_m : {0.01, 0.05, 0.5}) {
    Scene scene;
    scene.grid = small_map();
    scene.grid->resolution_m = resolution_m;
    const Picture picture = draw_map(scene).picture;
    EXPECT_GE(picture.width_px, 1000);
    EXPECT_LE(picture.width_px, 2000);
  }
}

TEST(MapPicture, RefusesAnEmptyWorldAndBadOptions) {
  Scene scene;
  EXPECT_THROW(draw_map(scene), std::invalid_argument);
  scene.grid = small_map();
  scene.grid->occupancy.assign(scene.grid->occupancy.size(), GridMap::kUnknown);
  EXPECT_THROW(draw_map(scene), std::invalid_argument);
  scene.grid = small_map();
  MapPictureOptions options;
  options.long_side_px = -1.0;
  EXPECT_THROW(draw_map(scene, options), std::invalid_argument);
}

TEST(RoundLength, IsOneTwoOrFiveTimesAPowerOfTen) {
  EXPECT_DOUBLE_EQ(round_length(1.0), 1.0);
  EXPECT_DOUBLE_EQ(round_length(4.9), 2.0);
  EXPECT_DOUBLE_EQ(round_length(73.0), 50.0);
  EXPECT_NEAR(round_length(0.03), 0.02, 1e-12);
  EXPECT_EQ(length_label(0.2), "20 cm");
  EXPECT_EQ(length_label(5.0), "5 m");
  EXPECT_THROW(round_length(0.0), std::invalid_argument);
}

}  // namespace
}  // namespace marco::viewer
