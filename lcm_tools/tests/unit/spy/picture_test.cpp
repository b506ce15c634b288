#include "lcm_tools/spy/picture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
// libjpeg's header needs <cstdio> before it.
#include <jpeglib.h>

#include "bot_core/image_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "lcm_tools/spy/jpeg.hpp"
#include "lcm_tools/tests/unit/spy/spy_fixture.hpp"
#include "robot/grid_map_t.hpp"
#include "robot/lidar_raw_t.hpp"

namespace marco::spy {
namespace {

using ::testing::HasSubstr;

// Gray rows: the left half black, the right half white.
std::vector<uint8_t> half_white(std::size_t width, std::size_t height) {
  std::vector<uint8_t> pixels(width * height);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = i % width < width / 2 ? 0 : 255;
  return pixels;
}

std::vector<uint8_t> jpeg_of(std::vector<uint8_t> gray, unsigned width) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* out = nullptr;
  unsigned long bytes = 0;  // NOLINT(google-runtime-int): libjpeg's type
  jpeg_mem_dest(&encoder, &out, &bytes);
  encoder.image_width = width;
  encoder.image_height = static_cast<JDIMENSION>(gray.size()) / width;
  encoder.input_components = 1;
  encoder.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&encoder);
  jpeg_start_compress(&encoder, TRUE);
  for (std::size_t at = 0; at < gray.size(); at += width) {
    JSAMPROW row = gray.data() + at;
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  std::vector<uint8_t> jpeg(out, out + bytes);
  std::free(out);
  return jpeg;
}

template <class Message>
struct Drawn {
  Drawn(const Message& message, const char* type, double zoom = 1)
      : bytes(encoded(message)), canvas(40, 23) {
    EXPECT_EQ(test_decoder().decode(*test_decoder().schema().find(type), bytes, tree),
              lcm_schema::DecodeStatus::ok);
    draw_picture(canvas, {&tree, 1}, zoom);
  }
  // Whether the cell has dots.
  bool dots(int x, int y) const {
    return canvas.at(x, y).glyph > 0x2800 && canvas.at(x, y).glyph <= 0x28FF;
  }
  std::vector<uint8_t> bytes;
  lcm_schema::Tree tree;
  Canvas canvas;
};

// Walls 2 m ahead only: all dots lie in the upper rows, none behind.
TEST(Picture, AScanIsDrawnAheadUp) {
  bot_core::planar_lidar_t lidar = {};
  lidar.nranges = 91;
  lidar.rad0 = -0.5F;
  lidar.radstep = 1.0F / 90;
  for (int i = 0; i < 91; ++i)
    lidar.ranges.push_back(static_cast<float>(2 / std::cos(-0.5 + i / 90.0)));
  const Drawn drawn(lidar, "planar_lidar_t");
  EXPECT_EQ(picture_kind(drawn.tree), PictureKind::scan);
  EXPECT_TRUE(drawn.dots(20, 1));
  for (int y = 3; y < 20; ++y) {
    for (int x = 0; x < 40; ++x) EXPECT_FALSE(drawn.dots(x, y)) << x << ' ' << y;
  }
  EXPECT_EQ(drawn.canvas.at(20, 11).glyph, U'▲');
  EXPECT_THAT(drawn.canvas.to_text(), HasSubstr("91 of 91 beams"));
}

TEST(Picture, AScanWithItsOwnBearingsHasLeftOnTheLeft) {
  robot::lidar_raw_t lidar = {};
  lidar.num_ranges = 3;
  lidar.ranges = {1.0F, 0.0F, NAN};
  lidar.thetas = {1.5707963F, 0, 0};
  lidar.times.resize(3);
  lidar.intensities.resize(3);
  const Drawn drawn(lidar, "robot.lidar_raw_t");
  int left = 0;
  int right = 0;
  for (int y = 1; y < 21; ++y) {
    for (int x = 0; x < 40; ++x) (x < 19 ? left : right) += drawn.dots(x, y) ? 1 : 0;
  }
  EXPECT_EQ(left, 1);
  EXPECT_EQ(right, 0);
  EXPECT_THAT(drawn.canvas.to_text(), HasSubstr("1 of 3 beams"));
}

robot::grid_map_t grid() {
  robot::grid_map_t message = {};
  message.resolution_m = 0.05;
  message.width_cells = 80;
  message.height_cells = 80;
  message.size = 6400;
  message.occupancy.assign(6400, 255);
  for (std::size_t x = 0; x < 80; ++x)
    message.occupancy[79 * 80 + x] = 100;                          // wall at the largest y
  for (std::size_t i = 0; i < 800; ++i) message.occupancy[i] = 0;  // free at the smallest
  return message;
}

TEST(Picture, AGridIsDrawnWithYUp) {
  const Drawn drawn(grid(), "robot.grid_map_t");
  EXPECT_EQ(picture_kind(drawn.tree), PictureKind::grid);
  for (int x = 0; x < 40; ++x) {
    EXPECT_TRUE(drawn.dots(x, 1)) << x;
    EXPECT_EQ(drawn.canvas.at(x, 20).glyph, U'·') << x;
    EXPECT_EQ(drawn.canvas.at(x, 10).glyph, U' ') << x;
  }
  EXPECT_THAT(drawn.canvas.to_text(), HasSubstr("80 x 80 cells in 1 tile,"));
}

// Two tiles side by side: the wall of the right one lies in the right half.
TEST(Picture, TilesOfOneRevisionAreJoined) {
  robot::grid_map_t left = grid();
  left.occupancy.assign(6400, 0);
  robot::grid_map_t right = grid();
  right.origin_x_m = 4;
  std::vector<lcm_schema::Tree> tiles(2);
  const auto left_bytes = encoded(left);
  const auto right_bytes = encoded(right);
  const int type = *test_decoder().schema().find("robot.grid_map_t");
  test_decoder().decode(type, left_bytes, tiles[0]);
  test_decoder().decode(type, right_bytes, tiles[1]);
  EXPECT_TRUE(same_map_other_tile(tiles[0], tiles[1]));
  EXPECT_FALSE(same_map_other_tile(tiles[0], tiles[0]));
  for (const double zoom : {1.0, 3.0}) {
    Canvas canvas(40, 23);
    draw_picture(canvas, tiles, zoom);
    EXPECT_THAT(canvas.to_text(), HasSubstr("160 x 80 cells in 2 tiles"));
    int left_dots = 0;
    int right_dots = 0;
    for (int y = 1; y < 21; ++y) {
      for (int x = 0; x < 40; ++x)
        (x < 20 ? left_dots : right_dots) +=
            canvas.at(x, y).glyph > 0x2800 && canvas.at(x, y).glyph < 0x2900 ? 1 : 0;
    }
    EXPECT_EQ(left_dots, 0);
    EXPECT_EQ(right_dots, zoom == 1.0 ? 20 : 0);  // zoomed in, the wall at the edge is out of sight
  }
  right.revision = 1;
  const auto newer = encoded(right);
  test_decoder().decode(type, newer, tiles[1]);
  EXPECT_FALSE(same_map_other_tile(tiles[0], tiles[1]));
}

TEST(Picture, AGridWhoseSizesLieIsRefusedInWords) {
  robot::grid_map_t message = grid();
  message.width_cells = 90000;
  EXPECT_THAT(Drawn(message, "robot.grid_map_t").canvas.to_text(), HasSubstr("do not fit"));
}

bot_core::image_t image(int format, int pixel_bytes) {
  bot_core::image_t message = {};
  message.width = 80;
  message.height = 80;
  message.row_stride = 80 * pixel_bytes;
  message.pixelformat = format;
  message.size = 80 * message.row_stride;
  message.data.assign(static_cast<std::size_t>(message.size), 0);
  for (int i = 0; i < message.size / 2; ++i)
    message.data[static_cast<std::size_t>(i)] = 255;  // upper half white
  return message;
}

TEST(Picture, ImagesOfSeveralFormatsAreDrawnUpright) {
  for (const auto& [format, bytes] :
       {std::pair{1497715271, 1}, {859981650, 3}, {861030210, 3}, {1448695129, 2}}) {
    const Drawn drawn(image(format, bytes), "image_t");
    EXPECT_EQ(picture_kind(drawn.tree), PictureKind::image);
    EXPECT_EQ(drawn.canvas.at(20, 5).glyph, U'⣿') << format;
    EXPECT_EQ(drawn.canvas.at(20, 15).glyph, U' ') << format;
  }
}

TEST(Picture, AnImageThatCannotBeDrawnSaysWhy) {
  auto message = image(1497715271, 1);
  message.row_stride = 1000000;
  EXPECT_THAT(Drawn(message, "image_t").canvas.to_text(), HasSubstr("its sizes"));
  message.pixelformat = 5;
  EXPECT_THAT(Drawn(message, "image_t").canvas.to_text(), HasSubstr("pixelforma"));
  message.pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
  EXPECT_THAT(Drawn(message, "image_t").canvas.to_text(), HasSubstr("JPEG"));
  message.data = jpeg_of(half_white(64, 48), 64);
  message.size = static_cast<int32_t>(message.data.size());
  EXPECT_THAT(Drawn(message, "image_t").canvas.to_text(), HasSubstr("32 x 24 px"));
}

TEST(Jpeg, IsDecodedGrayAtHalfItsSize) {
  const auto image = decode_jpeg(jpeg_of(half_white(64, 48), 64));
  ASSERT_TRUE(image);
  ASSERT_EQ(image->width, 32);
  ASSERT_EQ(image->height, 24);
  ASSERT_EQ(image->pixels.size(), 32U * 24U);
  for (std::size_t i = 0; i < image->pixels.size(); ++i) {
    EXPECT_NEAR(image->pixels[i], i % 32 < 16 ? 0 : 255, 4) << i;
  }
}

TEST(Jpeg, SurvivesAnyBytes) {
  EXPECT_FALSE(decode_jpeg({}));
  const std::vector<uint8_t> good = jpeg_of(half_white(64, 48), 64);
  std::mt19937 random(5);
  int refused = 0;
  for (int round = 0; round < 500; ++round) {
    std::vector<uint8_t> bytes = good;
    for (int flip = 0; flip < 5; ++flip) {
      bytes[random() % bytes.size()] = static_cast<uint8_t>(random());
    }
    bytes.resize(1 + random() % bytes.size());
    const auto image = decode_jpeg(bytes);
    refused += image ? 0 : 1;
    if (!image) continue;
    EXPECT_EQ(image->pixels.size(), static_cast<std::size_t>(image->width * image->height));
  }
  EXPECT_GT(refused, 50);
  EXPECT_LT(refused, 500);
}

// Lengths and sizes of a picture come from outside: any bytes, any zoom.
TEST(Picture, SurvivesAnyBytes) {
  std::mt19937 random(11);
  bot_core::planar_lidar_t lidar = {};
  lidar.nranges = 20;
  lidar.ranges.resize(20, 1.0F);
  const std::vector<std::pair<const char*, std::vector<uint8_t>>> messages = {
      {"robot.grid_map_t", encoded(grid())},
      {"image_t", encoded(image(859981650, 3))},
      {"planar_lidar_t", encoded(lidar)}};
  lcm_schema::Tree tree;
  int drawn = 0;
  for (int round = 0; round < 600; ++round) {
    auto [type, bytes] = messages[static_cast<std::size_t>(round) % messages.size()];
    for (int flip = 0; flip < 3; ++flip) bytes[8 + random() % 60] = static_cast<uint8_t>(random());
    if (test_decoder().decode(*test_decoder().schema().find(type), bytes, tree) !=
        lcm_schema::DecodeStatus::ok)
      continue;
    Canvas canvas(30, 12);
    draw_picture(canvas, {&tree, 1}, std::pow(2.0, static_cast<double>(random() % 9) - 3));
    // A picture, or why there is none; and the row of the keys is left alone.
    const std::string text = canvas.to_text();
    EXPECT_NE(text.find_first_not_of(" \n"), std::string::npos) << type << ", round " << round;
    for (int x = 0; x < 30; ++x) EXPECT_EQ(canvas.at(x, 11).glyph, U' ') << type << "\n" << text;
    ++drawn;
  }
  EXPECT_GT(drawn, 300);
}

}  // namespace
}  // namespace marco::spy
