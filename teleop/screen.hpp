#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/grid_map.hpp"
#include "common/robot_values.hpp"
#include "common/samples.hpp"

namespace marco::teleop {

/// What the operator sees of the robot.
struct RobotView {
  std::optional<OdometrySample> odometry;
  std::optional<Pose2> world_from_robot;  ///< of SLAM
  std::optional<BaseStatus> base;
  std::optional<PanTiltState> head;
  std::map<std::pair<double, double>, GridMap> map_tiles;  ///< by origin
  int64_t map_revision = -1;
  int far_tiles = 0;  ///< in a row, that were refused
  double speed_factor = 1.0;
  std::string gamepad_trouble;  ///< why it is not obeyed
  std::string notice;           ///< why data are missing; "" = none are

  /// A tile of another raster than the others' begins a new map.
  /// @throws std::invalid_argument for one so far from the others that no map is so large; the
  /// third in a row begins a new map, since then it is the others that were stray.
  void add_tile(GridMap tile, int64_t revision);
};

/// The operator's screen of thesis A in characters: pose, map so far, battery, bumpers, speed.
/// @returns `rows` lines of at most `columns` characters, the last without LF. The map fits the
/// space left: '#' occupied, '.' free, the robot an arrow; characters are taken twice as high as
/// wide.
std::string draw_screen(const RobotView& view, int columns, int rows);

}  // namespace marco::teleop
