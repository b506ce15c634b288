#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

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
bool on_board(double y, double z) { return std::abs(y) <= 0.3 && z >= 0.7 && z <= 1.3; }

// Colours smooth in the place, red only on the board.
Eigen::Vector3f truth_at(const Eigen::Vector3f& p) {
  if (p.x() < 2.5F) return {250, 10, 10};
  return {80.0F, 120.0F + 40.0F * p.y(), 60.0F + 60.0F * p.z()};
}

// The wall with upright stripes 20 cm wide.
Eigen::Vector3f stripes_at(const Eigen::Vector3f& p) {
  if (p.x() < 2.5F) return truth_at(p);
  const bool bright = static_cast<int>(std::floor((p.y() + 10.0F) / 0.2F)) % 2 == 0;
  return Eigen::Vector3f::Constant(bright ? 190.0F : 60.0F);
}

// Camera axes: z ahead along world x, x to the right (-y), y down (-z).
Pose3 looking_ahead(const Eigen::Vector3d& at) {
  Pose3 pose = Pose3::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  pose.translation() = at;
  return pose;
}

// By rays, distortion undone by iteration: nothing shared with the code under test.
CameraPicture photograph(const Pose3& world_from_camera,
                         double k1,
                         Eigen::Vector3f (*colour_at)(const Eigen::Vector3f&) = truth_at) {
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
      if (on_board(board.y(), board.z())) {
        color = colour_at(board.cast<float>());
      } else if (std::abs(wall.y()) <= 1.5 && wall.z() >= 0 && wall.z() <= 2) {
        color = colour_at(wall.cast<float>());
      }
      for (int i = 0; i < 3; ++i) {
        picture.rgb.push_back(static_cast<uint8_t>(std::lround(color[i])));
      }
    }
  }
  return picture;
}

void expose(CameraPicture& picture, const Eigen::Vector3f& gain) {
  for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
    const float value = gain[static_cast<int>(i % 3)] * picture.rgb[i];
    picture.rgb[i] = static_cast<uint8_t>(std::lround(std::min(255.0F, value)));
  }
}

struct Sample {
  Eigen::Vector3f point_m;
  Eigen::Vector3f rgb;
};

// Every texel well inside a triangle.
std::vector<Sample> samples(const TexturedSurface& surface) {
  std::vector<Sample> result;
  for (const auto& t : surface.mesh.triangles) {
    constexpr int kSteps = 60;
    for (int i = 1; i < kSteps; ++i) {
      for (int j = 1; i + j < kSteps; ++j) {
        const float u = static_cast<float>(i) / kSteps, v = static_cast<float>(j) / kSteps;
        const auto mix = [&](const auto& a, const auto& b, const auto& c) {
          return ((1 - u - v) * a + u * b + v * c).eval();
        };
        const Eigen::Vector3f p = mix(surface.mesh.vertices_m[t[0]], surface.mesh.vertices_m[t[1]],
                                      surface.mesh.vertices_m[t[2]]);
        const Eigen::Vector2f uv = mix(surface.uvs[t[0]], surface.uvs[t[1]], surface.uvs[t[2]]);
        const int x = static_cast<int>(uv.x() * static_cast<float>(surface.width_px));
        const int y = static_cast<int>(uv.y() * static_cast<float>(surface.height_px));
        const uint8_t* rgb = &surface.rgb[3 * static_cast<std::size_t>(y * surface.width_px + x)];
        result.push_back({p, Eigen::Vector3f(rgb[0], rgb[1], rgb[2])});
      }
    }
  }
  return result;
}

// Of a point of the wall, in pixels (of 160 a unit): above 0 where a camera that looks ahead sees
// it, how far from what hides it or from the picture's border; below 0 how far behind.
double seen_by_px(const Eigen::Vector3d& at, const Eigen::Vector3f& point) {
  const Eigen::Vector3d way = point.cast<double>() - at;
  const double left = way.y() / way.x() * 160.0, up = way.z() / way.x() * 160.0;
  const double border = std::min(99.5 - std::abs(left), 74.5 - std::abs(up));
  if (point.x() < 2.5F) return border;
  const double to_px = 160.0 / (2.0 - at.x());  // at the board
  const double beside = std::max(std::abs(left + at.y() * to_px) - 0.3 * to_px,
                                 std::abs(up + (at.z() - 1.0) * to_px) - 0.3 * to_px);
  return std::min(border, beside);
}

struct Check {
  int seen = 0, hidden = 0;  // clearly, by more than 3 pixels
  float worst = 0.0F;        // of what is seen
  float worst_filled = 0.0F;
  int red_on_wall = 0;
};

