#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/laser_scan.hpp"
#include "common/loop_closure.hpp"
#include "common/pose3.hpp"
#include "common/trajectory.hpp"
#include "common/wall.hpp"
#include "web/foxglove/json.hpp"
#include "web/foxglove/server.hpp"

/// Foxglove's well-known messages as JSON.
namespace marco::foxglove {

/// `"timestamp":{..}`; times before 1970 become 0.
std::string stamp_json(int64_t utime_us);
/// `{"timestamp":{..},"frame_id":".."`, without the end.
std::string in_frame(int64_t utime_us, const std::string& frame);

std::string pose_in_frame(int64_t utime_us, const std::string& frame, const Pose3& pose);
std::string poses_in_frame(int64_t utime_us, const std::string& frame, const Trajectory& path);
/// @param regular  a scan on regular bearings; what is no return is 0
std::string laser_scan(const LaserScan& regular, const std::string& frame);

struct Transform {
  std::string parent, child;
  Pose3 parent_from_child = Pose3::Identity();
};
std::string frame_transform(int64_t utime_us, const Transform& transform);
std::string frame_transforms(int64_t utime_us, const std::vector<Transform>& transforms);

/// Walls as lines of a SceneUpdate, which replaces the one before.
std::string walls_scene(int64_t utime_us, const std::string& frame, const Walls& walls);
/// The same of loop closures.
std::string loops_scene(int64_t utime_us, const std::string& frame, const LoopClosures& loops);
std::string compressed_image(int64_t utime_us,
                             const std::string& frame,
                             std::span<const uint8_t> jpeg);
std::string log_line(int64_t utime_us,
                     Level level,
                     const std::string& program,
                     const std::string& text);

}  // namespace marco::foxglove
