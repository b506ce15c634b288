#pragma once

#include <string>
#include <vector>

#include "lcm_tools/base/format.hpp"

/// Text in columns of a terminal, in the locale's multi-byte characters.
namespace marco::procman {

/// Columns that `text` takes; a byte that is no character counts as one.
int width_of(const std::string& text);

/// The first `columns` columns of `text`, padded with spaces.
std::wstring fit(const std::string& text, int columns);

/// `text` cut into lines of at most `columns` columns; at least one line.
/// @param columns at least 2, the widest character.
std::vector<std::string> wrapped(const std::string& text, int columns);

/// Writes `text` in exactly `columns` columns of the screen; nothing when that is < 1.
void put(int row, int column, const std::string& text, int columns);

/// Draws a box with these lines in the middle of the screen. @param chosen  -1 = none.
void draw_box(const std::vector<std::string>& lines, int chosen);

}  // namespace marco::procman
