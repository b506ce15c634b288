#include "slam/map/map_edit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::slam {
namespace {

constexpr std::array<const char*, 4> kNames{"forbid_loop", "add_loop", "drop_scans",
                                            "distrust_odometry"};

// Whole seconds and microseconds apart: a double of seconds since 1970 has no microsecond to spare.
bool read_time(std::istream& words, Utime& utime) {
  std::string word;
  if (!(words >> word)) return false;
  const std::size_t dot = std::min(word.find('.'), word.size());
  const std::string whole = word.substr(0, dot);
  std::string part = dot < word.size() ? word.substr(dot + 1) : "";
  const auto digits = [](const std::string& text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  constexpr std::size_t kMicroDigits = 6, kMostDigits = 12;
  if (whole.empty() || whole.size() > kMostDigits || !digits(whole) || !digits(part)) return false;
  part.resize(kMicroDigits, '0');
  utime.us = std::stoll(whole) * 1'000'000 + std::stoll(part);
  return true;
}

MapEdit parse_line(const std::string& line, const std::string& place) {
  std::istringstream words(line);
  std::string name, left_over;
  words >> name;
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  require(found != kNames.end(), place + ": '" + name +
                                     "' is not one of forbid_loop, add_loop, drop_scans, "
                                     "distrust_odometry");
  MapEdit edit;
  edit.kind = static_cast<MapEdit::Kind>(found - kNames.begin());
  require(read_time(words, edit.from) && read_time(words, edit.to),
          place + ": expected two times in seconds after " + name);
  require(edit.from <= edit.to, place + ": the later time comes first");
  if (edit.kind == MapEdit::Kind::add_loop) {
    Pose2& pose = edit.from_from_to;
    require(static_cast<bool>(words >> pose.x_m >> pose.y_m >> pose.theta_rad) && is_finite(pose),
            place + ": expected x [m], y [m] and theta [rad] after the times of add_loop");
    pose.theta_rad = normalize_angle(pose.theta_rad);
  }
  words >> left_over;
  require(left_over.empty(), place + ": '" + left_over + "' is too much");
  return edit;
}

}  // namespace

std::string to_line(const MapEdit& edit) {
  const auto seconds = [](Utime utime) { return static_cast<long long>(utime.us / 1'000'000); };
  const auto micros = [](Utime utime) { return static_cast<long long>(utime.us % 1'000'000); };
  const std::string line =
      format("%s %lld.%06lld %lld.%06lld", kNames.at(static_cast<std::size_t>(edit.kind)),
             seconds(edit.from), micros(edit.from), seconds(edit.to), micros(edit.to));
  if (edit.kind != MapEdit::Kind::add_loop) return line;
  return line + format(" %.4f %.4f %.5f", edit.from_from_to.x_m, edit.from_from_to.y_m,
                       edit.from_from_to.theta_rad);
}

MapEdits parse_map_edits(std::string_view text) {
  MapEdits edits;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line.resize(std::min(line.find('#'), line.size()));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    edits.push_back(parse_line(line, "line " + std::to_string(number)));
  }
  return edits;
}

bool is_covered(const MapEdits& edits, MapEdit::Kind kind, Utime utime) {
  return std::any_of(edits.begin(), edits.end(), [&](const MapEdit& edit) {
    return edit.kind == kind && utime >= edit.from && utime <= edit.to;
  });
}

bool forbids(const MapEdits& edits, Utime from, Utime to) {
  const auto near = [](Utime a, Utime b) { return std::abs((a - b).seconds()) <= kSameLoopS; };
  return std::any_of(edits.begin(), edits.end(), [&](const MapEdit& edit) {
    return edit.kind == MapEdit::Kind::forbid_loop &&
           ((near(edit.from, from) && near(edit.to, to)) ||
            (near(edit.from, to) && near(edit.to, from)));
  });
}

}  // namespace marco::slam
