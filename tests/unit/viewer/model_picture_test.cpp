#include "viewer/model_picture.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/viewer/tiny_room.hpp"
#include "viewer/shading.hpp"

namespace marco::viewer {
namespace {

using testing::room_scene;

constexpr PictureSize kPictureSize{320, 180};

TEST(ModelSurvey, FindsFloorCeilingAndTheSideOneSees) {
  const ModelSurvey survey = survey_model(room_scene(0.1F, 0.005F));
  // Levels are told to a bin of 5 cm, and half of the noisy floor lies below 0.
  EXPECT_NEAR(survey.floor_m, 0.0, 0.051);
  ASSERT_TRUE(survey.ceiling_m.has_value());
  EXPECT_NEAR(*survey.ceiling_m, 2.5, 0.051);
  EXPECT_TRUE(survey.visible_from_inside);
}

TEST(ModelSurvey, DoesNotTrustTrianglesThatFaceOutwards) {
  TriangleMesh mesh = testing::make_room();
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh)});
  EXPECT_FALSE(survey_model(scene).visible_from_inside);
}

TEST(ModelSurvey, ForgetsWhatWasSeenFarAwayThroughAWindow) {
  TriangleMesh mesh = testing::make_room(0.1F);
  testing::add_face(mesh, {40.0F, 10.0F, 0.0F}, {0, 3, 0}, {0, 0, 2}, 0.5F);
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh)});
  EXPECT_LT(survey_model(scene).box.max_m.x(), 6.1);
}

TEST(ModelSurvey, RefusesAModelOfNothing) {
  Scene scene;
  EXPECT_THROW(survey_model(scene), std::invalid_argument);
  scene.meshes.push_back({std::make_shared<const TriangleMesh>()});
  EXPECT_THROW(survey_model(scene), std::invalid_argument);
}

TEST(PlanView, FromAboveOneLooksIntoTheRoom) {
  const Scene scene = room_scene();
  Renderer renderer;
  renderer.load(scene);
  const ViewPlan plan = plan_view(scene, View::above, {}, Projection::perspective, kPictureSize);
  EXPECT_LT(plan.look.cut_height_m, 2.5);
  EXPECT_GT(plan.look.cut_height_m, 1.25);
  EXPECT_EQ(plan.look.back_faces, BackFaces::faint);
  Look solid = plan.look;
  solid.back_faces = BackFaces::hide;
  const std::vector<float> depths = renderer.draw_depth_m(plan.camera, solid, kPictureSize);
  // The table's top and the floor beside it are in sight: their depths are those of the points.
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(2.7, 1.8, 0.75), Eigen::Vector3d(1.0, 1.0, 0.0),
        Eigen::Vector3d(4.5, 3.0, 0.0)}) {
    const Eigen::Vector3d px =
        project(plan.camera, point, kPictureSize.width_px, kPictureSize.height_px);
    const float depth = depths[static_cast<std::size_t>(
        static_cast<int>(px.y()) * kPictureSize.width_px + static_cast<int>(px.x()))];
    // A pixel is some 3 cm wide.
    EXPECT_NEAR(depth, px.z(), 0.08);
  }
}

TEST(PlanView, EyeStandsInTheRoomAtEyeHeightOrOnThePath) {
  Scene scene = room_scene();
  const ViewPlan plan = plan_view(scene, View::eye, {}, Projection::perspective, kPictureSize);
  EXPECT_NEAR(plan.camera.eye_m.x(), 3.0, 0.1);
  EXPECT_NEAR(plan.camera.eye_m.z(), 1.25, 0.06);
  scene.paths.push_back({{{Utime::from_us(0), {1.0, 3.0, 0.0}}}, {}, ""});
  const ViewPlan on_path = plan_view(scene, View::eye, {}, Projection::perspective, kPictureSize);
  EXPECT_NEAR(on_path.camera.eye_m.y(), 3.0, 1e-9);
}

TEST(PlanView, BestHeadingLooksDownTheLongRoom) {
  Renderer renderer;
  renderer.load(room_scene());
  EXPECT_NEAR(best_heading_rad(renderer, {0.6, 2.8, 1.5}), 0.0, deg_to_rad(46.0));
}

TEST(ScaleBar, AddsADarkBarBesideTheModel) {
  const Scene scene = room_scene();
  const ViewPlan plan = plan_view(scene, View::above, {}, Projection::perspective, {640, 360});
  const Picture blank(640, 360, {255, 255, 255});
  const Picture marked = add_scale_bar(blank, plan.camera, survey_model(scene).box);
  EXPECT_NE(marked.pixels, blank.pixels);
}

TEST(HeightLegend, GoesFromTheFloorsColourUpToTheHighest) {
  const Picture blank(640, 360, {255, 255, 255});
  const Picture marked = add_height_legend(blank, {-0.2, 2.4});
  // A column within the bar, from below; words mark fewer pixels.
  std::vector<Rgb> bar;
  int columns = 0;
  for (int x = 0; x < 640; ++x) {
    std::vector<Rgb> column;
    for (int y = 359; y >= 0; --y) {
      const Rgb pixel = marked.pixels[static_cast<std::size_t>(y * 640 + x)];
      if (pixel != Rgb{255, 255, 255}) column.push_back(pixel);
    }
    if (column.size() < 40) continue;
    bar = column;
    if (++columns == 4) break;
  }
  ASSERT_GE(bar.size(), 40U);
  const auto near = [](const Rgb& pixel, double part) {
    const Eigen::Vector3d color = 255.0 * height_color(part);
    return (Eigen::Vector3d(pixel.red, pixel.green, pixel.blue) - color).norm() < 12.0;
  };
  EXPECT_TRUE(near(bar[1], 0.0));
  EXPECT_TRUE(near(bar[bar.size() / 2], 0.5));
  EXPECT_TRUE(near(bar[bar.size() - 2], 1.0));
}

}  // namespace
}  // namespace marco::viewer
