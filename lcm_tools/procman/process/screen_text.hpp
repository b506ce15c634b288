#pragma once

#include <string>
#include <vector>

#include "lcm_tools/base/format.hpp"

/// Texts as columns of a terminal, in the locale's multi-byte characters.
namespace marco::procman {

/// Columns that `text` takes; what is no character counts as one.
int width_of(const std::string& text);

/// The first `columns` columns of `text`, filled up with spaces.
std::wstring fit(const std::string& text, int columns);

/// `text` cut into lines of at most `columns` columns; at least one line.
/// @param columns at least 2, the widest character.
std::vector<std::string> wrapped(const std::string& text, int columns);

/// Writes `text` at a place of the screen, in exactly `columns` columns; nothing when that is < 1.
void put(int row, int column, const std::string& text, int columns);

}  // namespace marco::procman
