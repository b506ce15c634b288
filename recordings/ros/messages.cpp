#include "recordings/ros/messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "recordings/ros/json_messages.hpp"
#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

WireReader reader_of(const Message& message) {
  return WireReader::of(message.topic->encoding, message.bytes);
}

bool is_json(const Message& message) { return message.topic->encoding == "json"; }

// What a sender says of one thing: more of it is damage, and may take any memory.
constexpr std::size_t kLongestName = 1000;
constexpr uint32_t kMostNamed = 20'000;  // transforms or joints of a message
constexpr std::size_t kMostPoints = 4'000'000;

std::string frame(std::string name) {
  if (name.size() > kLongestName) throw WireError("a name of more than 1000 letters");
  if (!name.empty() && name.front() == '/') name.erase(0, 1);
  return name;
}

// ROS 1 counts headers before the stamp, and seconds without a sign.
Header read_header(WireReader& in) {
  Header header;
  if (!in.is_cdr()) in.number<uint32_t>();
  const int64_t seconds =
      in.is_cdr() ? int64_t{in.number<int32_t>()} : int64_t{in.number<uint32_t>()};
  header.stamp_ns = seconds * kSecondNs + int64_t{in.number<uint32_t>()};
  header.frame_id = frame(in.string());
  return header;
}

Eigen::Vector3d read_vector(WireReader& in) {
  const double x = in.number<double>(), y = in.number<double>(), z = in.number<double>();
  return {x, y, z};
}

Pose3 read_pose(WireReader& in) {
  const Eigen::Vector3d translation = read_vector(in);
  Eigen::Vector4d xyzw;
  for (double& value : xyzw) value = in.number<double>();
  Pose3 pose = Pose3::Identity();
  if (!make_pose(translation, xyzw, pose)) pose.translation().setConstant(std::nan(""));
  return pose;
}

void skip_covariance(WireReader& in, uint32_t values) { in.numbers<double>(values); }

std::vector<float> first_echoes(WireReader& in) {
  std::vector<float> ranges(in.count_of(4));
  for (float& range_m : ranges) {
    const auto echoes = in.sequence<float>();
    range_m = echoes.empty() ? std::nanf("") : echoes.front();
  }
  return ranges;
}

struct PointField {
  std::size_t offset = 0;
  uint8_t datatype = 0;
};

// sensor_msgs/PointField: 1..8 = i8 u8 i16 u16 i32 u32 f32 f64.
double value_of(const uint8_t* at, uint8_t datatype) {
  const auto read = [at]<class Number>(Number value) {
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
  };
  switch (datatype) {
    case 1:
      return read(int8_t{});
    case 2:
      return read(uint8_t{});
    case 3:
      return read(int16_t{});
    case 4:
      return read(uint16_t{});
    case 5:
      return read(int32_t{});
    case 6:
      return read(uint32_t{});
    case 7:
      return read(float{});
    default:
      return read(double{});
  }
}

std::size_t size_of(uint8_t datatype) {
  constexpr std::array<std::size_t, 9> kSizes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  return datatype < kSizes.size() ? kSizes[datatype] : 0;
}

struct CloudLayout {
  std::array<PointField, 3> xyz;
  PointField time;
  double seconds_per_unit = 1.0;
};

CloudLayout read_fields(WireReader& in) {
  CloudLayout layout;
  const uint32_t fields = in.count_of(13);
  for (uint32_t i = 0; i < fields; ++i) {
    const std::string name = in.string();
    PointField field;
    field.offset = in.number<uint32_t>();
    field.datatype = in.number<uint8_t>();
    in.number<uint32_t>();  // count
    if (name == "x") layout.xyz[0] = field;
    if (name == "y") layout.xyz[1] = field;
    if (name == "z") layout.xyz[2] = field;
    if (name == "t" || name == "time" || name == "timestamp") {
      layout.time = field;
      layout.seconds_per_unit = name == "t" ? 1e-9 : 1.0;
    }
  }
  return layout;
}

void read_points(std::span<const uint8_t> data,
                 std::size_t step,
                 const CloudLayout& layout,
                 CloudMessage& cloud) {
  std::size_t end = 0;
  for (const PointField& field : layout.xyz) {
    if (size_of(field.datatype) == 0) throw WireError("a cloud without x, y and z");
    end = std::max(end, field.offset + size_of(field.datatype));
  }
  const bool has_times = size_of(layout.time.datatype) > 0;
  if (has_times) end = std::max(end, layout.time.offset + size_of(layout.time.datatype));
  if (step == 0 || end > step) throw WireError("a cloud's fields exceed its points");
  if (data.size() / step > kMostPoints) throw WireError("a cloud of more than four million points");
  for (std::size_t at = 0; at + step <= data.size(); at += step) {
    const uint8_t* point = data.data() + at;
    Eigen::Vector3f xyz;
    for (int axis = 0; axis < 3; ++axis) {
      const PointField& field = layout.xyz[static_cast<std::size_t>(axis)];
      xyz(axis) = static_cast<float>(value_of(point + field.offset, field.datatype));
    }
    if (!xyz.allFinite()) continue;
    cloud.points.push_back(xyz);
    if (has_times) {
      const double units = value_of(point + layout.time.offset, layout.time.datatype);
      cloud.times_s.push_back(static_cast<float>(layout.seconds_per_unit * units));
    }
  }
}

}  // namespace

bool make_pose(const Eigen::Vector3d& translation, const Eigen::Vector4d& xyzw, Pose3& pose) {
  constexpr double kMostOff = 0.01;
  const bool is_unit = std::abs(xyzw.squaredNorm() - 1.0) <= kMostOff;
  if (!translation.allFinite() || !is_unit) return false;
  pose = Pose3::Identity();
  pose.translation() = translation;
  pose.linear() =
      Eigen::Quaterniond(xyzw(3), xyzw(0), xyzw(1), xyzw(2)).normalized().toRotationMatrix();
  return true;
}

