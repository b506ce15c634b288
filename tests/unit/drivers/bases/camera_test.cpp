#include <gmock/gmock.h>

#include <fstream>

#include "drivers/camera/source.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "simulator/live/live_cameras.hpp"

namespace marco {
namespace {

using drivers::camera::compress_rgb;
using drivers::camera::open_source;
using drivers::camera::Picture;

/// A room of 6 m x 6 m, its far wall black, a glass pane at x = 4.
sim::World room() {
  sim::WorldSpec spec;
  spec.floor_m = {0, 0, 6, 6};
  sim::WallSpec wall;
  wall.corners_m = {6, 6, 0, 6, 0, 0, 6, 0};
  sim::WallSpec black;
  black.corners_m = {6, 0, 6, 6};
  black.material = "black";
  sim::BoxSpec pane;
  pane.at_m = {4, 3};
  pane.size_m = {0.02, 1.0, 2.0};
  pane.material = "glass";
  spec.walls = {wall, black};
  spec.boxes = {pane};
  return sim::build_world(spec);
}

struct Seen {
  Seen(const sim::RayCaster& rays, const Pose3& pose) : rgb(sim::picture_of(rays, pose, view)) {}
  int brightness(int column, int row) const {
    const auto at = static_cast<std::size_t>(3 * (row * view.width_px + column));
    return rgb[at] + rgb[at + 1] + rgb[at + 2];
  }
  sim::CameraView view;
  std::vector<uint8_t> rgb;
};

TEST(CameraView, ShowsTheRoomTheRightWayUp) {
  const sim::RayCaster rays(room());
  const Seen ahead(rays, make_pose3({1, 3, 1.0}));
  ASSERT_EQ(ahead.rgb.size(), 240U * 180U * 3U);
  // The black wall ahead is darker than ceiling and floor; the ceiling, above, is the brightest.
  EXPECT_LT(ahead.brightness(40, 90), 90);
  EXPECT_GT(ahead.brightness(120, 2), ahead.brightness(120, 177));
  EXPECT_GT(ahead.brightness(120, 177), ahead.brightness(40, 90) + 60);
  // Turned left by 60 degrees the left wall is at the left of the picture, the black one at its
  // right.
  const Seen left(rays, make_pose3({3, 3, 1.0}, 0, 0, deg_to_rad(45)));
  EXPECT_GT(left.brightness(10, 90), left.brightness(230, 90) + 60);
}

TEST(CameraView, LooksThroughGlassWithATint) {
  const sim::RayCaster rays(room());
  const Seen through(rays, make_pose3({1, 3, 1.0}));
  const Seen beside(rays, make_pose3({1, 1, 1.0}));
  EXPECT_LT(through.brightness(120, 90), beside.brightness(120, 90));
  EXPECT_GT(through.brightness(120, 90), beside.brightness(120, 90) / 2);
}

TEST(CameraView, AWallsWidthIsWhatTheFocalLengthSays) {
  const sim::RayCaster rays(room());
  const Seen ahead(rays, make_pose3({1, 3, 1.0}));
  // The pane's edges at 0.5 m to each side, 2.99 m ahead.
  const double half_px = ahead.view.focal_length_px() * 0.5 / 2.99;
  int tinted = 0;
  std::string row;
  for (int column = 40; column < 200; ++column) {
    tinted += ahead.brightness(column, 80) < ahead.brightness(40, 80) - 4 ? 1 : 0;
    row += std::to_string(ahead.brightness(column, 80)) + " ";
  }
  EXPECT_NEAR(tinted, 2 * half_px, 1.5) << row;
}

TEST(LiveCameras, TakesPicturesInStepFromWhereTheyAre) {
  const sim::RayCaster rays(room());
  sim::RobotSpec spec;
  spec.pantilt.fitted = true;
  spec.cameras.resize(2);
  spec.cameras[0].rate_hz = 5.0;
  spec.cameras[1].mount = "pantilt";
  for (auto& camera : spec.cameras) camera.view = {32, 24, 60.0};
  sim::LiveCameras cameras(rays, spec);
  int first = 0, second = 0;
  for (int i = 0; i < 100; ++i) {  // two seconds of poses
    if (i == 50) cameras.on_pantilt({});
    const TruePose pose{Utime::from_us(1'000'000 + i * 20'000), {3, 3, 0}};
    for (const auto& shot : cameras.on_pose(pose)) {
      EXPECT_EQ(shot.utime, pose.utime);
      EXPECT_EQ(shot.rgb.size(), 32U * 24U * 3U);
      ++(shot.camera == 0 ? first : second);
    }
  }
  EXPECT_EQ(first, 10);
  EXPECT_EQ(second, 1);
  EXPECT_NEAR(cameras.info(0).focal_length_px, 16 / std::tan(deg_to_rad(30)), 1e-9);
  spec.cameras[0].mount = "mast";
  EXPECT_THROW(sim::LiveCameras(rays, spec), std::invalid_argument);
}

void write(const std::string& path, const std::vector<uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::app)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
}

Picture grey(int width_px, int level) {
  const std::vector<uint8_t> rgb(static_cast<std::size_t>(width_px) * 48 * 3,
                                 static_cast<uint8_t>(level));
  return compress_rgb(rgb, width_px, 48, 85);
}

TEST(PictureSource, AFolderGivesItsPicturesInOrderAgainAndAgain) {
  const testing::TemporaryFolder folder;
  EXPECT_EQ(open_source(folder.path().string(), {}), nullptr);  // nothing in it
  write((folder.path() / "b.jpg").string(), grey(80, 200).jpeg);
  write((folder.path() / "a.JPG").string(), grey(64, 100).jpeg);
  write((folder.path() / "ab.jpg").string(), {1, 2, 3});  // no picture: passed by
  write((folder.path() / "notes.txt").string(), {1});
  const auto source = open_source(folder.path().string(), {});
  ASSERT_NE(source, nullptr);
  EXPECT_FALSE(source->keeps_its_own_time());
  for (const int width : {64, 80, 64}) {
    const auto picture = source->next();
    ASSERT_TRUE(picture.has_value());
    EXPECT_EQ(picture->width_px, width);
    EXPECT_EQ(picture->height_px, 48);
    EXPECT_EQ(picture->jpeg[0], 0xFF);
    EXPECT_EQ(picture->jpeg[1], 0xD8);
  }
}

TEST(PictureSource, AFilmEnds) {
  const testing::TemporaryFolder folder;
  const std::string film = (folder.path() / "film.mjpeg").string();
  for (int i = 0; i < 7; ++i) write(film, grey(64, 30 * i).jpeg);
  const auto source = open_source(film, {});
  ASSERT_NE(source, nullptr);
  EXPECT_FALSE(source->keeps_its_own_time());
  int pictures = 0;
  while (pictures < 20 && source->next()) ++pictures;
  EXPECT_EQ(pictures, 7);
  EXPECT_EQ(open_source((folder.path() / "missing.avi").string(), {}), nullptr);
  EXPECT_EQ(open_source("97", {}), nullptr);  // /dev/video97
}

}  // namespace
}  // namespace marco
