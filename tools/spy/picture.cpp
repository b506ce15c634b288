#include "tools/spy/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace marco::spy {
namespace {

using lcm_schema::Node;
using lcm_schema::NodeKind;
using lcm_schema::Tree;

// The field with this name; with `prefix`, the first whose name begins so.
const Node* field(const Tree& tree, std::string_view name, bool prefix = false) {
  if (tree.nodes.empty()) return nullptr;
  for (std::size_t i = 1; i < tree.nodes.size(); i = tree.nodes[i].after) {
    const std::string& own = tree.nodes[i].member->name;
    if (own == name || (prefix && own.starts_with(name))) return &tree.nodes[i];
  }
  return nullptr;
}

const Node* array(const Tree& tree, std::string_view name) {
  const Node* node = field(tree, name);
  return node != nullptr && node->kind == NodeKind::values ? node : nullptr;
}

double number(const Tree& tree, std::string_view name, double otherwise) {
  const Node* node = field(tree, name, true);
  return node != nullptr && node->kind == NodeKind::value ? tree.number(*node) : otherwise;
}

struct Points {
  std::vector<double> x_m;  // ahead
  std::vector<double> y_m;  // left
  std::size_t beams = 0;
};

Points scan_points(const Tree& tree) {
  Points points;
  const Node& ranges = *array(tree, "ranges");
  const Node* thetas = array(tree, "thetas");
  const double first_rad = number(tree, "rad0", 0);
  const double step_rad = number(tree, "radstep", 0);
  points.beams = ranges.count;
  for (std::size_t i = 0; i < ranges.count; ++i) {
    const double range_m = tree.number(ranges, i);
    const double bearing_rad = thetas != nullptr ? (i < thetas->count ? tree.number(*thetas, i) : 0)
                                                 : first_rad + static_cast<double>(i) * step_rad;
    if (!(range_m > 0) || !(range_m < 1e4) || !std::isfinite(bearing_rad)) continue;
    points.x_m.push_back(range_m * std::cos(bearing_rad));
    points.y_m.push_back(range_m * std::sin(bearing_rad));
  }
  return points;
}

// A round length that takes about a fifth of the picture.
double round_length(double whole) {
  const double power = std::pow(10, std::floor(std::log10(whole / 5)));
  const double part = whole / 5 / power;
  return power * (part < 2 ? 1 : part < 5 ? 2 : 5);
}

void draw_scale(Canvas& canvas, double dots_per_m) {
  const double length_m = round_length(2.0 * canvas.width() / dots_per_m);
  const int cells = static_cast<int>(std::lround(length_m * dots_per_m / 2));
  const int y = canvas.height() - 2;
  for (int x = 1; x <= cells; ++x) canvas.put(x, y, U'─', Style::dim);
  canvas.put(0, y, U'├', Style::dim);
  canvas.put(cells, y, U'┤', Style::dim);
  canvas.text(cells + 2, y, plain_number(length_m) + " m", Style::dim);
}

void draw_scan(Canvas& canvas, const Tree& tree, double zoom) {
  const Points points = scan_points(tree);
  const int rows = canvas.height() - 3;
  if (points.x_m.empty()) {
    canvas.text(2, 2, "no beam of " + std::to_string(points.beams) + " has a range", Style::warn);
    return;
  }
  // Nearly all points fit: a few far ones must not make the room a dot.
  std::vector<double> reach_m;
  for (std::size_t i = 0; i < points.x_m.size(); ++i) {
    reach_m.push_back(std::max(std::abs(points.x_m[i]), std::abs(points.y_m[i])));
  }
  const auto most = reach_m.begin() + static_cast<std::ptrdiff_t>((reach_m.size() - 1) * 97 / 100);
  std::nth_element(reach_m.begin(), most, reach_m.end());
  DotGrid dots(canvas.width(), rows);
  const double middle_x = dots.width() / 2.0;
  const double middle_y = dots.height() / 2.0;
  const double dots_per_m = zoom * 0.95 * std::min(middle_x, middle_y) / std::max(*most, 0.1);
  for (std::size_t i = 0; i < points.x_m.size(); ++i) {
    const double x = middle_x - points.y_m[i] * dots_per_m;
    const double y = middle_y - points.x_m[i] * dots_per_m;
    if (std::abs(x) < 1e6 && std::abs(y) < 1e6)
      dots.dot(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
  }
  dots.draw(canvas, 0, 1, Style::good);
  canvas.put(canvas.width() / 2, 1 + rows / 2, U'▲', Style::warn);
  draw_scale(canvas, dots_per_m);
  canvas.text_right(canvas.width(), canvas.height() - 2,
                    std::to_string(points.x_m.size()) + " of " + std::to_string(points.beams) +
                        " beams, ahead is up",
                    Style::dim);
}

// A grid's or image's size; 0 x 0 when its fields contradict each other.
struct Size {
  int64_t width = 0;
  int64_t height = 0;
};

Size size_of(const Tree& tree) {
  const double width = number(tree, "width", 0);
  const double height = number(tree, "height", 0);
  if (!(width >= 1 && width < 1e5 && height >= 1 && height < 1e5)) return {};
  return {static_cast<int64_t>(width), static_cast<int64_t>(height)};
}

enum class GridCell : uint8_t { unknown, free, occupied };

GridCell grid_cell(const Tree& tree, const Node& cells, std::size_t i, bool percent) {
  const int64_t value = tree.integer(cells, i);
  if (percent)
    return value > 100 ? GridCell::unknown : value >= 50 ? GridCell::occupied : GridCell::free;
  return value == 0 ? GridCell::unknown : value > 0 ? GridCell::occupied : GridCell::free;
}

// A tile with its place in the whole map, in cells.
struct Tile {
  const Tree* tree;
  const Node* cells;
  bool percent;
  Size size;
  double x_m;
  double y_m;
  int64_t x = 0;
  int64_t y = 0;
};

struct Map {
  std::vector<Tile> tiles;
  Size size;
  double resolution_m = 0;
};

Map map_of(std::span<const Tree> messages) {
  constexpr double kMaxCells = 1e6;  // along an edge
  Map map;
  map.resolution_m = number(messages[0], "resolution", number(messages[0], "meters_per_cell", 0));
  for (const Tree& tree : messages) {
    const Node* percent = array(tree, "occupancy");
    const Tile tile{&tree,
                    percent != nullptr ? percent : array(tree, "cells"),
                    percent != nullptr,
                    size_of(tree),
                    number(tree, "origin_x", 0),
                    number(tree, "origin_y", 0)};
    if (tile.cells == nullptr || tile.size.width == 0 ||
        static_cast<int64_t>(tile.cells->count) < tile.size.width * tile.size.height) {
      continue;
    }
    map.tiles.push_back(tile);
  }
  if (map.tiles.empty()) return map;
  double x_m = map.tiles[0].x_m;
  double y_m = map.tiles[0].y_m;
  for (const Tile& tile : map.tiles) {
    x_m = std::min(x_m, tile.x_m);
    y_m = std::min(y_m, tile.y_m);
  }
  for (Tile& tile : map.tiles) {
    const double x = (tile.x_m - x_m) / map.resolution_m;
    const double y = (tile.y_m - y_m) / map.resolution_m;
    if (x > 0 && x < kMaxCells) tile.x = std::lround(x);
    if (y > 0 && y < kMaxCells) tile.y = std::lround(y);
    map.size.width = std::max(map.size.width, tile.x + tile.size.width);
    map.size.height = std::max(map.size.height, tile.y + tile.size.height);
  }
  return map;
}

// How map cells fall on dots: dot d covers the cells first + d * step .. first + (d + 1) * step.
struct Axis {
  double first;
  double step;

  // The dots that a tile's cells [from, to) touch, among `count`.
  std::pair<int, int> dots(int64_t from, int64_t to, int count) const {
    const double low = (static_cast<double>(from) - first) / step - 1;
    const double high = (static_cast<double>(to) - first) / step + 1;
    return {static_cast<int>(std::clamp(low, 0.0, static_cast<double>(count))),
            static_cast<int>(std::clamp(high, 0.0, static_cast<double>(count)))};
  }
  // The cells of dot `d` inside [0, size) of a tile that begins at `from`.
  std::pair<int64_t, int64_t> cells(int d, int64_t from, int64_t size) const {
    const double low = std::floor(first + d * step);
    const double high = std::max(low + 1, std::floor(first + (d + 1) * step));
    return {std::clamp<int64_t>(static_cast<int64_t>(low) - from, 0, size),
            std::clamp<int64_t>(static_cast<int64_t>(high) - from, 0, size)};
  }
};

void draw_tile(
    Canvas& canvas, DotGrid& dots, const Tile& tile, const Axis& across, const Axis& up) {
  const auto [x0, x1] = across.dots(tile.x, tile.x + tile.size.width, dots.width());
  const auto [y0, y1] = up.dots(tile.y, tile.y + tile.size.height, dots.height());
  for (int y = y0; y < y1; ++y) {
    const auto [row0, row1] = up.cells(y, tile.y, tile.size.height);
    const int screen_y = dots.height() - 1 - y;
    for (int x = x0; x < x1; ++x) {
      const auto [column0, column1] = across.cells(x, tile.x, tile.size.width);
      GridCell found = GridCell::unknown;
      for (int64_t row = row0; row < row1; ++row) {
        for (int64_t column = column0; column < column1; ++column) {
          const auto cell = static_cast<std::size_t>(row * tile.size.width + column);
          found = std::max(found, grid_cell(*tile.tree, *tile.cells, cell, tile.percent));
        }
      }
      if (found == GridCell::occupied) dots.dot(x, screen_y);
      if (found == GridCell::free && x % 2 == 0 && screen_y % 4 == 1) {
        canvas.put(x / 2, 1 + screen_y / 4, U'·', Style::dim);
      }
    }
  }
}

void draw_grid(Canvas& canvas, std::span<const Tree> messages, double zoom) {
  const Map map = map_of(messages);
  if (map.tiles.empty()) {
    canvas.text(2, 2, "width and height do not fit the number of cells", Style::warn);
    return;
  }
  DotGrid dots(canvas.width(), canvas.height() - 3);
  const auto width = static_cast<double>(map.size.width);
  const auto height = static_cast<double>(map.size.height);
  const double step = std::max(width / dots.width(), height / dots.height()) / zoom;
  const Axis across{(width - step * dots.width()) / 2, step};
  const Axis up{(height - step * dots.height()) / 2, step};
  for (const Tile& tile : map.tiles) draw_tile(canvas, dots, tile, across, up);
  dots.draw(canvas, 0, 1, Style::bold);
  if (map.resolution_m > 0 && map.resolution_m < 1e3)
    draw_scale(canvas, 1 / (step * map.resolution_m));
  canvas.text_right(canvas.width(), canvas.height() - 2,
                    std::to_string(map.size.width) + " x " + std::to_string(map.size.height) +
                        " cells in " + std::to_string(map.tiles.size()) +
                        (map.tiles.size() == 1 ? " tile" : " tiles") + ", y is up",
                    Style::dim);
}

// Byte positions of a pixel's grey in camunits' formats; nothing for a format not known.
struct PixelLayout {
  int bytes = 0;
  std::array<int, 3> colours = {};
};

std::optional<PixelLayout> pixel_layout(int64_t format) {
  switch (format) {
    case 1497715271:
      return PixelLayout{1, {0, 0, 0}};  // GRAY
    case 859981650:                      // RGB
    case 861030210:
      return PixelLayout{3, {0, 1, 2}};  // BGR
    case 876758866:                      // RGBA
    case 877807426:
      return PixelLayout{4, {0, 1, 2}};  // BGRA
    case 1448695129:
      return PixelLayout{2, {0, 0, 0}};  // YUYV
    case 1498831189:
      return PixelLayout{2, {1, 1, 1}};  // UYVY
    case 808596553:                      // I420: the grey plane comes first
    case 842094158:
      return PixelLayout{1, {0, 0, 0}};  // NV12
    case 825770306:
    case 844650584:
    case 861427800:
    case 878205016:
      return PixelLayout{1, {0, 0, 0}};  // Bayer mosaics, as grey
    default:
      return {};
  }
}

std::optional<GrayImage> gray_image(const Tree& tree, const JpegDecoder& jpeg, std::string& why) {
  constexpr int64_t kMjpeg = 1196444237;
  const Node& data = *array(tree, "data");
  const auto format = static_cast<int64_t>(number(tree, "pixelformat", 0));
  if (format == kMjpeg) {
    auto image = jpeg ? jpeg(tree.message.subspan(data.offset, data.count)) : std::nullopt;
    if (!image) why = "its JPEG cannot be decoded";
    return image;
  }
  const auto layout = pixel_layout(format);
  const Size size = size_of(tree);
  const double row_bytes = number(tree, "row_stride", 0);
  const double last_row = row_bytes * static_cast<double>(size.height - 1) +
                          static_cast<double>(size.width * (layout ? layout->bytes : 0));
  if (!layout || size.width == 0 || !(row_bytes >= 0) || last_row > data.count) {
    why = !layout ? "pixelformat " + std::to_string(format) + " is not known"
                  : "its sizes do not fit its data";
    return {};
  }
  GrayImage image{static_cast<int>(size.width), static_cast<int>(size.height), {}};
  image.pixels.reserve(static_cast<std::size_t>(size.width * size.height));
  const uint8_t* bytes = tree.message.data() + data.offset;
  for (int64_t y = 0; y < size.height; ++y) {
    const uint8_t* pixel = bytes + y * static_cast<int64_t>(row_bytes);
    for (int64_t x = 0; x < size.width; ++x, pixel += layout->bytes) {
      image.pixels.push_back(static_cast<uint8_t>(
          (pixel[layout->colours[0]] + 2 * pixel[layout->colours[1]] + pixel[layout->colours[2]]) /
          4));
    }
  }
  return image;
}

void draw_image(Canvas& canvas, const Tree& tree, double zoom, const JpegDecoder& jpeg) {
  static constexpr int kBayer[4][4] = {
      {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
  std::string why;
  const auto image = gray_image(tree, jpeg, why);
  if (!image || image->width < 1 || image->height < 1) {
    canvas.text(2, 2, "the image cannot be drawn: " + why, Style::warn);
    return;
  }
  const int rows = canvas.height() - 3;
  DotGrid dots(canvas.width(), rows);
  const double pixels_per_dot = std::max(static_cast<double>(image->width) / dots.width(),
                                         static_cast<double>(image->height) / dots.height()) /
                                zoom;
  const auto [low, high] = std::minmax_element(image->pixels.begin(), image->pixels.end());
  const double spread = std::max(1, *high - *low);
  for (int y = 0; y < dots.height(); ++y) {
    for (int x = 0; x < dots.width(); ++x) {
      const auto column = static_cast<int64_t>(image->width / 2.0 +
                                               (x + 0.5 - dots.width() / 2.0) * pixels_per_dot);
      const auto row = static_cast<int64_t>(image->height / 2.0 +
                                            (y + 0.5 - dots.height() / 2.0) * pixels_per_dot);
      if (column < 0 || row < 0 || column >= image->width || row >= image->height) continue;
      const double grey =
          (image->pixels[static_cast<std::size_t>(row * image->width + column)] - *low) / spread;
      if (grey * 16 > kBayer[y % 4][x % 4] + 0.5) dots.dot(x, y);
    }
  }
  dots.draw(canvas, 0, 1, Style::normal);
  canvas.text_right(canvas.width(), canvas.height() - 2,
                    std::to_string(image->width) + " x " + std::to_string(image->height) + " px",
                    Style::dim);
}

}  // namespace

PictureKind picture_kind(const Tree& tree) {
  if (array(tree, "ranges") != nullptr &&
      (array(tree, "thetas") != nullptr || field(tree, "radstep") != nullptr)) {
    return PictureKind::scan;
  }
  const bool sized =
      field(tree, "width", true) != nullptr && field(tree, "height", true) != nullptr;
  if (sized && (array(tree, "occupancy") != nullptr || array(tree, "cells") != nullptr))
    return PictureKind::grid;
  if (sized && field(tree, "pixelformat") != nullptr && array(tree, "data") != nullptr)
    return PictureKind::image;
  return PictureKind::none;
}

void draw_picture(Canvas& canvas,
                  std::span<const Tree> messages,
                  double zoom,
                  const JpegDecoder& jpeg) {
  if (canvas.height() < 5 || messages.empty()) return;
  switch (picture_kind(messages[0])) {
    case PictureKind::scan:
      return draw_scan(canvas, messages[0], zoom);
    case PictureKind::grid:
      return draw_grid(canvas, messages, zoom);
    case PictureKind::image:
      return draw_image(canvas, messages[0], zoom, jpeg);
    case PictureKind::none:
      canvas.text(2, 2, "no scan, grid or image: nothing to draw", Style::warn);
  }
}

bool same_map_other_tile(const Tree& tile, const Tree& other) {
  const Node* revision = field(tile, "revision");
  const Node* other_revision = field(other, "revision");
  if (revision == nullptr || other_revision == nullptr || picture_kind(other) != PictureKind::grid)
    return false;
  const auto place = [](const Tree& tree) {
    return std::pair{number(tree, "origin_x", 0), number(tree, "origin_y", 0)};
  };
  return tile.integer(*revision) == other.integer(*other_revision) && place(tile) != place(other);
}

}  // namespace marco::spy