Check check(const TexturedSurface& surface, const std::vector<Eigen::Vector3d>& cameras) {
  Check result;
  for (const Sample& sample : samples(surface)) {
    double seen_px = -1e9;
    for (const auto& at : cameras) seen_px = std::max(seen_px, seen_by_px(at, sample.point_m));
    const float off = (sample.rgb - truth_at(sample.point_m)).cwiseAbs().maxCoeff();
    result.red_on_wall += sample.point_m.x() > 2.5F && sample.rgb.x() > 110.0F;
    if (seen_px > 3.0) {
      ++result.seen;
      result.worst = std::max(result.worst, off);
    } else if (seen_px < -3.0) {
      ++result.hidden;
      result.worst_filled = std::max(result.worst_filled, off);
    }
  }
  return result;
}

const std::vector<Eigen::Vector3d> kLeftAndRight = {{0, 0.8, 1.0}, {0, -0.8, 1.0}};
const std::vector<Eigen::Vector3d> kFour = {
    {0, 0.9, 1.0}, {0, 0.3, 1.0}, {0.2, -0.4, 1.0}, {0, -0.9, 1.0}};

std::vector<CameraPicture> photographs(const std::vector<Eigen::Vector3d>& cameras) {
  std::vector<CameraPicture> pictures;
  for (const auto& at : cameras) pictures.push_back(photograph(looking_ahead(at), 0.0));
  return pictures;
}

TEST(Texture, PicturesLandWhereTheyWereTaken) {
  const std::vector<CameraPicture> pictures{photograph(looking_ahead({0, 0.8, 1.0}), -0.05),
                                            photograph(looking_ahead({0, -0.8, 1.0}), -0.05)};
  const TexturedSurface surface = paint(wall_and_board(), pictures);
  EXPECT_EQ(surface.pictures_used, 2);
  EXPECT_GT(surface.painted, 0.95);
  const Check found = check(surface, kLeftAndRight);
  EXPECT_GT(found.seen, 5000);
  EXPECT_EQ(found.red_on_wall, 0);
  // Slopes of 60 a metre, pixels of up to 2 cm and texels of 2 cm: 3 grey levels.
  EXPECT_LE(found.worst, 5.0F);
}

// What is seen is painted up to two pixels from the edge: of the wall, 9 m round the shadow and
// pixels of 1.9 cm. What is hidden takes its colour from around, and is not called painted.
TEST(Texture, WhatIsHiddenIsFilledInAndNotCalledPainted) {
  const Eigen::Vector3d camera(0, 0, 1.0);
  const TexturedSurface surface = paint(wall_and_board(), photographs({camera}));
  const Check found = check(surface, {camera});
  EXPECT_EQ(found.red_on_wall, 0);
  EXPECT_GT(found.hidden, 300);
  EXPECT_LE(found.worst, 5.0F);
  EXPECT_LE(found.worst_filled, 25.0F);  // 60 a metre, up to 0.45 m from what is seen
  // The board's shadow, 0.9 x 0.9 m of 3 x 2 m and of the board's 0.6 x 0.6.
  const double visible = 1.0 - 0.81 / 6.36, rim = 4 * 0.9 * 2 * 0.019 / 6.36;
  EXPECT_LT(surface.painted, visible + 0.002);
  EXPECT_GT(surface.painted, visible - rim);
}

// A red thing before a wall, from (x, y) = (2.8 or so, half_y) to -half_y, and its picture along
// the wall: ahead is -y, right is -x.
struct AlongAWall {
  TriangleMesh mesh;
  CameraPicture picture;

  AlongAWall(double before_wall_m, double half_y, const Eigen::Vector3d& camera) {
    const double x = 3.0 - before_wall_m;
    const auto half = static_cast<float>(half_y);
    add_quad(mesh, {3, 1.5F, 0}, {0, -3, 0}, {0, 0, 2});
    add_quad(mesh, {static_cast<float>(x), half, 0}, {0, -2 * half, 0}, {0, 0, 2});
    picture.camera = {200, 150, 160.0, 160.0, 99.5, 74.5, 0.0, 0.0};
    picture.world_from_camera.linear() << -1, 0, 0, 0, 0, -1, 0, -1, 0;
    picture.world_from_camera.translation() = camera;
    for (int i = 0; i < 200 * 150; ++i) {
      const double left = (99.5 - i % 200) / 160.0;
      const bool red = left > 0 && std::abs(camera.y() - (x - camera.x()) / left) <= half_y;
      picture.rgb.insert(picture.rgb.end(), {static_cast<uint8_t>(red ? 250 : 40), 90, 90});
    }
  }
};

