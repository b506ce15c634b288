// The maps of convert.hpp: trajectories, walls, grids.
#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/finite_pose.hpp"
#include "lcmtypes/stamp.hpp"

namespace marco {

static_assert(slam_pose_t::STATUS_MATCHED == static_cast<int>(PoseEstimate::Status::matched));
static_assert(slam_pose_t::STATUS_PREDICTED == static_cast<int>(PoseEstimate::Status::predicted));
static_assert(slam_pose_t::STATUS_LOST == static_cast<int>(PoseEstimate::Status::lost));

slam_pose_t to_message(const PoseEstimate& estimate) {
  slam_pose_t message;
  message.utime = estimate.utime.us;
  message.x_m = estimate.world_from_robot.x_m;
  message.y_m = estimate.world_from_robot.y_m;
  message.theta_rad = estimate.world_from_robot.theta_rad;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      message.covariance[row][column] = estimate.covariance(row, column);
    }
  }
  message.status = static_cast<int8_t>(estimate.status);
  message.overlap = estimate.overlap;
  return message;
}

PoseEstimate from_message(const slam_pose_t& message) {
  PoseEstimate estimate;
  estimate.utime = stamp_of(message.utime);
  estimate.world_from_robot = {message.x_m, message.y_m, normalize_angle(message.theta_rad)};
  require(is_finite(estimate.world_from_robot), "slam_pose_t: pose is not finite");
  require(
      message.status >= slam_pose_t::STATUS_MATCHED && message.status <= slam_pose_t::STATUS_LOST,
      "slam_pose_t: unknown status");
  estimate.status = static_cast<PoseEstimate::Status>(message.status);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      estimate.covariance(row, column) = message.covariance[row][column];
    }
  }
  estimate.overlap = message.overlap;
  return estimate;
}

trajectory_t to_message(const Trajectory& trajectory, Utime utime, int64_t revision) {
  trajectory_t message;
  message.utime = utime.us;
  message.revision = revision;
  message.num_poses = static_cast<int32_t>(trajectory.size());
  for (const StampedPose2& pose : trajectory) {
    message.utimes.push_back(pose.utime.us);
    message.x_m.push_back(pose.world_from_robot.x_m);
    message.y_m.push_back(pose.world_from_robot.y_m);
    message.theta_rad.push_back(pose.world_from_robot.theta_rad);
  }
  return message;
}

Trajectory from_message(const trajectory_t& message) {
  Trajectory trajectory;
  trajectory.reserve(message.utimes.size());
  for (std::size_t i = 0; i < message.utimes.size(); ++i) {
    trajectory.push_back({stamp_of(message.utimes[i]),
                          finite_pose(message.x_m[i], message.y_m[i], message.theta_rad[i],
                                      "trajectory_t: a pose is not finite or too far away")});
  }
  return trajectory;
}

loop_closures_t to_message(const LoopClosures& loops, Utime utime, int64_t revision) {
  loop_closures_t message;
  message.utime = utime.us;
  message.revision = revision;
  message.num_loops = static_cast<int32_t>(loops.size());
  for (const LoopClosure& loop : loops) {
    message.from_utimes.push_back(loop.from_utime.us);
    message.to_utimes.push_back(loop.to_utime.us);
    message.ends_m.push_back({loop.from_m.x(), loop.from_m.y(), loop.to_m.x(), loop.to_m.y()});
    message.residual_m.push_back(loop.residual_m);
    message.residual_rad.push_back(loop.residual_rad);
    message.overlap.push_back(loop.overlap);
  }
  return message;
}

LoopClosures from_message(const loop_closures_t& message) {
  require(message.num_loops >= 0, "loop_closures_t: num_loops below 0");
  LoopClosures loops(static_cast<std::size_t>(message.num_loops));
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const auto& ends_m = message.ends_m[i];
    LoopClosure& loop = loops[i];
    loop = {stamp_of(message.from_utimes[i]),
            stamp_of(message.to_utimes[i]),
            {ends_m[0], ends_m[1]},
            {ends_m[2], ends_m[3]},
            message.residual_m[i],
            message.residual_rad[i],
            message.overlap[i]};
    require(loop.from_m.allFinite() && loop.to_m.allFinite() && std::isfinite(loop.residual_m) &&
                std::isfinite(loop.residual_rad) && std::isfinite(loop.overlap),
            "loop_closures_t: a loop closure is not finite");
  }
  return loops;
}

