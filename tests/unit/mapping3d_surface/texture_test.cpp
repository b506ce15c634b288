#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mapping3d/surface/texture.hpp"

namespace marco::mapping3d {
namespace {

void add_quad(TriangleMesh& mesh,
              const Eigen::Vector3f& at,
              const Eigen::Vector3f& u,
              const Eigen::Vector3f& v) {
  const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.insert(mesh.vertices_m.end(), {at, at + u, at + u + v, at + v});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

// A wall at x = 3 facing -x, and a board at x = 2 that hides its middle.
TriangleMesh wall_and_board() {
  TriangleMesh mesh;
  add_quad(mesh, {3, 1.5F, 0}, {0, -3, 0}, {0, 0, 2});
  add_quad(mesh, {2, 0.3F, 0.7F}, {0, -0.6F, 0}, {0, 0, 0.6F});
  return mesh;
}

// Colours smooth in the place, red only on the board.
Eigen::Vector3f truth_at(const Eigen::Vector3f& p) {
  if (p.x() < 2.5F) return {250, 10, 10};
  return {20.0F, 120.0F + 60.0F * p.y(), 60.0F + 80.0F * p.z()};
}

// Camera axes: z ahead along world x, x to the right (-y), y down (-z).
Pose3 looking_ahead(const Eigen::Vector3d& at) {
  Pose3 pose = Pose3::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  pose.translation() = at;
  return pose;
}

// By rays, distortion undone by iteration: nothing shared with the code under test.
CameraPicture photograph(const Pose3& world_from_camera, double k1) {
  CameraPicture picture;
  picture.camera = {200, 150, 160.0, 160.0, 99.5, 74.5, k1, 0.0};
  picture.world_from_camera = world_from_camera;
  for (int row = 0; row < 150; ++row) {
    for (int column = 0; column < 200; ++column) {
      const Eigen::Vector2d seen((column - 99.5) / 160.0, (row - 74.5) / 160.0);
      Eigen::Vector2d ideal = seen;
      for (int i = 0; i < 30; ++i) ideal = seen / (1.0 + k1 * ideal.squaredNorm());
      const Eigen::Vector3d way =
          world_from_camera.linear() * Eigen::Vector3d(ideal.x(), ideal.y(), 1);
      const Eigen::Vector3d from = world_from_camera.translation();
      const auto meet = [&](double x) {
        return Eigen::Vector3d(from + way * ((x - from.x()) / way.x()));
      };
      const Eigen::Vector3d board = meet(2.0), wall = meet(3.0);
      Eigen::Vector3f color(0, 0, 0);
      if (std::abs(board.y()) <= 0.3 && board.z() >= 0.7 && board.z() <= 1.3) {
        color = truth_at(board.cast<float>());
      } else if (std::abs(wall.y()) <= 1.5 && wall.z() >= 0 && wall.z() <= 2) {
        color = truth_at(wall.cast<float>());
      }
      for (int i = 0; i < 3; ++i) {
        picture.rgb.push_back(static_cast<uint8_t>(std::lround(color[i])));
      }
    }
  }
  return picture;
}

struct Check {
  int painted = 0, unseen = 0;
  float worst = 0.0F;
  int red_on_wall = 0;
};

// Every texel well inside a triangle against the truth at its place.
Check check(const TexturedSurface& surface) {
  Check result;
  for (const auto& t : surface.mesh.triangles) {
    for (int i = 1; i < 20; ++i) {
      for (int j = 1; i + j < 20; ++j) {
        const float u = static_cast<float>(i) / 20.0F, v = static_cast<float>(j) / 20.0F;
        const auto mix = [&](const auto& a, const auto& b, const auto& c) {
          return ((1 - u - v) * a + u * b + v * c).eval();
        };
        const Eigen::Vector3f p = mix(surface.mesh.vertices_m[t[0]], surface.mesh.vertices_m[t[1]],
                                      surface.mesh.vertices_m[t[2]]);
        const Eigen::Vector2f uv = mix(surface.uvs[t[0]], surface.uvs[t[1]], surface.uvs[t[2]]);
        const int x = static_cast<int>(uv.x() * static_cast<float>(surface.width_px));
        const int y = static_cast<int>(uv.y() * static_cast<float>(surface.height_px));
        const uint8_t* rgb = &surface.rgb[3 * static_cast<std::size_t>(y * surface.width_px + x)];
        const Eigen::Vector3f color(rgb[0], rgb[1], rgb[2]);
        if (rgb[0] == 128 && rgb[1] == 128 && rgb[2] == 128) {
          ++result.unseen;
          continue;
        }
        ++result.painted;
        result.worst = std::max(result.worst, (color - truth_at(p)).cwiseAbs().maxCoeff());
        result.red_on_wall += p.x() > 2.5F && color.x() > 100.0F;
      }
    }
  }
  return result;
}

TEST(Texture, PicturesLandWhereTheyWereTaken) {
  const std::vector<CameraPicture> pictures{photograph(looking_ahead({0, 0.8, 1.0}), -0.05),
                                            photograph(looking_ahead({0, -0.8, 1.0}), -0.05)};
  const TexturedSurface surface = paint(wall_and_board(), pictures);
  EXPECT_EQ(surface.pictures_used, 2);
  EXPECT_GT(surface.painted, 0.95);
  const Check found = check(surface);
  EXPECT_GT(found.painted, 500);
  EXPECT_EQ(found.red_on_wall, 0);
  // Slopes of 80 a metre, pixels of up to 2 cm and texels of 2 cm: 3 grey levels.
  EXPECT_LE(found.worst, 5.0F);
}

TEST(Texture, WhatIsHiddenStaysUnpainted) {
  const TexturedSurface surface =
      paint(wall_and_board(), {photograph(looking_ahead({0, 0, 1.0}), 0.0)});
  const Check found = check(surface);
  EXPECT_EQ(found.red_on_wall, 0);
  EXPECT_GT(found.painted, 300);
  EXPECT_GT(found.unseen, 20);  // the board's shadow, 0.9 x 0.9 m of 3 x 2
  EXPECT_LE(found.worst, 5.0F);
}

TEST(Texture, TheBestViewWins) {
  // A second picture of another colour from far away hardly shows.
  CameraPicture far = photograph(looking_ahead({-6, 0.8, 1.0}), 0.0);
  std::fill(far.rgb.begin(), far.rgb.end(), uint8_t{255});
  const TexturedSurface surface =
      paint(wall_and_board(), {photograph(looking_ahead({1.2, 0.0, 1.0}), 0.0), far});
  int near_truth = 0, seen = 0;
  for (const auto& t : surface.mesh.triangles) {
    const Eigen::Vector3f p = (surface.mesh.vertices_m[t[0]] + surface.mesh.vertices_m[t[1]] +
                               surface.mesh.vertices_m[t[2]]) /
                              3.0F;
    if (p.x() > 2.5F) continue;  // the board, which both see
    const Eigen::Vector2f uv = (surface.uvs[t[0]] + surface.uvs[t[1]] + surface.uvs[t[2]]) / 3.0F;
    const auto x = static_cast<std::size_t>(uv.x() * static_cast<float>(surface.width_px));
    const auto y = static_cast<std::size_t>(uv.y() * static_cast<float>(surface.height_px));
    const uint8_t* rgb = &surface.rgb[3 * (y * static_cast<std::size_t>(surface.width_px) + x)];
    near_truth += rgb[1] < 15;
    ++seen;
  }
  EXPECT_EQ(seen, 2);
  EXPECT_EQ(near_truth, 2);
}

TEST(Texture, APictureThatIsNoneIsRefusedAndTheRestIsUsed) {
  CameraPicture empty;
  CameraPicture torn = photograph(looking_ahead({0, 0, 1}), 0.0);
  torn.rgb.pop_back();
  CameraPicture lost = photograph(looking_ahead({0, 0, 1}), 0.0);
  lost.world_from_camera.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const TexturedSurface surface =
      paint(wall_and_board(), {empty, torn, lost, photograph(looking_ahead({0, 0, 1}), 0.0)});
  EXPECT_EQ(surface.pictures_refused, 3);
  EXPECT_EQ(surface.pictures_used, 1);
  EXPECT_GT(surface.painted, 0.5);
  const TexturedSurface nothing = paint(TriangleMesh{}, {empty});
  EXPECT_TRUE(nothing.mesh.triangles.empty());
}

TEST(Texture, ALargeModelGetsLargerTexels) {
  TextureOptions options;
  options.max_atlas_px = 64;
  const TexturedSurface surface =
      paint(wall_and_board(), {photograph(looking_ahead({0, 0.8, 1.0}), 0.0)}, options);
  EXPECT_LE(surface.width_px, 64);
  EXPECT_LE(surface.height_px, 64);
  EXPECT_GT(surface.painted, 0.5);
}

}  // namespace
}  // namespace marco::mapping3d
