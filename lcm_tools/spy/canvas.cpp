#include "lcm_tools/spy/canvas.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/format.hpp"
#include "lcm_tools/base/printable.hpp"

namespace marco::spy {
namespace {

// Beyond Latin and the drawing characters a cell's width is not known.
bool is_drawable(char32_t value) {
  return (value >= 0x20 && value < 0x7F) || (value >= 0xA0 && value < 0x300) ||
         (value >= 0x370 && value < 0x483) || (value >= 0x2010 && value < 0x2900);
}

// Takes one character from the front; '?' for what has no cell.
char32_t take_glyph(std::string_view& text) {
  const char32_t code = take_character(text);
  return is_drawable(code) ? code : U'?';
}

}  // namespace

Canvas::Canvas(int width, int height)
    : width_(std::clamp(width, 1, 1000)),
      height_(std::clamp(height, 1, 1000)),
      cells_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

void Canvas::put(int x, int y, char32_t glyph, Style style) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  cells_[index(x, y)] = {glyph, style};
}

int Canvas::text(int x, int y, std::string_view utf8, Style style, int limit) {
  for (int used = 0; !utf8.empty() && used < limit && x < width_; ++used, ++x) {
    const char32_t glyph = take_glyph(utf8);
    const bool cut = !utf8.empty() && (used + 1 == limit || x + 1 == width_);
    put(x, y, cut ? U'~' : glyph, style);
  }
  return x;
}

void Canvas::text_right(int right, int y, std::string_view utf8, Style style) {
  std::string_view rest = utf8;
  int length = 0;
  for (; !rest.empty(); ++length) take_glyph(rest);
  text(right - length, y, utf8, style);
}

void Canvas::style_row(int y, Style style) {
  if (y < 0 || y >= height_) return;
  for (int x = 0; x < width_; ++x) cells_[index(x, y)].style = style;
}

std::string to_utf8(char32_t c) {
  const auto byte = [](char32_t value) {
    return static_cast<char>(static_cast<unsigned char>(value));
  };
  if (c < 0x80) return {byte(c)};
  if (c < 0x800) return {byte(0xC0U | c >> 6U), byte(0x80U | (c & 0x3FU))};
  return {byte(0xE0U | c >> 12U), byte(0x80U | (c >> 6U & 0x3FU)), byte(0x80U | (c & 0x3FU))};
}

std::string Canvas::to_text() const {
  std::string result;
  for (int y = 0; y < height_; ++y) {
    int end = width_;
    while (end > 0 && at(end - 1, y).glyph == U' ') --end;
    for (int x = 0; x < end; ++x) result += to_utf8(at(x, y).glyph);
    result += '\n';
  }
  return result;
}

DotGrid::DotGrid(int cells_wide, int cells_high)
    : cells_wide_(std::clamp(cells_wide, 1, 1000)),
      cells_high_(std::clamp(cells_high, 1, 1000)),
      dots_(static_cast<std::size_t>(cells_wide_) * static_cast<std::size_t>(cells_high_)) {}

void DotGrid::dot(int x, int y) {
  static constexpr uint8_t kBits[4][2] = {{0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}};
  if (x < 0 || y < 0 || x >= width() || y >= height()) return;
  uint8_t& cell = dots_[static_cast<std::size_t>(y / 4) * static_cast<std::size_t>(cells_wide_) +
                        static_cast<std::size_t>(x / 2)];
  cell = static_cast<uint8_t>(cell | kBits[y % 4][x % 2]);
}

void DotGrid::line(double x0, double y0, double x1, double y1) {
  const double length = std::max(std::abs(x1 - x0), std::abs(y1 - y0));
  if (!(length < 1e5)) return;
  const int steps = static_cast<int>(length) + 1;
  for (int i = 0; i <= steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    dot(static_cast<int>(std::lround(x0 + part * (x1 - x0))),
        static_cast<int>(std::lround(y0 + part * (y1 - y0))));
  }
}

void DotGrid::draw(Canvas& canvas, int x, int y, Style style) const {
  for (int row = 0; row < cells_high_; ++row) {
    for (int column = 0; column < cells_wide_; ++column) {
      const uint8_t dots =
          dots_[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_wide_) +
                static_cast<std::size_t>(column)];
      if (dots != 0) canvas.put(x + column, y + row, static_cast<char32_t>(0x2800U + dots), style);
    }
  }
}

std::u32string sparkline(std::span<const double> values, std::size_t width) {
  values = values.last(std::min(width, values.size()));
  double low = INFINITY;
  double high = -INFINITY;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  std::u32string result;
  for (const double value : values) {
    if (!std::isfinite(value)) {
      result += U' ';
      continue;
    }
    // Halves first: the difference of two huge values may overflow.
    const double part = high > low ? (value / 2 - low / 2) / (high / 2 - low / 2) : 0;
    result += static_cast<char32_t>(U'\u2581' + static_cast<char32_t>(std::min(7.0, part * 8)));
  }
  return result;
}

std::string short_number(double value) {
  static constexpr const char* kUnits[] = {"", "k", "M", "G"};
  std::size_t unit = 0;
  if (!std::isfinite(value)) return "-";
  while (std::abs(value) >= 999.5 * (unit == 0 ? 10 : 1) && unit < 3) {
    value /= 1000;
    ++unit;
  }
  const int digits = unit == 0 && value == std::floor(value) ? 0
                     : std::abs(value) < 9.995               ? 2
                     : std::abs(value) < 99.95               ? 1
                                                             : 0;
  return format("%.*f%s", digits, value, kUnits[unit]);
}

std::string plain_number(double value) { return format("%.6g", value); }

}  // namespace marco::spy