LaserScanMessage decode_scan(const Message& message) {
  if (is_json(message)) return json_scan(message);
  WireReader in = reader_of(message);
  LaserScanMessage scan;
  scan.header = read_header(in);
  for (float* value : {&scan.angle_min, &scan.angle_max, &scan.angle_increment,
                       &scan.time_increment, &scan.scan_time, &scan.range_min, &scan.range_max}) {
    *value = in.number<float>();
  }
  const bool has_echoes = message.topic->type == "sensor_msgs/MultiEchoLaserScan";
  scan.ranges = has_echoes ? first_echoes(in) : in.sequence<float>();
  has_echoes ? first_echoes(in) : in.sequence<float>();  // intensities
  in.finish();
  return scan;
}

OdometryMessage decode_odometry(const Message& message) {
  WireReader in = reader_of(message);
  OdometryMessage odometry;
  odometry.header = read_header(in);
  odometry.child_frame_id = frame(in.string());
  odometry.pose = read_pose(in);
  skip_covariance(in, 36);
  odometry.linear = read_vector(in);
  odometry.angular = read_vector(in);
  skip_covariance(in, 36);
  in.finish();
  return odometry;
}

std::vector<TransformMessage> decode_transforms(const Message& message) {
  if (is_json(message)) return json_transforms(message);
  WireReader in = reader_of(message);
  const uint32_t count = in.count_of(64);
  if (count > kMostNamed) throw WireError("more than 20000 transforms at once");
  std::vector<TransformMessage> transforms(count);
  for (TransformMessage& transform : transforms) {
    transform.header = read_header(in);
    transform.child_frame_id = frame(in.string());
    transform.parent_from_child = read_pose(in);
  }
  in.finish();
  return transforms;
}

ImuMessage decode_imu(const Message& message) {
  WireReader in = reader_of(message);
  ImuMessage imu;
  imu.header = read_header(in);
  in.numbers<double>(4);  // orientation
  skip_covariance(in, 9);
  imu.angular_velocity = read_vector(in);
  imu.has_angular_velocity = in.numbers<double>(9).front() != -1.0;
  imu.linear_acceleration = read_vector(in);
  imu.has_acceleration = in.numbers<double>(9).front() != -1.0;
  in.finish();
  return imu;
}

PoseMessage decode_pose(const Message& message) {
  if (is_json(message)) return json_pose(message);
  if (use_of(*message.topic) == Use::odometry) {
    OdometryMessage odometry = decode_odometry(message);
    return {std::move(odometry.header), odometry.pose};
  }
  WireReader in = reader_of(message);
  PoseMessage pose;
  pose.header = read_header(in);
  if (use_of(*message.topic) == Use::transforms) throw WireError("not a pose");
  if (message.topic->type == "geometry_msgs/TransformStamped") pose.header.frame_id = in.string();
  pose.pose = read_pose(in);
  return pose;
}

CloudMessage decode_cloud(const Message& message) {
  WireReader in = reader_of(message);
  CloudMessage cloud;
  cloud.header = read_header(in);
  in.number<uint32_t>();  // height
  in.number<uint32_t>();  // width
  const CloudLayout layout = read_fields(in);
  if (in.boolean()) throw WireError("a cloud with big-endian points");
  const std::size_t step = in.number<uint32_t>();
  in.number<uint32_t>();  // bytes of a row
  read_points(in.blob(), step, layout, cloud);
  return cloud;
}

JointStateMessage decode_joints(const Message& message) {
  WireReader in = reader_of(message);
  JointStateMessage joints;
  joints.header = read_header(in);
  const uint32_t count = in.count_of(4);
  if (count > kMostNamed) throw WireError("more than 20000 joints");
  joints.names.resize(count);
  for (std::string& name : joints.names) name = in.string().substr(0, kLongestName);
  joints.positions_rad = in.sequence<double>();
  for (int rest = 0; rest < 2; ++rest) in.sequence<double>();  // velocity, effort
  in.finish();
  const std::size_t both = std::min(joints.names.size(), joints.positions_rad.size());
  joints.names.resize(both);
  joints.positions_rad.resize(both);
  return joints;
}

Use use_of(const Topic& topic) {
  constexpr std::array<std::pair<std::string_view, Use>, 15> kUses{
      {{"sensor_msgs/LaserScan", Use::scan},
       {"foxglove.LaserScan", Use::scan},
       {"sensor_msgs/MultiEchoLaserScan", Use::scan},
       {"sensor_msgs/PointCloud2", Use::cloud},
       {"nav_msgs/Odometry", Use::odometry},
       {"tf2_msgs/TFMessage", Use::transforms},
       {"tf/tfMessage", Use::transforms},
       {"foxglove.FrameTransform", Use::transforms},
       {"foxglove.FrameTransforms", Use::transforms},
       {"sensor_msgs/Imu", Use::imu},
       {"geometry_msgs/PoseStamped", Use::pose},
       {"geometry_msgs/PoseWithCovarianceStamped", Use::pose},
       {"geometry_msgs/TransformStamped", Use::pose},
       {"foxglove.PoseInFrame", Use::pose},
       {"sensor_msgs/JointState", Use::joints}}};
  const bool is_readable = topic.encoding == "ros1" || topic.encoding == "cdr" ||
                           (topic.encoding == "json" && topic.type.starts_with("foxglove."));
  const auto found = std::find_if(kUses.begin(), kUses.end(),
                                  [&](const auto& use) { return use.first == topic.type; });
  return is_readable && found != kUses.end() ? found->second : Use::none;
}

}  // namespace marco::ros
