#include "recordings/ros/encode_messages.hpp"

#include <array>

#include "recordings/ros/wire_writer.hpp"

namespace marco::ros {
namespace {

void put(WireWriter& out, const Header& header) { out.header(header.stamp_ns, header.frame_id); }

void put(WireWriter& out, const Eigen::Vector3d& vector) {
  for (const double value : vector) out.number(value);
}

void put(WireWriter& out, const Pose3& pose) {
  put(out, Eigen::Vector3d(pose.translation()));
  const Eigen::Quaterniond turn(pose.linear());
  for (const double value : {turn.x(), turn.y(), turn.z(), turn.w()}) out.number(value);
}

template <std::size_t kValues>
void put_covariance(WireWriter& out, double first = 0.0) {
  std::array<double, kValues> values{};
  values.front() = first;
  out.numbers(std::span<const double>(values));
}

}  // namespace

Bytes encode(std::string_view encoding, const LaserScanMessage& scan) {
  WireWriter out(encoding);
  put(out, scan.header);
  for (const float value : {scan.angle_min, scan.angle_max, scan.angle_increment,
                            scan.time_increment, scan.scan_time, scan.range_min, scan.range_max}) {
    out.number(value);
  }
  out.sequence(scan.ranges);
  out.count(0);  // intensities
  return out.bytes();
}

Bytes encode(std::string_view encoding, const OdometryMessage& odometry) {
  WireWriter out(encoding);
  put(out, odometry.header);
  out.string(odometry.child_frame_id);
  put(out, odometry.pose);
  put_covariance<36>(out);
  put(out, odometry.linear);
  put(out, odometry.angular);
  put_covariance<36>(out);
  return out.bytes();
}

Bytes encode(std::string_view encoding, const std::vector<TransformMessage>& transforms) {
  WireWriter out(encoding);
  out.count(transforms.size());
  for (const TransformMessage& transform : transforms) {
    put(out, transform.header);
    out.string(transform.child_frame_id);
    put(out, transform.parent_from_child);
  }
  return out.bytes();
}

Bytes encode(std::string_view encoding, const ImuMessage& imu) {
  constexpr double kNotMeasured = -1.0;
  WireWriter out(encoding);
  put(out, imu.header);
  const std::array<double, 4> no_turn{0.0, 0.0, 0.0, 1.0};
  out.numbers(std::span<const double>(no_turn));
  put_covariance<9>(out, kNotMeasured);
  put(out, imu.angular_velocity);
  put_covariance<9>(out, imu.has_angular_velocity ? 0.0 : kNotMeasured);
  put(out, imu.linear_acceleration);
  put_covariance<9>(out, imu.has_acceleration ? 0.0 : kNotMeasured);
  return out.bytes();
}

Bytes encode(std::string_view encoding, const PoseMessage& pose) {
  WireWriter out(encoding);
  put(out, pose.header);
  put(out, pose.pose);
  return out.bytes();
}

Bytes encode(std::string_view encoding,
             const Header& header,
             const std::vector<PoseMessage>& path) {
  WireWriter out(encoding);
  put(out, header);
  out.count(path.size());
  for (const PoseMessage& pose : path) {
    put(out, pose.header);
    put(out, pose.pose);
  }
  return out.bytes();
}

Bytes encode(std::string_view encoding, const Header& header, const GridMap& map) {
  WireWriter out(encoding);
  put(out, header);
  out.time(header.stamp_ns);
  out.number(static_cast<float>(map.resolution_m));
  out.number(static_cast<uint32_t>(map.width_cells));
  out.number(static_cast<uint32_t>(map.height_cells));
  put(out, lift({map.origin_m.x(), map.origin_m.y(), 0.0}));
  // Unknown is 255 here, and -1 there: the same byte.
  static_assert(static_cast<int8_t>(GridMap::kUnknown) == -1);
  out.sequence(map.occupancy);
  return out.bytes();
}

Bytes encode(std::string_view encoding, const ImageMessage& image) {
  WireWriter out(encoding);
  put(out, image.header);
  if (image.step_bytes > 0) {
    out.number(image.height);
    out.number(image.width);
  }
  out.string(image.encoding);
  if (image.step_bytes > 0) {
    out.number(uint8_t{0});  // little-endian
    out.number(image.step_bytes);
  }
  out.sequence(image.data);
  return out.bytes();
}

}  // namespace marco::ros
