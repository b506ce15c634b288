#include "recordings/ros/known_types.hpp"

#include <array>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {
namespace {

struct Source {
  const char* name;
  const char* md5;
  const char* text;  // of ROS 1, as its checksum sees it: constants first, no comments
};

// From ROS' public packages.
constexpr std::array kSources = std::to_array<Source>({
    {"builtin_interfaces/Time", "", "int32 sec\nuint32 nanosec"},
    {"builtin_interfaces/Duration", "", "int32 sec\nuint32 nanosec"},
    {"std_msgs/Header", "", "uint32 seq\ntime stamp\nstring frame_id"},
    {"std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data"},
    {"rosgraph_msgs/Clock", "a9c97c1d230cfc112e270351a944ee47", "time clock"},
    {"geometry_msgs/Vector3", "", "float64 x\nfloat64 y\nfloat64 z"},
    {"geometry_msgs/Point", "", "float64 x\nfloat64 y\nfloat64 z"},
    {"geometry_msgs/Quaternion", "", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"},
    {"geometry_msgs/Pose", "",
     "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation"},
    {"geometry_msgs/PoseWithCovariance", "", "geometry_msgs/Pose pose\nfloat64[36] covariance"},
    {"geometry_msgs/PoseStamped", "d3812c3cbc69362b77dc0b19b345f8f5",
     "std_msgs/Header header\ngeometry_msgs/Pose pose"},
    {"geometry_msgs/PoseWithCovarianceStamped", "953b798c0f514ff060a53a3498ce6246",
     "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose"},
    {"geometry_msgs/Twist", "9f195f881246fdfa2798d1d3eebca84a",
     "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular"},
    {"geometry_msgs/TwistStamped", "98d34b0043a2093cf9d9345ab6eef12e",
     "std_msgs/Header header\ngeometry_msgs/Twist twist"},
    {"geometry_msgs/TwistWithCovariance", "", "geometry_msgs/Twist twist\nfloat64[36] covariance"},
    {"geometry_msgs/Transform", "",
     "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation"},
    {"geometry_msgs/TransformStamped", "b5764a33bfeb3588febc2682852579b0",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"},
    {"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec",
     "geometry_msgs/TransformStamped[] transforms"},
    {"tf/tfMessage", "94810edda583a504dfda3829e70d7eec",
     "geometry_msgs/TransformStamped[] transforms"},
    {"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist"},
    {"nav_msgs/Path", "6227e2b7e9cce15051f669a5e197bbf7",
     "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses"},
    {"nav_msgs/MapMetaData", "",
     "time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n"
     "geometry_msgs/Pose origin"},
    {"nav_msgs/OccupancyGrid", "3381f2d731d4076ec5c71b0759edbe4e",
     "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data"},
    {"sensor_msgs/LaserScan", "90c7ef2dc6895d81024acba2ac42f369",
     "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
     "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
     "float32[] ranges\nfloat32[] intensities"},
    {"sensor_msgs/LaserEcho", "", "float32[] echoes"},
    {"sensor_msgs/MultiEchoLaserScan", "6fefb0c6da89d7c8abe4b339f5c2f8fb",
     "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
     "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
     "sensor_msgs/LaserEcho[] ranges\nsensor_msgs/LaserEcho[] intensities"},
    {"sensor_msgs/PointField", "",
     "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\n"
     "uint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\n"
     "string name\nuint32 offset\nuint8 datatype\nuint32 count"},
    {"sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181",
     "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
     "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense"},
    {"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
     "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
     "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
     "float64[9] linear_acceleration_covariance"},
    {"sensor_msgs/JointState", "3066dcd76a6cfaef579bd0f34173e9fd",
     "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
     "float64[] effort"},
    {"sensor_msgs/CompressedImage", "8f7a12909da2c9d3332d540a0977563f",
     "std_msgs/Header header\nstring format\nuint8[] data"},
    {"sensor_msgs/Image", "060021388200f6f0f447d0fcd9c64743",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
     "uint32 step\nuint8[] data"},
    {"sensor_msgs/RegionOfInterest", "",
     "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify"},
    {"sensor_msgs/CameraInfo", "c9a58c1b0b154e0e6da7578cb991d214",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] D\n"
     "float64[9] K\nfloat64[9] R\nfloat64[12] P\nuint32 binning_x\nuint32 binning_y\n"
     "sensor_msgs/RegionOfInterest roi"},
});

KnownField field_of(const std::string& type, const std::string& name) {
  KnownField field{name, type};
  const std::size_t bracket = type.find('[');
  if (bracket == std::string::npos) return field;
  field.type = type.substr(0, bracket);
  const std::string size = type.substr(bracket + 1, type.size() - bracket - 2);
  field.many = size.empty() ? KnownField::Many::sequence : KnownField::Many::fixed;
  if (!size.empty()) field.size = static_cast<uint32_t>(std::stoul(size));
  return field;
}

KnownType parsed(const Source& source) {
  KnownType type{source.name, "", {}, source.md5};
  std::istringstream lines(source.text);
  for (std::string line; std::getline(lines, line);) {
    if (line.find('=') != std::string::npos) {
      type.constants += line + "\n";
      continue;
    }
    const std::size_t space = line.find(' ');
    type.fields.push_back(field_of(line.substr(0, space), line.substr(space + 1)));
  }
  return type;
}

const std::map<std::string, KnownType, std::less<>>& all_types() {
  static const auto kAll = [] {
    std::map<std::string, KnownType, std::less<>> types;
    for (const Source& source : kSources) types[source.name] = parsed(source);
    return types;
  }();
  return kAll;
}

bool is_nested(const std::string& type) { return type.find('/') != std::string::npos; }

std::string type_in_ros2(const std::string& type) {
  if (type == "time") return "builtin_interfaces/Time";
  if (type == "duration") return "builtin_interfaces/Duration";
  return type;
}

// ROS 2's CameraInfo has d, k, r and p, and no header counts.
std::string name_in_ros2(std::string name) {
  if (name.size() == 1 && name.front() >= 'A' && name.front() <= 'Z') name.front() += 'a' - 'A';
  return name;
}

void append_lines(const KnownType& type, bool is_ros2, std::string& text) {
  text += type.constants;
  for (const KnownField& field : type.fields) {
    if (is_ros2 && type.name == "std_msgs/Header" && field.name == "seq") continue;
    text += is_ros2 ? type_in_ros2(field.type) : field.type;
    if (field.many == KnownField::Many::sequence) text += "[]";
    if (field.many == KnownField::Many::fixed) text += "[" + std::to_string(field.size) + "]";
    text += " " + (is_ros2 ? name_in_ros2(field.name) : field.name) + "\n";
  }
}

void append_nested(const KnownType& type,
                   bool is_ros2,
                   std::set<std::string>& done,
                   std::string& text) {
  for (const KnownField& field : type.fields) {
    const std::string name = is_ros2 ? type_in_ros2(field.type) : field.type;
    if (!is_nested(name) || !done.insert(name).second) continue;
    const KnownType& nested = *known_type(name);
    text += std::string(80, '=') + "\nMSG: " + name + "\n";
    append_lines(nested, is_ros2, text);
    append_nested(nested, is_ros2, done, text);
  }
}

template <class Number>
void copy(uint32_t count, WireReader& from, WireWriter& to) {
  to.numbers(std::span<const Number>(from.numbers<Number>(count)));
}

void copy_numbers(std::size_t bytes, uint32_t count, WireReader& from, WireWriter& to) {
  switch (bytes) {
    case 1:
      return copy<uint8_t>(count, from, to);
    case 2:
      return copy<uint16_t>(count, from, to);
    case 4:
      return copy<uint32_t>(count, from, to);
    default:
      return copy<uint64_t>(count, from, to);
  }
}

std::size_t bytes_of(const std::string& type) {
  if (type == "bool" || type == "int8" || type == "uint8") return 1;
  if (type == "int16" || type == "uint16") return 2;
  if (type == "int32" || type == "uint32" || type == "float32") return 4;
  return 8;  // int64, uint64, float64
}

void copy_elements(const KnownField& field, uint32_t count, WireReader& from, WireWriter& to) {
  if (is_nested(field.type)) {
    const KnownType& nested = *known_type(field.type);
    for (uint32_t i = 0; i < count; ++i) transcode(nested, from, to);
  } else if (field.type == "string") {
    for (uint32_t i = 0; i < count; ++i) to.string(from.string());
  } else if (field.type == "time" || field.type == "duration") {
    copy_numbers(4, 2 * count, from, to);
  } else {
    copy_numbers(bytes_of(field.type), count, from, to);
  }
}

}  // namespace

const KnownType* known_type(std::string_view name) {
  const auto found = all_types().find(name);
  return found == all_types().end() ? nullptr : &found->second;
}

std::string definition_text(const KnownType& type, std::string_view encoding) {
  std::string text;
  std::set<std::string> done;
  append_lines(type, encoding == "cdr", text);
  append_nested(type, encoding == "cdr", done, text);
  return text;
}

void transcode(const KnownType& type, WireReader& from, WireWriter& to) {
  for (const KnownField& field : type.fields) {
    // ROS 1 counts its headers.
    if (type.name == "std_msgs/Header" && field.name == "seq") {
      const uint32_t seq = from.is_cdr() ? 0 : from.number<uint32_t>();
      if (!to.is_cdr()) to.number(seq);
      continue;
    }
    uint32_t count = field.size;
    if (field.many == KnownField::Many::sequence) {
      count =
          from.count_of(is_nested(field.type) || field.type == "string" ? 1 : bytes_of(field.type));
      to.count(count);
    }
    copy_elements(field, count, from, to);
  }
}

}  // namespace marco::ros
