#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "lcm_tools/log/mcap_translator.hpp"
#include "lcmtypes/grid_joiner.hpp"
#include "recordings/foreign.hpp"
#include "tools/log/robot_frames.hpp"
#include "web/foxglove/scene.hpp"
#include "web/foxglove/schemas.hpp"

namespace marco::logs {

/// Translates scans, grids, poses and pictures of a log into the messages that Foxglove draws.
///
/// Laser scans (planar_lidar_t, lidar_raw_t on regular bearings) -> LaserScan in the sensor's own
/// frame once SENSOR_INFO gave its pose, in "robot" before; 0 = no return. grid_map_t -> Grid, the
/// tiles of a map joined; mbot's occupancy_grid_t -> Grid. pose2_t, slam_pose_t, odometry_t, mbot's
/// pose2D_t, bot_core.pose_t -> PoseInFrame; trajectory_t -> PosesInFrame. Odometry, SLAM's poses,
/// SENSOR_INFO and PANTILT_STATE -> FrameTransform (see RobotFrames). image_t -> CompressedImage
/// (JPEG) or RawImage; mesh_t -> SceneUpdate. Other messages have no counterpart.
///
/// Foreign lasers whose bearings run clockwise (ForeignTable) are turned. Stamps of channels whose
/// clocks are more than half a second off the event times are put into the event times' clock.
class FoxgloveTranslator : public McapTranslator {
 public:
  /// @param log inspect_log of the log to be translated, without channels that are left out
  explicit FoxgloveTranslator(const LogInfo& log);

  /// Nothing for a message that Foxglove cannot draw or that contradicts itself.
  std::vector<AddedMessage> translate(const DecodedEvent& event) override;
  std::vector<AddedMessage> finish() override { return grid_messages(grids_.finish()); }
  std::string json_schema(const std::string& name) const override {
    return foxglove::schema_of(name);
  }
  /// Counts the maps that are too large to be drawn.
  std::string remark() const override;

 private:
  std::vector<AddedMessage> grid_messages(const std::vector<JoinedGrid>& grids) const;
  std::vector<AddedMessage> translate_message(const DecodedEvent& event);
  std::vector<AddedMessage> translate_info(const DecodedEvent& event, const std::string& channel);
  std::vector<AddedMessage> translate_scan(LaserScan scan, uint64_t fingerprint) const;
  std::vector<AddedMessage> translate_grid(const DecodedEvent& event, const std::string& channel);
  std::vector<AddedMessage> translate_path(const DecodedEvent& event,
                                           const std::string& channel) const;
  std::vector<AddedMessage> translate_pose(const DecodedEvent& event, const std::string& channel);
  std::vector<AddedMessage> translate_image(const DecodedEvent& event) const;
  std::vector<AddedMessage> translate_scene(const DecodedEvent& event, const std::string& channel);

  AddedMessage pose_message(const std::string& channel,
                            int64_t utime_us,
                            const std::string& frame,
                            const Pose3& pose) const;
  AddedMessage transform_message(const std::string& channel,
                                 int64_t utime_us,
                                 const foxglove::Transform& transform) const;
  std::string frame_of(const std::string& channel, const std::string& otherwise) const;

  int64_t shifted_us(std::string_view channel, int64_t utime_us) const;
  std::string in_frame(std::string_view channel, int64_t utime_us, const std::string& frame) const;
  const ForeignChannel* foreign_laser(const std::string& channel, uint64_t fingerprint) const;

  std::map<std::string, int64_t, std::less<>> shifts_us_;  // utime + shift = event time
  std::map<std::string, SensorInfo, std::less<>> infos_;
  ForeignTable foreign_;
  GridJoiner grids_;
  foxglove::SceneUpdates scenes_;
  RobotFrames frames_;
};

}  // namespace marco::logs
