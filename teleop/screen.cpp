#include "teleop/screen.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "lcm_tools/base/format.hpp"

namespace marco::teleop {
namespace {

std::string pose_text(const char* whose, const Pose2& pose) {
  return format("%s %7.2f %7.2f m %6.1f deg", whose, pose.x_m, pose.y_m,
                rad_to_deg(pose.theta_rad));
}

std::vector<std::string> head_lines(const RobotView& view) {
  static constexpr const char* kLinks[] = {"LINK DOWN", "starting", "ready"};
  static constexpr const char* kFates[] = {"",        "moving", "done", "stopped short",
                                           "refused", "aborted"};
  std::vector<std::string> lines;
  std::string line = view.world_from_robot ? pose_text("pose", *view.world_from_robot)
                     : view.odometry       ? pose_text("odom", view.odometry->odom_from_robot)
                                           : "no pose yet";
  if (view.odometry) {
    line += format("   speed %5.2f m/s %6.1f deg/s", view.odometry->velocity_m_per_s,
                   rad_to_deg(view.odometry->yaw_rate_rad_per_s));
  }
  if (view.head) {
    line += format("   head %4.0f %4.0f deg", rad_to_deg(view.head->pan_rad),
                   rad_to_deg(view.head->tilt_rad));
  }
  lines.push_back(line);
  if (!view.base) {
    lines.emplace_back("no data from the base");
    return lines;
  }
  line = view.base->base + std::string(" ") + kLinks[static_cast<int>(view.base->link)] + " " +
         kFates[static_cast<int>(view.base->command)];
  line += "   battery";
  for (const double volts : view.base->battery_v) line += format(" %.1f", volts);
  line += " V";
  if (!view.base->bumpers.empty()) {
    line += "   bumpers ";
    for (const bool pressed : view.base->bumpers) line += pressed ? 'X' : '-';
  }
  line += format("   speed x%.2f", view.speed_factor);
  lines.push_back(line);
  const std::string keys =
      "arrows, ijkl step, tgfhr head, +- speed, space stop, e EMERGENCY, c clear, q end";
  const BaseNote note(view.base->note);
  if (!note.guard.empty()) lines.push_back(kGuardNote + note.guard);
  lines.push_back(!note.text.empty()              ? note.text
                  : !view.gamepad_trouble.empty() ? "gamepad: " + view.gamepad_trouble
                                                  : keys);
  return lines;
}

char arrow_of(double theta_rad) {
  static constexpr char kArrows[] = {'>', '/', '^', '\\', '<', '/', 'v', '\\'};
  const long eighth = std::lround(theta_rad / (std::numbers::pi / 4.0));
  return kArrows[((eighth % 8) + 8) % 8];
}

struct Bounds {
  static constexpr double kFar = std::numeric_limits<double>::infinity();
  double x0 = kFar, y0 = kFar, x1 = -kFar, y1 = -kFar;
  void add(double x, double y) {
    x0 = std::min(x0, x);
    y0 = std::min(y0, y);
    x1 = std::max(x1, x);
    y1 = std::max(y1, y);
  }
};

/// Calls `see` with the centre of each known cell and whether it is occupied.
template <class See>
void for_known_cells(const RobotView& view, const See& see) {
  for (const auto& [origin, tile] : view.map_tiles) {
    for (int y = 0; y < tile.height_cells; ++y) {
      for (int x = 0; x < tile.width_cells; ++x) {
        const uint8_t value = tile.at(x, y);
        if (value == GridMap::kUnknown) continue;
        see(tile.origin_m.x() + (x + 0.5) * tile.resolution_m,
            tile.origin_m.y() + (y + 0.5) * tile.resolution_m, value >= 60);
      }
    }
  }
}

std::vector<std::string> map_lines(const RobotView& view, int columns, int rows) {
  std::vector<std::string> lines(static_cast<std::size_t>(rows),
                                 std::string(static_cast<std::size_t>(columns), ' '));
  const Pose2 robot = view.world_from_robot ? *view.world_from_robot
                      : view.odometry       ? view.odometry->odom_from_robot
                                            : Pose2{};
  // Far single beams through a window must not shrink the room: what is occupied counts.
  Bounds bounds;
  bounds.add(robot.x_m - 2.0, robot.y_m - 2.0);
  bounds.add(robot.x_m + 2.0, robot.y_m + 2.0);
  for_known_cells(view, [&](double x, double y, bool occupied) {
    constexpr double kFarM = 15.0;
    if (occupied && std::hypot(x - robot.x_m, y - robot.y_m) < kFarM) bounds.add(x, y);
  });
  // A little more than fits, so that the last row and column hold the outermost walls.
  const double metres_a_column = 1.001 * std::max({(bounds.x1 - bounds.x0) / columns,
                                                   (bounds.y1 - bounds.y0) / (2.0 * rows), 0.02});
  const auto put = [&](double x, double y, char c) {
    const int column = static_cast<int>(std::floor((x - bounds.x0) / metres_a_column));
    const int row = static_cast<int>(std::floor((bounds.y1 - y) / (2.0 * metres_a_column)));
    if (column < 0 || column >= columns || row < 0 || row >= rows) return;
    char& place = lines[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    if (c != '.' || place == ' ') place = c;
  };
  for_known_cells(view,
                  [&](double x, double y, bool occupied) { put(x, y, occupied ? '#' : '.'); });
  put(robot.x_m, robot.y_m, arrow_of(robot.theta_rad));
  return lines;
}

// At blanks, into lines of at most `columns`; longer words are cut by the screen's edge.
void add_wrapped(const std::string& text, int columns, std::vector<std::string>& lines) {
  std::istringstream paragraphs(text);
  std::string paragraph;
  while (std::getline(paragraphs, paragraph)) {
    std::istringstream words(paragraph);
    std::string line, word;
    while (words >> word) {
      if (!line.empty() && static_cast<int>(line.size() + 1 + word.size()) > columns) {
        lines.push_back(std::exchange(line, {}));
      }
      line += (line.empty() ? "" : " ") + word;
    }
    lines.push_back(line);
  }
}

// Whether a picture of all tiles and this one would take more cells than any map of ours has.
bool too_large(const std::map<std::pair<double, double>, GridMap>& tiles, const GridMap& tile) {
  constexpr double kMostCells = 1e8;
  Bounds bounds;
  const auto add = [&bounds](const GridMap& one) {
    bounds.add(one.origin_m.x(), one.origin_m.y());
    bounds.add(one.origin_m.x() + one.resolution_m * one.width_cells,
               one.origin_m.y() + one.resolution_m * one.height_cells);
  };
  add(tile);
  for (const auto& [origin, one] : tiles) add(one);
  return (bounds.x1 - bounds.x0) * (bounds.y1 - bounds.y0) >
         kMostCells * tile.resolution_m * tile.resolution_m;
}

}  // namespace

void RobotView::add_tile(GridMap tile, int64_t revision) {
  // A map that grew has another origin, and all its tiles come; its revision may be the old one.
  if (!map_tiles.empty()) {
    const GridMap& old = map_tiles.begin()->second;
    const Eigen::Vector2d shift = (tile.origin_m - old.origin_m) / (256.0 * tile.resolution_m);
    const bool same_raster = tile.resolution_m == old.resolution_m &&
                             (shift - shift.array().round().matrix()).norm() < 1e-6;
    if (!same_raster) map_tiles.clear();
  }
  constexpr int kMostFarTiles = 2;
  if (too_large(map_tiles, tile)) {
    if (map_tiles.empty() || ++far_tiles <= kMostFarTiles) {
      throw std::invalid_argument("grid_map_t: a tile too far from the others");
    }
    map_tiles.clear();
  }
  far_tiles = 0;
  map_revision = revision;
  const std::pair<double, double> origin{tile.origin_m.x(), tile.origin_m.y()};
  map_tiles[origin] = std::move(tile);
}

std::string draw_screen(const RobotView& view, int columns, int rows) {
  std::vector<std::string> lines = head_lines(view);
  add_wrapped(view.notice, columns, lines);
  const int left = rows - static_cast<int>(lines.size());
  if (left > 0) {
    for (std::string& line : map_lines(view, columns, left)) lines.push_back(std::move(line));
  }
  std::string screen;
  for (int i = 0; i < rows && i < static_cast<int>(lines.size()); ++i) {
    if (i > 0) screen += '\n';
    screen += lines[static_cast<std::size_t>(i)].substr(0, static_cast<std::size_t>(columns));
  }
  return screen;
}

}  // namespace marco::teleop
