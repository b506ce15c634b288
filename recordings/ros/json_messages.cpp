#include "recordings/ros/json_messages.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

using Json = nlohmann::json;

// Foxglove's scans say no limits; JSON has no infinity, and null stands for no return.
constexpr float kFarthestM = 1000.0F;

Json parsed(const Message& message) {
  constexpr std::size_t kMostBytes = std::size_t{16} << 20;  // values take ten times the text
  if (message.bytes.size() > kMostBytes) throw WireError("more than 16 MB of JSON");
  return Json::parse(message.bytes.begin(), message.bytes.end());
}

template <class Read>
auto guarded(Read read) {
  try {
    return read();
  } catch (const Json::exception& fault) {
    throw WireError(fault.what());
  }
}

Header header_of(const Json& json, const char* frame_key) {
  constexpr int64_t kSecondNs = 1'000'000'000;
  const Json& stamp = json.at("timestamp");
  return {int64_t{stamp.at("sec").get<int32_t>()} * kSecondNs + stamp.at("nsec").get<int32_t>(),
          json.at(frame_key).get<std::string>()};
}

Pose3 pose_of(const Json& translation, const Json& rotation) {
  const auto at = [](const Json& json, const char* key) { return json.at(key).get<double>(); };
  Pose3 pose = Pose3::Identity();
  if (!make_pose({at(translation, "x"), at(translation, "y"), at(translation, "z")},
                 {at(rotation, "x"), at(rotation, "y"), at(rotation, "z"), at(rotation, "w")},
                 pose)) {
    throw WireError("invalid pose");
  }
  return pose;
}

TransformMessage transform_of(const Json& json) {
  return {header_of(json, "parent_frame_id"), json.at("child_frame_id").get<std::string>(),
          pose_of(json.at("translation"), json.at("rotation"))};
}

}  // namespace

LaserScanMessage json_scan(const Message& message) {
  return guarded([&] {
    const Json json = parsed(message);
    LaserScanMessage scan;
    scan.header = header_of(json, "frame_id");
    for (const Json& range : json.at("ranges")) {
      scan.ranges.push_back(range.is_number() ? range.get<float>() : INFINITY);
    }
    scan.angle_min = json.at("start_angle").get<float>();
    scan.angle_max = json.at("end_angle").get<float>();
    scan.range_max = kFarthestM;
    if (scan.ranges.size() > 1) {
      const float steps = static_cast<float>(scan.ranges.size() - 1);
      scan.angle_increment = (scan.angle_max - scan.angle_min) / steps;
    }
    return scan;
  });
}

std::vector<TransformMessage> json_transforms(const Message& message) {
  return guarded([&] {
    const Json json = parsed(message);
    std::vector<TransformMessage> transforms;
    if (!json.contains("transforms")) return std::vector{transform_of(json)};
    for (const Json& transform : json.at("transforms")) {
      transforms.push_back(transform_of(transform));
    }
    return transforms;
  });
}

PoseMessage json_pose(const Message& message) {
  return guarded([&] {
    const Json json = parsed(message);
    const Json& pose = json.at("pose");
    return PoseMessage{header_of(json, "frame_id"),
                       pose_of(pose.at("position"), pose.at("orientation"))};
  });
}

}  // namespace marco::ros
