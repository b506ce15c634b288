#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "lcm_tools/log/log_info.hpp"
#include "lcm_tools/log/log_walk.hpp"
#include "recordings/foreign.hpp"
#include "tools/log/foxglove_grid.hpp"
#include "tools/log/robot_frames.hpp"

namespace marco::logs {

/// Says again, in Foxglove's words, what scans, grids, poses and pictures a log holds.
///
/// Laser scans (planar_lidar_t, lidar_raw_t on regular bearings) -> LaserScan in the sensor's own
/// frame once SENSOR_INFO told where that is, in "robot" before; 0 = no return. grid_map_t -> Grid,
/// the tiles of a map joined; mbot's occupancy_grid_t -> Grid. pose2_t, slam_pose_t, odometry_t,
/// mbot's pose2D_t, bot_core.pose_t -> PoseInFrame; trajectory_t -> PosesInFrame. Odometry, SLAM's
/// poses, SENSOR_INFO and PANTILT_STATE -> FrameTransform (see RobotFrames). image_t ->
/// CompressedImage (JPEG) or RawImage. Everything else has no such picture.
///
/// Foreign lasers whose bearings run clockwise (ForeignTable) are turned. Stamps of channels whose
/// clocks are more than half a second off the event times are put into the event times' clock.
class FoxgloveTranslator {
 public:
  /// @param log inspect_log of the log to be translated, without channels that are left out
  explicit FoxgloveTranslator(const LogInfo& log);

  /// Messages for an event, none when nothing fits or when the message contradicts itself; also
  /// those of events before that waited for this one.
  std::vector<FoxgloveMessage> translate(const DecodedEvent& event);
  /// Those that still wait at the log's end.
  std::vector<FoxgloveMessage> finish() { return grids_.finish(); }
  /// Maps too large to be drawn.
  int64_t grids_left_out() const { return grids_.left_out(); }

 private:
  std::vector<FoxgloveMessage> translate_message(const DecodedEvent& event);
  std::vector<FoxgloveMessage> translate_info(const DecodedEvent& event,
                                              const std::string& channel);
  std::vector<FoxgloveMessage> translate_scan(LaserScan scan, uint64_t fingerprint) const;
  std::vector<FoxgloveMessage> translate_grid(const DecodedEvent& event,
                                              const std::string& channel);
  std::vector<FoxgloveMessage> translate_path(const DecodedEvent& event,
                                              const std::string& channel) const;
  std::vector<FoxgloveMessage> translate_pose(const DecodedEvent& event,
                                              const std::string& channel);
  std::vector<FoxgloveMessage> translate_image(const DecodedEvent& event) const;

  FoxgloveMessage pose_message(const std::string& channel,
                               int64_t utime_us,
                               const std::string& frame,
                               const Pose3& pose) const;
  FoxgloveMessage transform_message(const std::string& channel,
                                    int64_t utime_us,
                                    const FrameTransform& transform) const;
  std::string frame_of(const std::string& channel, const std::string& otherwise) const;

  std::string stamp(std::string_view channel, int64_t utime_us) const;
  std::string in_frame(std::string_view channel, int64_t utime_us, const std::string& frame) const;
  bool is_clockwise(const std::string& channel, uint64_t fingerprint) const;

  std::map<std::string, int64_t, std::less<>> shifts_us_;  // utime + shift = event time
  std::map<std::string, SensorInfo, std::less<>> infos_;
  ForeignTable foreign_;
  GridJoiner grids_;
  RobotFrames frames_;
};

/// The JSON Schema of one of the schemas above.
std::string foxglove_schema(const std::string& name);

}  // namespace marco::logs
