#pragma once

#include <string>

#include "lcm_tools/base/utime.hpp"
#include "slam/line_slam/line_slam.hpp"

namespace marco::slam {

/// One scan of the filter as a line of JSON: x and P before and after, and per observed wall z, its
/// match, nu, S, K's rows of the robot and the distance. In place of the thesis' matrix dump.
std::string journal_line(Utime utime, const LineSlamJournal& journal);

}  // namespace marco::slam
