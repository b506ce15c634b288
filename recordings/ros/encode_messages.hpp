#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/grid_map.hpp"
#include "recordings/ros/messages.hpp"

namespace marco::ros {

/// A picture, as sensor_msgs/Image, or as sensor_msgs/CompressedImage with no `step_bytes`.
struct ImageMessage {
  Header header;
  uint32_t width = 0, height = 0;
  std::string encoding;     ///< "mono8", "rgb8", ...; of a compressed one "jpeg"
  uint32_t step_bytes = 0;  ///< of a row
  std::vector<uint8_t> data;
};

/// Values as the bytes of ROS' messages, in ROS 1's packed form or in CDR; the counterparts of the
/// functions in messages.hpp. What a value does not tell is 0, covariances among it, or NaN.
/// @param encoding "ros1" or "cdr"
using Bytes = std::vector<uint8_t>;
Bytes encode(std::string_view encoding, const LaserScanMessage& scan);
Bytes encode(std::string_view encoding, const OdometryMessage& odometry);
Bytes encode(std::string_view encoding, const std::vector<TransformMessage>& transforms);
Bytes encode(std::string_view encoding, const ImuMessage& imu);
Bytes encode(std::string_view encoding, const PoseMessage& pose);
/// nav_msgs/Path.
Bytes encode(std::string_view encoding, const Header& header, const std::vector<PoseMessage>& path);
/// nav_msgs/OccupancyGrid.
Bytes encode(std::string_view encoding, const Header& header, const GridMap& map);
Bytes encode(std::string_view encoding, const ImageMessage& image);

}  // namespace marco::ros