line_map_t to_message(const Walls& walls, Utime utime, int64_t revision) {
  line_map_t message;
  message.utime = utime.us;
  message.revision = revision;
  message.num_walls = static_cast<int32_t>(walls.size());
  for (const Wall& wall : walls) {
    message.ids.push_back(wall.id);
    message.ends_m.push_back({wall.start_m.x(), wall.start_m.y(), wall.end_m.x(), wall.end_m.y()});
    std::vector<double>& covariance = message.covariances.emplace_back();
    for (Eigen::Index row = 0; row < 4; ++row) {
      for (Eigen::Index column = 0; column < 4; ++column) {
        covariance.push_back(wall.covariance(row, column));
      }
    }
    message.existence.push_back(wall.existence);
    message.times_seen.push_back(wall.times_seen);
    message.start_seen.push_back(wall.start_seen ? 1 : 0);
    message.end_seen.push_back(wall.end_seen ? 1 : 0);
  }
  return message;
}

Walls from_message(const line_map_t& message) {
  require(message.num_walls >= 0, "line_map_t: num_walls below 0");
  Walls walls(static_cast<std::size_t>(message.num_walls));
  for (std::size_t i = 0; i < walls.size(); ++i) {
    Wall& wall = walls[i];
    wall.id = message.ids[i];
    wall.start_m = {message.ends_m[i][0], message.ends_m[i][1]};
    wall.end_m = {message.ends_m[i][2], message.ends_m[i][3]};
    for (Eigen::Index k = 0; k < 16; ++k) {
      wall.covariance(k / 4, k % 4) = message.covariances[i][static_cast<std::size_t>(k)];
    }
    require(wall.start_m.allFinite() && wall.end_m.allFinite() && wall.covariance.allFinite(),
            "line_map_t: a wall is not finite");
    wall.existence = message.existence[i];
    wall.times_seen = message.times_seen[i];
    wall.start_seen = message.start_seen[i] != 0;
    wall.end_seen = message.end_seen[i] != 0;
  }
  return walls;
}

std::vector<grid_map_t> to_messages(const GridMap& map, Utime utime, int64_t revision) {
  constexpr int kTileCells = 256;
  std::vector<grid_map_t> tiles;
  for (int y0 = 0; y0 < map.height_cells; y0 += kTileCells) {
    for (int x0 = 0; x0 < map.width_cells; x0 += kTileCells) {
      grid_map_t tile;
      tile.utime = utime.us;
      tile.revision = revision;
      tile.origin_x_m = map.origin_m.x() + x0 * map.resolution_m;
      tile.origin_y_m = map.origin_m.y() + y0 * map.resolution_m;
      tile.resolution_m = map.resolution_m;
      tile.width_cells = std::min(kTileCells, map.width_cells - x0);
      tile.height_cells = std::min(kTileCells, map.height_cells - y0);
      tile.size = tile.width_cells * tile.height_cells;
      tile.occupancy.reserve(static_cast<std::size_t>(tile.size));
      for (int y = y0; y < y0 + tile.height_cells; ++y) {
        for (int x = x0; x < x0 + tile.width_cells; ++x) tile.occupancy.push_back(map.at(x, y));
      }
      tiles.push_back(std::move(tile));
    }
  }
  return tiles;
}

GridMap from_message(const grid_map_t& message) {
  require(message.width_cells >= 0 && message.height_cells >= 0 &&
              static_cast<int64_t>(message.width_cells) * message.height_cells == message.size,
          "grid_map_t: size is not width times height");
  constexpr double kFinestM = 1e-3, kCoarsestM = 100.0;
  require(message.resolution_m >= kFinestM && message.resolution_m <= kCoarsestM,
          "grid_map_t: resolution_m is not between 1 mm and 100 m");
  // NaN fails, too.
  constexpr double kFarthestM = 1e6;
  require(std::abs(message.origin_x_m) <= kFarthestM && std::abs(message.origin_y_m) <= kFarthestM,
          "grid_map_t: the origin is farther away than 1000 km");
  GridMap map;
  map.origin_m = {message.origin_x_m, message.origin_y_m};
  map.resolution_m = message.resolution_m;
  map.width_cells = message.width_cells;
  map.height_cells = message.height_cells;
  map.occupancy = message.occupancy;
  return map;
}

}  // namespace marco