TEST(Texture, APostInFrontOfAWallDoesNotBleedOntoIt) {
  const AlongAWall post(0.2, 0.05, {2.4, 1.4, 1.0});
  int on_post = 0;
  for (const Sample& sample : samples(paint(post.mesh, {post.picture}))) {
    if (sample.point_m.x() < 2.9F) {
      on_post += sample.rgb.x() > 200.0F;
    } else if (std::abs(sample.point_m.z() - 1.0F) < 0.4F) {  // within the picture
      EXPECT_LT(sample.rgb.x(), 60.0F) << sample.point_m.transpose();
    }
  }
  EXPECT_GT(on_post, 100);
}

// A board 8 cm before the wall, where a pixel is 5 cm wide and 27 cm long.
TEST(Texture, ASlantedViewDoesNotPaintWhatABoardHides) {
  const AlongAWall board(0.08, 0.4, {1.5, 8.0, 1.0});
  // Hidden are 0.84 m of the wall, and a pixel and a half on either side, of 3 m and the board's
  // 0.8.
  const double hidden = 0.84 / 3.8, rim = 2 * 1.5 * 0.27 / 3.8;
  const double painted = paint(board.mesh, {board.picture}).painted;
  EXPECT_LT(painted, 1.0 - hidden);
  EXPECT_GT(painted, 1.0 - hidden - rim);
}

// Exposures of 20 %, white balance of 10 %.
const std::vector<Eigen::Vector3f> kExposures = {{1.2F * 1.1F, 1.2F, 1.2F * 0.95F},
                                                 {0.8F, 0.8F, 0.8F * 1.1F},
                                                 {1.0F * 0.9F, 1.0F, 1.0F},
                                                 {0.9F, 0.9F, 0.9F * 0.9F}};

// Known up to a factor that is common to all pictures.
TEST(Texture, PlantedExposuresAreFound) {
  std::vector<CameraPicture> pictures = photographs(kFour);
  for (std::size_t i = 0; i < pictures.size(); ++i) expose(pictures[i], kExposures[i]);
  const auto gains = paint(wall_and_board(), pictures).gains;
  ASSERT_EQ(gains.size(), 4U);
  for (int channel = 0; channel < 3; ++channel) {
    float mean = 0.0F;
    for (std::size_t i = 0; i < 4; ++i) {
      mean += 0.25F * std::log(gains[i][channel] * kExposures[i][channel]);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(std::log(gains[i][channel] * kExposures[i][channel]) - mean, 0.0F, 0.02F)
          << "picture " << i << " channel " << channel;
    }
  }
}

TEST(Texture, EqualPicturesStayAsTheyAre) {
  for (const Eigen::Vector3f& gain : paint(wall_and_board(), photographs(kFour)).gains) {
    EXPECT_LT((gain - Eigen::Vector3f::Ones()).cwiseAbs().maxCoeff(), 0.005F);
  }
}

TEST(Texture, APictureThatSharesNothingStaysAsItIs) {
  TriangleMesh mesh = wall_and_board();
  add_quad(mesh, {3, 21.5F, 0}, {0, -3, 0}, {0, 0, 2});  // 20 m away
  std::vector<CameraPicture> pictures = photographs({kFour[0], kFour[1]});
  expose(pictures[0], kExposures[0]);
  CameraPicture alone = photographs({kFour[1]})[0];
  alone.world_from_camera.translation().y() += 20.0;
  pictures.push_back(alone);
  const auto gains = paint(mesh, pictures).gains;
  EXPECT_GT((gains[0] - Eigen::Vector3f::Ones()).norm(), 0.05F);
  EXPECT_EQ(gains[2], Eigen::Vector3f::Ones());
}

