#include "viewer/film.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace marco::viewer {
namespace {

TEST(Film, WritesEveryPictureItWasGiven) {
  const std::string path =
      (std::filesystem::path(::testing::TempDir()) / "marco_viewer_film.mp4").string();
  FilmWriter film(path, 64, 48, 25.0);
  for (int i = 0; i < 10; ++i) film.add(Picture(64, 48, {static_cast<uint8_t>(20 * i), 100, 200}));
  film.finish();
  EXPECT_EQ(film.frame_count(), 10);
  EXPECT_GT(std::filesystem::file_size(path), 500U);
  EXPECT_THROW(film.add(Picture(32, 48, {})), std::invalid_argument);
  std::filesystem::remove(path);
}

TEST(Film, RefusesOddSidesAndFoldersThatAreNotThere) {
  EXPECT_THROW(FilmWriter("x.mp4", 63, 48, 25.0), std::invalid_argument);
  EXPECT_THROW(FilmWriter("/no/such/folder/x.mp4", 64, 48, 25.0), std::runtime_error);
}

TEST(DriveCameras, StandOnThePathAStepApartAndLookAlongIt) {
  Trajectory path;
  for (int i = 0; i <= 100; ++i) path.push_back({Utime::from_us(i), {0.01 * i, 2.0, 0.0}});
  path.push_back({Utime::from_us(101), {std::nan(""), 0.0, 0.0}});
  const std::vector<Camera> cameras = drive_cameras(path, 0.1, 1.2);
  // 1 m in steps of 0.1 m; sums of 0.01 may fall short by a pose.
  EXPECT_GE(cameras.size(), 10U);
  EXPECT_LE(cameras.size(), 11U);
  EXPECT_DOUBLE_EQ(cameras[3].eye_m.z(), 1.2);
  EXPECT_GT((cameras[3].target_m - cameras[3].eye_m).x(), 0.99);
  EXPECT_THROW(drive_cameras({}, 0.1, 1.0), std::invalid_argument);
}

TEST(ContactSheet, PutsPicturesSideBySide) {
  const Picture sheet = contact_sheet(
      {Picture(10, 8, {255, 0, 0}), Picture(10, 8, {0, 255, 0}), Picture(10, 8, {0, 0, 255})}, 2);
  EXPECT_EQ(sheet.at(2, 2), (Rgb{255, 0, 0}));
  EXPECT_EQ(sheet.at(14, 2), (Rgb{0, 255, 0}));
  EXPECT_EQ(sheet.at(2, 12), (Rgb{0, 0, 255}));
  EXPECT_EQ(sheet.at(14, 12), palette::kPaper);
  EXPECT_THROW(contact_sheet({}, 2), std::invalid_argument);
  EXPECT_THROW(contact_sheet({Picture(10, 8, {}), Picture(9, 8, {})}, 2), std::invalid_argument);
}

}  // namespace
}  // namespace marco::viewer
