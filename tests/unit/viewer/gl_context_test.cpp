#include "viewer/gl_context.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "tests/unit/viewer/tiny_room.hpp"
#include "viewer/image_io.hpp"
#include "viewer/renderer.hpp"

namespace marco::viewer {
namespace {

constexpr int kNotBuilt = 3;

// Runs in a process of its own: Mesa's two ways share what they know of the current context.
[[noreturn]] void draw_through(const char* kind, const std::string& path) {
  ::setenv("MARCO_OPENGL", kind, 1);
  std::filesystem::remove(path);  // here, since the whole test runs again in each process
  try {
    Renderer renderer;
    renderer.load(testing::room_scene(0.1F, 0.01F));
    Look look;
    look.back_faces = BackFaces::faint;
    write_png(
        renderer.draw(camera_at(make_pose3({1.0, 2.0, 1.25}, 0.0, 0.2, 0.3)), look, {640, 360}),
        path);
  } catch (const std::invalid_argument&) {
    std::_Exit(kNotBuilt);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "%s\n", failure.what());
    std::_Exit(1);
  }
  std::_Exit(0);
}

bool drew_or_is_not_built(int status) {
  return WIFEXITED(status) && (WEXITSTATUS(status) == 0 || WEXITSTATUS(status) == kNotBuilt);
}

TEST(GlContextDeathTest, OsmesaAndEglDrawTheSamePicture) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const std::string folder = ::testing::TempDir();
  const std::string osmesa = folder + "/marco_osmesa.png", egl = folder + "/marco_egl.png";
  EXPECT_EXIT(draw_through("osmesa", osmesa), drew_or_is_not_built, "");
  EXPECT_EXIT(draw_through("egl", egl), drew_or_is_not_built, "");
  ASSERT_TRUE(std::filesystem::exists(osmesa) || std::filesystem::exists(egl));
  if (!std::filesystem::exists(osmesa) || !std::filesystem::exists(egl))
    GTEST_SKIP() << "SKIPPED: this build has one of OSMesa and EGL only";
  const Picture first = read_picture(osmesa), second = read_picture(egl);
  std::set<int> tones;
  for (const Rgb& pixel : first.pixels) tones.insert(pixel.green);
  EXPECT_GT(tones.size(), 20U);  // a room, not a blank
  EXPECT_EQ(first.pixels, second.pixels);
  std::filesystem::remove(osmesa);
  std::filesystem::remove(egl);
}

TEST(GlContextDeathTest, AnUnknownWayIsRefusedByName) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(draw_through("glx", "none.png"), ::testing::ExitedWithCode(kNotBuilt), "");
}

}  // namespace
}  // namespace marco::viewer
