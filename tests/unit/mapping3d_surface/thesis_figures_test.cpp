#include "tests/experiments/figures/thesis_figures.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "tests/experiments/figures/photograph_figures.hpp"
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

using Lit = std::vector<bool>;

// Grey on near black.
Lit lit_pixels(const std::filesystem::path& file) {
  Lit lit;
  for (const viewer::Rgb& pixel : viewer::read_picture(file.string()).pixels)
    lit.push_back(pixel.green > 40);
  EXPECT_GT(std::count(lit.begin(), lit.end(), true), std::ssize(lit) / 100) << file;
  return lit;
}

// How much of what `lit` shows `other` shows too.
double part_of(const Lit& lit, const Lit& other) {
  double common = 0.0, all = 0.0;
  for (std::size_t i = 0; i < lit.size(); ++i) {
    all += lit[i] ? 1.0 : 0.0;
    common += lit[i] && other.at(i) ? 1.0 : 0.0;
  }
  return common / all;
}

Lit either(Lit one, const Lit& other) {
  for (std::size_t i = 0; i < one.size(); ++i) one[i] = one[i] || other.at(i);
  return one;
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
  // Of one camera: points lie on the polygons, and both ways to make polygons cover the same.
  const auto lit = [&](const char* file) { return lit_pixels(folder / file); };
  const Lit triangles = lit("5_14_triangles.png"), quads = lit("5_15_quads.png");
  // A quarter of the points stands alone: the rule leaves out triangles over jumps.
  EXPECT_GT(part_of(lit(figures[0].file.c_str()), triangles), 0.6);
  EXPECT_GT(part_of(quads, triangles), 0.95);
  EXPECT_GT(part_of(triangles, quads), 0.95);
  // From above: two stops are what the one and the other show, and each adds something.
  const Lit first = lit("5_19_first_stop.png"), second = lit("5_20_second_stop.png"),
            both = lit("5_21_both.png");
  EXPECT_GT(part_of(first, both), 0.99);  // half covered pixels may differ
  EXPECT_GT(part_of(second, both), 0.99);
  EXPECT_GT(part_of(both, either(first, second)), 0.98);
  EXPECT_LT(part_of(both, first), 0.99);
  EXPECT_LT(part_of(both, second), 0.99);
  EXPECT_THAT(figures[1].what, HasSubstr("triangles"));
  EXPECT_THAT(figures[2].what, HasSubstr("quads"));
  EXPECT_EQ(viewer::read_picture((folder / "figures.png").string()).width_px, 3 * 160 + 4 * 2);
  std::filesystem::remove_all(folder);
}

ScenePoints sweep_to(double yaw_rad, std::mt19937& random) {
  return mapping3d::place(testing::AnalyticRoom::sweep(
      make_pose3({-1.0, 0.2, 0.8}, 0.0, 0.0, yaw_rad), 40, 0.005, random));
}

// Pans of 0, 90, 180 and 270 deg, twice, the first one cut short.
TEST(ThesisFigures, AStopIsFourFullSweepsToFourSides) {
  std::mt19937 random(6);
  std::vector<ScenePoints> stop;
  for (int i = 0; i < 9; ++i) stop.push_back(sweep_to(0.5 * M_PI * (i % 4), random));
  for (std::size_t i = 3 * stop[0].columns; i < stop[0].valid.size(); ++i) stop[0].valid[i] = 0;
  const std::vector<ScenePoints> four = four_ways(stop);
  ASSERT_THAT(four, SizeIs(4));
  for (std::size_t i = 0; i < 4; ++i) {
    const double yaw_rad = 0.5 * M_PI * static_cast<double>(i + 1);
    EXPECT_GT(ahead_of(four[i]).dot(Eigen::Vector3d(std::cos(yaw_rad), std::sin(yaw_rad), 0)), 0.8);
  }
}

// Two photographs from the laser's place, one of them looking back; the model is the sweep's own.
TEST(ThesisFigures, ThePhotographThatLooksTheSweepsWayIsBesideTheModel) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "marco_photograph_figures";
  std::filesystem::create_directories(folder);
  std::mt19937 random(7);
  const std::vector<std::vector<ScenePoints>> stops{{sweep_to(0.0, random)}};
  std::vector<PosedPhotograph> photographs;
  for (const bool back : {true, false}) {
    const viewer::Rgb color = back ? viewer::Rgb{200, 0, 0} : viewer::Rgb{0, 200, 0};
    PosedPhotograph photograph{folder / (back ? "back.png" : "ahead.png"), Pose3::Identity(), 80.0};
    viewer::write_png(viewer::Picture(64, 48, color), photograph.file.string());
    const double ahead = back ? -1.0 : 1.0;
    photograph.world_from_camera.linear() << 0, 0, ahead, -ahead, 0, 0, 0, -1, 0;
    photograph.world_from_camera.translation() = Eigen::Vector3d(-1.0, 0.2, 0.8);
    photographs.push_back(photograph);
  }
  const TriangleMesh model = flat_triangles(stops[0][0]);
  EXPECT_THAT(draw_photograph_figures(folder, {}, stops, model), SizeIs(0));
  const auto figures = draw_photograph_figures(folder, photographs, stops, model);
  ASSERT_THAT(figures, SizeIs(1));
  const viewer::Picture both = viewer::read_picture((folder / figures[0].file).string());
  EXPECT_GT(both.width_px, 2 * 64);
  EXPECT_EQ(both.at(both.width_px / 4, both.height_px / 2).green, 200);
  // The room fills the model's half: hardly a pixel of white ground.
  int ground = 0;
  for (int y = 4; y < 44; ++y) {
    for (int x = 0; x < 60; ++x) {
      const viewer::Rgb& pixel = both.at(both.width_px - 4 - x, y);
      ground += pixel.red == 255 && pixel.green == 255 && pixel.blue == 255 ? 1 : 0;
    }
  }
  EXPECT_LT(ground, 40 * 60 / 4);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace marco
