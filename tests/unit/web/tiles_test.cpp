#include "web/tiles.hpp"

#include <gmock/gmock.h>
#include <png.h>

#include <nlohmann/json.hpp>

namespace marco::web {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
using Json = nlohmann::json;
using Place = Tiles::Place;

GridMap map_of(double x_m, double y_m, int width, int height, uint8_t cell = 0) {
  GridMap map;
  map.origin_m = {x_m, y_m};
  map.resolution_m = 0.1;
  map.width_cells = width;
  map.height_cells = height;
  map.occupancy.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), cell);
  return map;
}

std::vector<uint8_t> pixels_of(const std::string& base64) {
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  uint32_t bits = 0;
  int count = 0;
  for (const char c : base64) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<uint32_t>(kDigits.find(c));
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> static_cast<unsigned>(count -= 8) & 0xFFU);
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0);
  image.format = PNG_FORMAT_GRAY;
  std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0);
  return pixels;
}

TEST(TilesOfAMap, LieAtFixedPlaces) {
  Tiles tiles;
  const auto change = tiles.set(map_of(-0.5, 25.0, 10, 20));
  EXPECT_FALSE(change.clear);
  // Columns -5..4, rows 250..269: four tiles of 256 cells.
  EXPECT_THAT(change.places,
              UnorderedElementsAre(Place{-1, 0}, Place{0, 0}, Place{-1, 1}, Place{0, 1}));
  EXPECT_THAT(tiles.places(),
              UnorderedElementsAre(Place{-1, 0}, Place{0, 0}, Place{-1, 1}, Place{0, 1}));
}

TEST(TilesOfAMap, AreSentWhereTheyChanged) {
  Tiles tiles;
  GridMap map = map_of(0.0, 0.0, 512, 256);
  tiles.set(map);
  EXPECT_THAT(tiles.set(map).places, IsEmpty());
  map.occupancy[300] = 100;  // row 0
  EXPECT_THAT(tiles.set(map).places, ElementsAre(Place{1, 0}));
  // It grew to the left: its own edge moved, what stood stays where it was.
  GridMap grown = map_of(-1.0, 0.0, 522, 256, GridMap::kUnknown);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 512; ++x) {
      grown.occupancy[static_cast<std::size_t>(y * 522 + x + 10)] = map.at(x, y);
    }
  }
  grown.occupancy[0] = 50;
  EXPECT_THAT(tiles.set(grown).places, ElementsAre(Place{-1, 0}));
}

TEST(TilesOfAMap, BecomeUnknownWhereItShrank) {
  Tiles tiles;
  tiles.set(map_of(0.0, 0.0, 512, 256));
  const auto change = tiles.set(map_of(0.0, 0.0, 256, 256));
  EXPECT_THAT(change.places, ElementsAre(Place{1, 0}));
  EXPECT_THAT(tiles.places(), ElementsAre(Place{0, 0}));
  const Json json = Json::parse(tiles.json(change.places, change.clear));
  EXPECT_THAT(pixels_of(json["tiles"][0]["png"]), ::testing::Each(GridMap::kUnknown));
}

TEST(TilesOfAMap, BeginAnewWithOtherCells) {
  Tiles tiles;
  tiles.set(map_of(0.0, 0.0, 10, 10));
  EXPECT_TRUE(tiles.set(map_of(0.05, 0.0, 10, 10)).clear);
  GridMap finer = map_of(0.0, 0.0, 10, 10);
  finer.resolution_m = 0.05;
  EXPECT_TRUE(tiles.set(finer).clear);
  EXPECT_FALSE(tiles.set(finer).clear);
}

TEST(TilesAsJson, BeginWithTheSmallestY) {
  Tiles tiles;
  GridMap map = map_of(-25.6, 25.6, 256, 256, 100);
  map.occupancy[3] = 7;  // x cell 3 of the lowest row
  tiles.set(map);
  const Json json = Json::parse(tiles.json({{-1, 1}}, true));
  EXPECT_EQ(json["clear"], true);
  EXPECT_EQ(json["resolution_m"], 0.1);
  const Json& tile = json["tiles"][0];
  EXPECT_NEAR(tile["x_m"], -25.6, 1e-9);
  EXPECT_NEAR(tile["y_m"], 25.6, 1e-9);
  EXPECT_EQ(tile["width"], 256);
  const auto pixels = pixels_of(tile["png"]);
  ASSERT_EQ(pixels.size(), 256U * 256U);
  EXPECT_EQ(pixels[3], 7);
  EXPECT_EQ(pixels[4], 100);
  EXPECT_FALSE(Json::parse(tiles.json({}, false)).contains("clear"));
}

}  // namespace
}  // namespace marco::web