// Beside the exposure the light falls off to the picture's sides, which no gain describes.
TEST(Texture, SeamsBetweenPicturesDoNotShow) {
  std::vector<CameraPicture> pictures = photographs(kFour);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    expose(pictures[i], kExposures[i]);
    for (std::size_t k = 0; k < pictures[i].rgb.size(); ++k) {
      const double aside = (static_cast<double>(k / 3 % 200) - 99.5) / 99.5;
      pictures[i].rgb[k] =
          static_cast<uint8_t>(std::lround(pictures[i].rgb[k] * (1.0 - 0.2 * aside * aside)));
    }
  }
  TriangleMesh wall;
  add_quad(wall, {3, 1.5F, 0}, {0, -3, 0}, {0, 0, 2});
  add_quad(wall, {2, 0.3F, 0.7F}, {0, -0.6F, 0}, {0, 0, 0.6F});
  const TexturedSurface surface = paint(wall, pictures);
  std::map<std::pair<int, int>, float> green;  // by place, in cells of 3 cm, below the board
  for (const Sample& sample : samples(surface)) {
    const Eigen::Vector3f& p = sample.point_m;
    if (p.x() < 2.5F || p.z() > 0.6F || p.z() < 0.3F || std::abs(p.y()) > 1.4F) continue;
    green[{static_cast<int>(std::floor(p.y() / 0.03F)), static_cast<int>(p.z() / 0.03F)}] =
        sample.rgb.y();
  }
  float steepest = 0.0F;
  for (const auto& [place, value] : green) {
    const auto next = green.find({place.first + 1, place.second});
    if (next != green.end()) steepest = std::max(steepest, std::abs(next->second - value));
  }
  EXPECT_GT(green.size(), 500U);
  // The wall's own slope is 40 a metre, up to 2.4 over 6 cm, and vignetting takes 40 % of its 120
  // over a picture's half, 1.9 m: 6. An exposure alone would be a step of 40.
  EXPECT_LE(steepest, 8.0F);
}

// Two pictures with an error of 1.5 pixels between them: stripes keep their number and their edges
// are no wider than in one picture.
TEST(Texture, PicturesThatDoNotFitExactlyMakeNoDoubleEdges) {
  std::vector<CameraPicture> pictures{photograph(looking_ahead({0, 0.6, 1.0}), 0.0, stripes_at),
                                      photograph(looking_ahead({0, -0.4, 1.0}), 0.0, stripes_at)};
  const auto grey_part = [](const std::vector<CameraPicture>& taken) {
    int grey = 0, all = 0;
    for (const Sample& sample : samples(paint(wall_and_board(), taken))) {
      const Eigen::Vector3f& p = sample.point_m;
      if (p.x() < 2.5F || p.z() > 0.6F || std::abs(p.y()) > 1.2F) continue;
      ++all;
      grey += sample.rgb.x() > 105.0F && sample.rgb.x() < 145.0F;  // half of each
    }
    return static_cast<double>(grey) / all;
  };
  const double exact = grey_part(pictures);
  pictures[1].world_from_camera.translation().y() += 1.5 * 3.0 / 160.0;
  EXPECT_GT(exact, 0.01);
  EXPECT_LT(grey_part(pictures), 1.25 * exact);
}

// Somebody stands before the camera in one of four pictures, there the best view.
TEST(Texture, WhoMovesIsVotedOut) {
  std::vector<CameraPicture> pictures = photographs(kFour);
  for (int row = 20; row < 150; ++row) {
    for (int column = 20; column < 60; ++column) {
      uint8_t* rgb = &pictures[2].rgb[3 * static_cast<std::size_t>(row * 200 + column)];
      rgb[0] = 200, rgb[1] = rgb[2] = 20;
    }
  }
  const TexturedSurface surface = paint(wall_and_board(), pictures);
  int contradicted = 0;
  for (const Sample& sample : samples(surface)) {
    const Eigen::Vector3f& p = sample.point_m;
    int see = 0;
    for (const auto& at : kFour) see += seen_by_px(at, p) > 3.0 ? 1 : 0;
    if (p.x() < 2.5F || see < 3) continue;
    ++contradicted;
    EXPECT_LT((sample.rgb - truth_at(p)).cwiseAbs().maxCoeff(), 6.0F) << p.transpose();
  }
  EXPECT_GT(contradicted, 500);
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

// Of many small pieces, each a chart of its own: an atlas in bounds, or a word.
TEST(Texture, AnAtlasStaysWithinItsBound) {
  TriangleMesh mesh;
  for (int i = 0; i < 2000; ++i) {
    add_quad(mesh, {3, 0.5F * static_cast<float>(i % 50), 0.5F * static_cast<float>(i / 50)},
             {0, -0.4F, 0}, {0, 0, 0.4F});
  }
  TextureOptions options;
  options.max_atlas_px = 300;
  const TexturedSurface surface = paint(mesh, {}, options);
  EXPECT_LE(std::max(surface.width_px, surface.height_px), 300);
  EXPECT_EQ(surface.painted, 0.0);
  options.max_atlas_px = 150;  // 2000 charts of at least 5 x 5 texels
  EXPECT_THROW(paint(mesh, {}, options), std::invalid_argument);
}

}  // namespace
}  // namespace marco::mapping3d
