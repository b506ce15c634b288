#include <algorithm>
#include <array>

#include "lcm_tools/spy/jpeg.hpp"
#include "lcm_tools/spy/picture_fields.hpp"

namespace marco::spy {
namespace {

using lcm_schema::Node;
using lcm_schema::Tree;

// Byte positions of a pixel's grey in camunits' formats; nothing for a format not known.
struct PixelLayout {
  int bytes = 0;
  std::array<int, 3> colours = {};
};

std::optional<PixelLayout> pixel_layout(int64_t format) {
  switch (format) {
    case 859981650:  // RGB
    case 861030210:
      return PixelLayout{3, {0, 1, 2}};  // BGR
    case 876758866:                      // RGBA
    case 877807426:
      return PixelLayout{4, {0, 1, 2}};  // BGRA
    case 1448695129:
      return PixelLayout{2, {0, 0, 0}};  // YUYV
    case 1498831189:
      return PixelLayout{2, {1, 1, 1}};  // UYVY
    case 1497715271:                     // GRAY
    case 808596553:                      // I420: the grey plane comes first
    case 842094158:                      // NV12: here too
    case 825770306:                      // Bayer mosaics, as grey
    case 844650584:
    case 861427800:
    case 878205016:
      return PixelLayout{1, {0, 0, 0}};
    default:
      return {};
  }
}

std::optional<GrayImage> gray_image(const Tree& tree, std::string& why) {
  constexpr int64_t kMjpeg = 1196444237;
  const Node& data = *array(tree, "data");
  const auto format = static_cast<int64_t>(number(tree, "pixelformat", 0));
  if (format == kMjpeg) {
    auto image = decode_jpeg(tree.message.subspan(data.offset, data.count));
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

}  // namespace

void draw_image(Canvas& canvas, const Tree& tree, double zoom) {
  static constexpr int kBayer[4][4] = {
      {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
  std::string why;
  const auto image = gray_image(tree, why);
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

}  // namespace marco::spy
