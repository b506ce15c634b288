#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "lcmtypes/foreign.hpp"
#include "tools/log/log_info.hpp"
#include "tools/log/log_walk.hpp"

namespace marco::logs {

/// A message of one of the schemas that Foxglove draws.
struct FoxgloveMessage {
  std::string topic;   ///< "LIDAR/LaserScan"
  std::string schema;  ///< "foxglove.LaserScan"
  std::string json;
};

/// Says again, in Foxglove's words, what scans, grids, poses and pictures a log holds.
///
/// Laser scans (planar_lidar_t, lidar_raw_t on regular bearings) -> LaserScan in the frame "robot"
/// at the pose SENSOR_INFO told, 0 = no return; grid_map_t and mbot's occupancy_grid_t -> Grid,
/// tile by tile; pose2_t, slam_pose_t, odometry_t, mbot's pose2D_t, bot_core.pose_t -> PoseInFrame;
/// slam_pose_t also -> FrameTransform world from robot; image_t -> CompressedImage (JPEG) or
/// RawImage. Everything else has no such picture.
///
/// Foreign lasers whose bearings run clockwise (ForeignTable) are turned. Stamps of channels whose
/// clocks are more than half a second off the event times are put into the event times' clock.
class FoxgloveTranslator {
 public:
  /// @param clocks inspect_log of the log to be translated
  explicit FoxgloveTranslator(const LogInfo& clocks);

  /// Messages for an event, none when nothing fits or when the message contradicts itself.
  std::vector<FoxgloveMessage> translate(const DecodedEvent& event);

 private:
  std::vector<FoxgloveMessage> translate_scan(LaserScan scan, uint64_t fingerprint) const;
  std::vector<FoxgloveMessage> translate_grid(const DecodedEvent& event, const std::string& type);
  std::vector<FoxgloveMessage> translate_pose(const DecodedEvent& event,
                                              const std::string& type) const;
  std::vector<FoxgloveMessage> translate_image(const DecodedEvent& event) const;

  std::string stamp(std::string_view channel, int64_t utime_us) const;
  std::string in_frame(std::string_view channel, int64_t utime_us, const std::string& frame) const;
  bool is_clockwise(const std::string& channel, uint64_t fingerprint) const;

  std::map<std::string, int64_t, std::less<>> shifts_us_;  // utime + shift = event time
  std::map<std::string, SensorInfo, std::less<>> infos_;
  ForeignTable foreign_;
  std::map<std::string, std::pair<int64_t, int>, std::less<>> tiles_;  // revision, tiles of it
};

/// The JSON Schema of one of the schemas above.
std::string foxglove_schema(const std::string& name);

}  // namespace marco::logs
