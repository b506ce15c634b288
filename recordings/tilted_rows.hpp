#pragma once

#include <istream>

namespace marco::files {

/// Whether the points of a uos file (x right, y up, z ahead) lie in rows of a laser that is tilted,
/// by the first few thousand; a file of one row does.
bool lies_in_tilted_rows(std::istream& lines);

}  // namespace marco::files
