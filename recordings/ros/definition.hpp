#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace marco::ros {

/// Type of one element of a field.
enum class Kind : uint8_t {
  boolean,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  string,
  wide_string,
  time,
  duration,
  nested
};

struct Field {
  enum class Many : uint8_t { one, fixed, sequence };
  std::string name;
  Kind kind = Kind::uint8;
  std::string type;  ///< of a nested field: "pkg/Name"
  Many many = Many::one;
  uint32_t size = 1;  ///< of a fixed array

  bool operator==(const Field&) const = default;
};

/// The fields of a message type and of all types within it, in the order of the wire.
struct Definition {
  std::string type;                                 ///< "sensor_msgs/LaserScan"
  std::map<std::string, std::vector<Field>> types;  ///< by "pkg/Name", `type` among them

  const std::vector<Field>& fields() const { return types.at(type); }
};

/// Parses the text that a recording carries. Constants, defaults, bounds and comments are passed
/// over. In `ros2msg` and `ros2idl` builtin_interfaces/Time and Duration are of the kinds `time`
/// and `duration`; types never nest themselves.
/// @param schema_encoding "ros1msg", "ros2msg" or "ros2idl"
/// @throws std::invalid_argument with type and line of what it cannot read.
Definition parse_definition(std::string_view schema_encoding,
                            const std::string& type,
                            std::string_view text);

/// The definition that Marco knows of a type, for files without one; its source is ROS' public
/// packages. @returns nullptr for types that are not used here
const Definition* known_definition(std::string_view encoding, std::string_view type);

}  // namespace marco::ros
