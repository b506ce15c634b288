#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "recordings/ros/wire_reader.hpp"
#include "recordings/ros/wire_writer.hpp"

namespace marco::ros {

/// A field of a known type.
struct KnownField {
  enum class Many : uint8_t { one, fixed, sequence };
  std::string name;
  std::string type;  ///< "float32", "time", "string", or "pkg/Name"
  Many many = Many::one;
  uint32_t size = 1;  ///< of a fixed array
};

/// A type of ROS' public packages (std_msgs, geometry_msgs, sensor_msgs, nav_msgs, tf2_msgs) that
/// is the same in ROS 1 and ROS 2 but for its header and the names of Time and Duration.
struct KnownType {
  std::string name;       ///< "pkg/Name"
  std::string constants;  ///< their lines
  std::vector<KnownField> fields;
  std::string md5;  ///< of ROS 1; "" of types that only occur within others
};

/// @returns nullptr for a type that is not known.
const KnownType* known_type(std::string_view name);

/// The definition that a recording carries, with those of all types within it, without comments.
/// @param encoding "ros1" or "cdr": of ROS 1 or ROS 2
std::string definition_text(const KnownType& type, std::string_view encoding);

/// Reads a message of a type in one encoding and writes it in the other. @throws WireError where
/// the bytes do not fit the type.
void transcode(const KnownType& type, WireReader& from, WireWriter& to);

}  // namespace marco::ros
