#include "recordings/ros/encode_messages.hpp"

#include "recordings/ros/wire_writer.hpp"

namespace marco::ros {
namespace {

void write_stamp(WireWriter& out, int64_t stamp_ns) {
  constexpr int64_t kSecondNs = 1'000'000'000;
  int64_t seconds = stamp_ns / kSecondNs, rest_ns = stamp_ns % kSecondNs;
  if (rest_ns < 0) {
    --seconds;
    rest_ns += kSecondNs;
  }
  out.number(static_cast<int32_t>(seconds));
  out.number(static_cast<uint32_t>(rest_ns));
}

// ROS 1 counts headers; it does so itself when it publishes one.
void write_header(WireWriter& out, const Header& header) {
  if (!out.is_cdr()) out.number(uint32_t{0});
  write_stamp(out, header.stamp_ns);
  out.string(header.frame_id);
}

void write_pose(WireWriter& out, const Pose3& pose) {
  for (int axis = 0; axis < 3; ++axis) out.number(pose.translation()(axis));
  const Eigen::Quaterniond turn(pose.linear());
  for (const double value : {turn.x(), turn.y(), turn.z(), turn.w()}) out.number(value);
}

}  // namespace

std::vector<uint8_t> encode_grid(std::string_view encoding,
                                 const Header& header,
                                 const GridMap& map) {
  WireWriter out(encoding);
  write_header(out, header);
  write_stamp(out, header.stamp_ns);  // map_load_time
  out.number(static_cast<float>(map.resolution_m));
  out.number(static_cast<uint32_t>(map.width_cells));
  out.number(static_cast<uint32_t>(map.height_cells));
  write_pose(out, lift({map.origin_m.x(), map.origin_m.y(), 0.0}));
  out.count(map.occupancy.size());
  for (const uint8_t percent : map.occupancy) {
    out.number(static_cast<int8_t>(percent == GridMap::kUnknown ? -1 : percent));
  }
  return out.take();
}

std::vector<uint8_t> encode_pose(std::string_view encoding, const PoseMessage& pose) {
  WireWriter out(encoding);
  write_header(out, pose.header);
  write_pose(out, pose.pose);
  return out.take();
}

std::vector<uint8_t> encode_path(std::string_view encoding,
                                 const Header& header,
                                 const Trajectory& path) {
  WireWriter out(encoding);
  write_header(out, header);
  out.count(path.size());
  for (const StampedPose2& pose : path) {
    write_header(out, {pose.utime.us * 1000, header.frame_id});
    write_pose(out, lift(pose.world_from_robot));
  }
  return out.take();
}

std::vector<uint8_t> encode_transforms(std::string_view encoding,
                                       const std::vector<TransformMessage>& transforms) {
  WireWriter out(encoding);
  out.count(transforms.size());
  for (const TransformMessage& transform : transforms) {
    write_header(out, transform.header);
    out.string(transform.child_frame_id);
    write_pose(out, transform.parent_from_child);
  }
  return out.take();
}

}  // namespace marco::ros
