#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace marco::viewer {

/// Red, green, blue, 0..255 as a screen shows them (sRGB).
struct Rgb {
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;

  bool operator==(const Rgb&) const = default;
};

/// An image as a value: 8-bit RGB, row by row, top row first.
struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<Rgb> pixels;

  Picture() = default;
  Picture(int width, int height, Rgb fill)
      : width_px(width),
        height_px(height),
        pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}

  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_px && y < height_px; }
  Rgb& at(int x, int y) { return pixels[index(x, y)]; }
  const Rgb& at(int x, int y) const { return pixels[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) +
           static_cast<std::size_t>(x);
  }
};

static_assert(sizeof(Rgb) == 3, "rows of Rgb are handed to OpenCV and OpenGL as packed bytes");

/// The colours Marco's pictures share, so that a reader learns them once.
namespace palette {
inline constexpr Rgb kOdometry{38, 99, 214};
inline constexpr Rgb kEstimate{214, 39, 40};
inline constexpr Rgb kTruth{36, 150, 62};
inline constexpr Rgb kScanPoints{230, 120, 20};
inline constexpr Rgb kRobot{60, 60, 70};
inline constexpr Rgb kText{45, 48, 54};
inline constexpr Rgb kPaper{255, 255, 255};
inline constexpr Rgb kFree{255, 255, 255};
inline constexpr Rgb kUnknown{206, 210, 217};
inline constexpr Rgb kOccupied{20, 22, 26};

/// Distinct, of similar weight, for scenes of a model and the like; repeats after eight.
inline constexpr std::array<Rgb, 8> kSeries{{{78, 121, 167},
                                             {242, 142, 43},
                                             {89, 161, 79},
                                             {225, 87, 89},
                                             {118, 183, 178},
                                             {176, 122, 161},
                                             {237, 201, 72},
                                             {156, 117, 95}}};
}  // namespace palette

}  // namespace marco::viewer
