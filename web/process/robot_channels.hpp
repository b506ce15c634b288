#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "lcmtypes/grid_joiner.hpp"
#include "teleop/map_frame.hpp"
#include "web/foxglove/scene.hpp"
#include "web/hub.hpp"
#include "web/tiles.hpp"

namespace marco::web {

/// What is drawn of the robot: Foxglove's well-known messages (/map /scan /pose /path /camera /tf
/// /walls /loops /model), and page/tiles and page/scan for our page. Frames: map -> odom -> base ->
/// laser. Messages are known by their types, and made only when somebody listens.
class RobotChannels {
 public:
  /// Both outlive it.
  RobotChannels(Hub& hub, process::DropCounter& drops);

  void take(const process::RawMessage& message);
  /// Call often: completes maps, and sends tiles a few at a time.
  void step(Utime now);
  /// As Hub::on_part; nothing for channels that are not these.
  uint64_t send_part(Hub::ClientId client, uint32_t channel, uint64_t from);

  const teleop::MapFrame& map_frame() const { return frame_; }
  std::optional<Pose2> map_from_base() const { return map_from_base_; }

 private:
  static constexpr const char* kMapFrame = "map";
  static int64_t ns_of(Utime utime) { return utime.us * 1000; }
  struct Laser {
    Utime heard;
    std::string channel;
  };
  struct Latest {
    int64_t utime_us = 0;
    std::string json;
  };
  struct Lasting {
    int64_t utime_us = 0;
    std::function<std::string()> json;
  };
  bool take_known(const process::RawMessage& message, uint64_t fingerprint);
  void take_scan(const LaserScan& scan, Utime heard);
  void take_pose(Utime utime, const Pose2& map_from_base);
  void take_odometry(const OdometrySample& sample);
  void take_maps(const std::vector<JoinedGrid>& maps);
  /// @param json  (utime, frame, value) -> Foxglove's message
  template <class Message, class Json>
  void take_lasting(uint32_t channel, const process::RawMessage& raw, Json json);
  void take_image(const process::RawMessage& message);
  void take_model(const process::RawMessage& message);
  void publish_points(const LaserScan& scan, const Pose3& base_from_laser);
  void publish_frames(Utime utime);
  std::optional<Pose2> map_from_odom() const;
  std::optional<Pose3> base_from_laser(const std::string& channel) const;
  /// In the map, or in the odometry's frame where there is no map.
  Pose2 drawn_pose(Utime at) const;
  std::string map_json() const;
  /// Published to who listens, and to who will: of each channel the newest. @param json  is made
  /// when it is sent
  void publish_lasting(uint32_t channel, Utime heard, Lasting message);

  Hub& hub_;
  process::DropCounter& drops_;
  uint32_t map_, scan_, pose_, path_, camera_, frames_, walls_, loops_, model_, tiles_, points_;
  std::map<std::string, SensorInfo> infos_;
  std::optional<PanTiltAngles> head_;
  std::optional<Laser> laser_;
  teleop::MapFrame frame_;
  std::optional<Pose2> map_from_base_;
  Utime posed_;
  GridJoiner grids_;
  std::optional<JoinedGrid> grid_;
  Tiles tiled_;
  std::deque<Tiles::Place> tiles_due_;
  std::map<uint32_t, Lasting> lasting_;  // by channel
  foxglove::SceneUpdates scenes_;
  int64_t model_revision_ = 0;
  std::map<uint32_t, Latest> model_tiles_;
  Utime points_sent_;
};

}  // namespace marco::web
