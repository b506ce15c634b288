#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The screen as a value: layouts write cells, a painter brings them to the terminal, tests read
/// them as text. Pure.
namespace marco::spy {

enum class Style : uint8_t { normal, dim, bold, title, good, warn, bad, selected };

struct Cell {
  char32_t glyph = U' ';
  Style style = Style::normal;
};

class Canvas {
 public:
  /// Sizes are clamped to 1..1000.
  Canvas(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  const Cell& at(int x, int y) const { return cells_[index(x, y)]; }

  /// Outside the canvas nothing happens.
  void put(int x, int y, char32_t glyph, Style style = Style::normal);
  /// Writes UTF-8 from (x, y) to the right, at most `limit` cells, the last one "~" when cut.
  /// Control characters and broken UTF-8 become "?". @returns the cell behind.
  int text(int x, int y, std::string_view utf8, Style style = Style::normal, int limit = 1000);
  /// The same ending at cell `right` (exclusive).
  void text_right(int right, int y, std::string_view utf8, Style style = Style::normal);
  void style_row(int y, Style style);

  /// Lines without trailing blanks, UTF-8.
  std::string to_text() const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  int width_;
  int height_;
  std::vector<Cell> cells_;
};

/// Fine drawing with 2 x 4 dots a cell (Braille patterns).
class DotGrid {
 public:
  DotGrid(int cells_wide, int cells_high);
  int width() const { return 2 * cells_wide_; }
  int height() const { return 4 * cells_high_; }
  void dot(int x, int y);  ///< outside: nothing
  void line(double x0, double y0, double x1, double y1);
  /// Cells with dots go to the canvas with their upper left at (x, y); others are left alone.
  void draw(Canvas& canvas, int x, int y, Style style) const;

 private:
  int cells_wide_;
  int cells_high_;
  std::vector<uint8_t> dots_;
};

/// The last `width` values as bars of eighths between their minimum and maximum; NaN is a blank, a
/// constant a low bar.
std::u32string sparkline(std::span<const double> values, std::size_t width);

/// "1234", "12.3k", "4.56M": at most 5 characters for 0 .. 999e9.
std::string short_number(double value);
/// A value for a person: 6 significant digits, no trailing zeros.
std::string plain_number(double value);

std::string to_utf8(char32_t glyph);

}  // namespace marco::spy
