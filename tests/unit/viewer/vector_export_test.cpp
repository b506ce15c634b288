#include "viewer/vector_export.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/unit/viewer/tiny_room.hpp"

namespace marco::viewer {
namespace {

constexpr PictureSize kPageSize{400, 300};

std::string text_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  std::filesystem::remove(path);
  return text.str();
}

std::size_t count_words(const std::string& text, const std::string& word) {
  std::size_t sum = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++sum;
  return sum;
}

// One rectangle of 4 x 2 nets = 16 triangles on the floor, seen from straight above.
Scene floor_patch() {
  TriangleMesh mesh;
  testing::add_face(mesh, {0, 0, 0}, {4, 0, 0}, {0, 2, 0}, 1.0F);
  Scene scene;
  scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh)});
  return scene;
}

ViewPlan from_above() {
  ViewPlan plan;
  plan.camera.eye_m = {2.0, 1.0, 10.0};
  plan.camera.target_m = {2.0, 1.0, 0.0};
  plan.camera.up = Eigen::Vector3d::UnitY();
  plan.camera.field_of_view_rad = deg_to_rad(40.0);
  return plan;
}

constexpr std::size_t kPaper = 2;  // the background's triangles

TEST(VectorExport, EpsHoldsEachTriangle) {
  const std::string path = marco::testing::temporary_path("page.eps");
  const VectorReport report =
      write_vector(floor_patch(), from_above(), kPageSize, VectorFormat::eps, path);
  EXPECT_EQ(report.polygons, 16U);
  const std::string text = text_of(path);
  EXPECT_EQ(count_words(text, "%!PS-Adobe"), 1U);
  // gl2ps writes a flat triangle as "... T".
  EXPECT_EQ(count_words(text, " T\n"), 16U + kPaper);
}

TEST(VectorExport, SvgAndPdfHoldThemToo) {
  const std::string svg = marco::testing::temporary_path("page.svg");
  write_vector(floor_patch(), from_above(), kPageSize, VectorFormat::svg, svg);
  EXPECT_EQ(count_words(text_of(svg), "<polygon"), 16U + kPaper);
  const std::string pdf = marco::testing::temporary_path("page.pdf");
  write_vector(floor_patch(), from_above(), kPageSize, VectorFormat::pdf, pdf);
  EXPECT_EQ(count_words(text_of(pdf), "%PDF-"), 1U);
}

TEST(VectorExport, WireDrawsEdgesAndTheCutLeavesOutWhatIsHigher) {
  ViewPlan plan = from_above();
  plan.look.mode = Mode::wire;
  const std::string path = marco::testing::temporary_path("wire.eps");
  EXPECT_EQ(write_vector(floor_patch(), plan, kPageSize, VectorFormat::eps, path).lines, 48U);
  plan.look.mode = Mode::filled;
  plan.look.cut_height_m = -0.1;
  EXPECT_EQ(write_vector(floor_patch(), plan, kPageSize, VectorFormat::eps, path).polygons, 0U);
  plan.look.cut_height_m = 1.0;
  plan.camera.eye_m.z() = -10.0;
  plan.look.back_faces = BackFaces::hide;
  EXPECT_EQ(write_vector(floor_patch(), plan, kPageSize, VectorFormat::eps, path).polygons, 0U);
  std::filesystem::remove(path);
}

TEST(VectorExport, FromWithinARoomNothingBehindTheEyeIsDrawn) {
  const Scene scene = testing::room_scene();
  ViewPlan plan;
  plan.camera = camera_at(make_pose3({1.0, 2.0, 1.25}));
  const std::string path = marco::testing::temporary_path("room.svg");
  const VectorReport report = write_vector(scene, plan, kPageSize, VectorFormat::svg, path);
  std::filesystem::remove(path);
  EXPECT_GT(report.polygons, 50U);
  EXPECT_LT(report.polygons, scene.meshes[0].mesh->triangles.size());
}

TEST(VectorExport, SaysWhatItCannotWrite) {
  EXPECT_THROW(write_vector(floor_patch(), from_above(), kPageSize, VectorFormat::eps,
                            "/no/such/folder/x.eps"),
               std::runtime_error);
  EXPECT_THROW(vector_format("x.png"), std::invalid_argument);
  EXPECT_EQ(vector_format("a/b.svg"), VectorFormat::svg);
  if (std::filesystem::exists("/dev/full")) {
    EXPECT_THROW(
        write_vector(floor_patch(), from_above(), kPageSize, VectorFormat::eps, "/dev/full"),
        std::runtime_error);
  }
}

}  // namespace
}  // namespace marco::viewer
