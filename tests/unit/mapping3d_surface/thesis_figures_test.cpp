#include "tools/figures/thesis_figures.hpp"

#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/analytic_room.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

using mapping3d::ScenePoints;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// 3 x 3 beams 10 cm apart on a wall 1 m ahead, the middle one of the last row missing.
ScenePoints wall() {
  ScenePoints scene;
  scene.rows = scene.columns = 3;
  for (int row = 0; row < 3; ++row) {
    scene.origins_m.emplace_back(0.0F, 0.0F, 0.0F);
    for (int column = 0; column < 3; ++column) {
      scene.points_m.emplace_back(1.0F, 0.1F * static_cast<float>(1 - column),
                                  0.1F * static_cast<float>(row));
      scene.valid.push_back(row == 2 && column == 1 ? 0 : 1);
    }
  }
  return scene;
}

TEST(ThesisFigures, PolygonsHaveTheThesisNormals) {
  // Two quads touch the missing beam; of their triangles the thesis keeps those without it.
  const TriangleMesh quads = quads_as_triangles(wall());
  EXPECT_THAT(quads.triangles, SizeIs(4));
  EXPECT_THAT(quads.vertices_m, SizeIs(8));
  const TriangleMesh triangles = flat_triangles(wall());
  EXPECT_THAT(triangles.triangles, SizeIs(5));
  EXPECT_THAT(triangles.vertices_m, SizeIs(15));
  for (const TriangleMesh* mesh : {&quads, &triangles}) {
    for (const Eigen::Vector3f& normal : mesh->normals) {
      EXPECT_TRUE(normal.isApprox(-Eigen::Vector3f::UnitX(), 1e-5F));
    }
  }
  EXPECT_THAT(flat_triangles(without_ends(wall(), 1)).triangles, SizeIs(0));
}

TEST(ThesisFigures, OneCommandDrawsThemAll) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "marco_thesis_figures";
  std::filesystem::remove_all(folder);
  std::mt19937 random(5);
  const auto sweep = [&](double x, double yaw) {
    return mapping3d::place(
        testing::AnalyticRoom::sweep(make_pose3({x, 0.2, 0.8}, 0.0, 0.0, yaw), 40, 0.005, random));
  };
  FigureOptions options;
  options.size = {160, 120};
  EXPECT_THROW(draw_thesis_figures(folder, {}, options), std::invalid_argument);
  const auto figures = draw_thesis_figures(
      folder, {{sweep(-1.0, 0.0), sweep(-1.0, 1.6)}, {sweep(0.5, 0.3)}}, options);
  ASSERT_THAT(figures, SizeIs(9));
  for (const Figure& figure : figures) {
    const viewer::Picture picture = viewer::read_picture((folder / figure.file).string());
    // Grey on near black: a figure that shows something has more than a hundredth lit.
    std::size_t lit = 0;
    for (const viewer::Rgb& pixel : picture.pixels) lit += pixel.green > 40 ? 1U : 0U;
    EXPECT_GT(lit, picture.pixels.size() / 100) << figure.file;
  }
  EXPECT_THAT(figures[1].what, HasSubstr("triangles"));
  EXPECT_THAT(figures[2].what, HasSubstr("quads"));
  EXPECT_EQ(viewer::read_picture((folder / "figures.png").string()).width_px, 3 * 160 + 4 * 2);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace marco
