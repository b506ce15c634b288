#include "viewer/painted_mesh.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "viewer/image_io.hpp"

namespace marco::viewer {
namespace {

// A square whose picture is red on the left and blue on the right.
TexturedMesh square(float side_m) {
  TexturedMesh textured;
  textured.mesh.vertices_m = {{0, 0, 0}, {side_m, 0, 0}, {side_m, side_m, 0}, {0, side_m, 0}};
  textured.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  textured.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  Picture picture(2, 2, {255, 0, 0});
  picture.at(1, 0) = picture.at(1, 1) = {0, 0, 255};
  const std::string path = marco::testing::temporary_path("square.png");
  write_png(picture, path);
  std::ifstream file(path, std::ios::binary);
  textured.image.assign(std::istreambuf_iterator<char>(file), {});
  std::filesystem::remove(path);
  return textured;
}

TEST(PaintedMesh, VerticesHaveThePicturesColourAtTheirPlace) {
  const TriangleMesh painted = with_painted_vertices(square(1.0F), 0.1);
  EXPECT_GE(painted.triangles.size(), 200U);
  ASSERT_EQ(painted.colors_rgb.size(), painted.vertices_m.size());
  for (std::size_t i = 0; i < painted.vertices_m.size(); ++i) {
    const bool is_right = painted.vertices_m[i].x() >= 0.5F;
    EXPECT_EQ(painted.colors_rgb[i][is_right ? 2 : 0], 255) << i;
  }
  for (const auto& triangle : painted.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& a = painted.vertices_m[triangle[i]];
      EXPECT_LE((a - painted.vertices_m[triangle[(i + 1) % 3]]).norm(), 0.1F + 1e-5F);
    }
  }
}

TEST(PaintedMesh, AMeshOfKilometresDoesNotBecomeMoreTrianglesThanAskedFor) {
  EXPECT_LE(with_painted_vertices(square(1e6F), 0.04, 1000).triangles.size(), 1002U);
  TexturedMesh sliver = square(1e6F);
  for (auto& vertex : sliver.mesh.vertices_m) vertex.y() *= 1e-12F;
  EXPECT_LE(with_painted_vertices(sliver, 0.04, 1000).triangles.size(), 1002U);
}

}  // namespace
}  // namespace marco::viewer
