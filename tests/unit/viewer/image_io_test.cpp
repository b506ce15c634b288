#include "viewer/image_io.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "viewer/painted_mesh.hpp"

namespace marco::viewer {
namespace {

using ::testing::HasSubstr;

TEST(ImageIo, ReadsBackWhatItWrote) {
  Picture picture(3, 2, {10, 20, 30});
  picture.at(0, 0) = {255, 0, 0};
  picture.at(2, 1) = {0, 0, 255};
  const std::string path = marco::testing::temporary_path("round.png");
  write_png(picture, path);
  const Picture back = read_picture(path);
  EXPECT_EQ(back.width_px, 3);
  EXPECT_EQ(back.height_px, 2);
  EXPECT_EQ(back.pixels, picture.pixels);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  std::filesystem::remove(path);
}

TEST(ImageIo, SaysWhichFileCouldNotBeWrittenOrRead) {
  const Picture picture(3, 2, {});
  const std::string nowhere = marco::testing::temporary_path("no/such/folder.png");
  try {
    write_png(picture, nowhere);
    FAIL() << "a picture was written into a folder that is not there";
  } catch (const std::runtime_error& failure) {
    EXPECT_THAT(failure.what(), HasSubstr(nowhere));
  }
  EXPECT_THROW(write_png({}, nowhere), std::invalid_argument);
  EXPECT_THAT([&] { read_picture(nowhere); },
              ::testing::ThrowsMessage<std::runtime_error>(HasSubstr("there is no such file")));
  const std::string text = marco::testing::temporary_path("text.png");
  std::ofstream(text) << "not a picture";
  EXPECT_THAT([&] { read_picture(text); }, ::testing::ThrowsMessage<std::runtime_error>(
                                               HasSubstr("not a picture that OpenCV can read")));
  std::filesystem::remove(text);
}

TEST(ImageIo, SaysThatTheDiskIsFullAndLeavesNoPart) {
  const std::string path = marco::testing::temporary_path("full.png");
  std::error_code error;
  std::filesystem::create_symlink("/dev/full", path, error);
  if (error || !std::filesystem::exists("/dev/full")) {
    std::puts("SKIPPED: no /dev/full here");
    return;
  }
  try {
    write_png(Picture(300, 200, {1, 2, 3}), path);
    FAIL() << "a full disk went unnoticed";
  } catch (const std::runtime_error& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("No space left"));
  }
  EXPECT_TRUE(std::filesystem::is_symlink(path));  // a device is written into, never replaced
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  std::filesystem::remove(path);
}

TEST(PaintedMesh, ShowsThePictureWhereItLies) {
  // A picture of two halves on a wall of 2 x 1 m.
  Picture picture(4, 2, {200, 10, 10});
  for (int y = 0; y < 2; ++y) picture.at(2, y) = picture.at(3, y) = {10, 10, 200};
  const std::string path = marco::testing::temporary_path("halves.png");
  write_png(picture, path);
  std::ifstream file(path, std::ios::binary);
  TexturedMesh wall;
  wall.image.assign(std::istreambuf_iterator<char>(file), {});
  wall.mesh.vertices_m = {{0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1}};
  wall.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  wall.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  std::filesystem::remove(path);
  const TriangleMesh painted = with_painted_vertices(wall, 0.1);
  double area_m2 = 0.0;
  for (const auto& t : painted.triangles) {
    const auto& v = painted.vertices_m;
    area_m2 += 0.5 * static_cast<double>((v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm());
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LE((v[t[i]] - v[t[(i + 1) % 3]]).norm(), 0.1F);
      const float x = v[t[i]].x();
      if (std::abs(x - 1.0F) < 0.05F) continue;
      EXPECT_EQ(painted.colors_rgb[t[i]][0], x < 1.0F ? 200 : 10) << x;
    }
  }
  EXPECT_NEAR(area_m2, 2.0, 1e-4);
  wall.image = "no picture";
  EXPECT_THROW(with_painted_vertices(wall), std::invalid_argument);
  wall.image.clear();
  EXPECT_EQ(with_painted_vertices(wall).triangles.size(), 2U);
}

}  // namespace
}  // namespace marco::viewer
