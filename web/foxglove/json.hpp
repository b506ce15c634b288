#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include "common/pose3.hpp"
#include "lcm_tools/schema/json.hpp"

/// Parts that Foxglove's messages have in common.
namespace marco::foxglove {

/// Infinity and NaN, which JSON lacks, become 0.
template <class Number>
std::string number(Number value) {
  if (!std::isfinite(value)) return "0";
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

inline std::string text_json(const std::string& text) {
  std::string json;
  lcm_schema::append_json_string(text, json);
  return json;
}

inline std::string vector_json(double x, double y, double z) {
  return R"({"x":)" + number(x) + R"(,"y":)" + number(y) + R"(,"z":)" + number(z) + "}";
}

inline std::string quaternion_json(const Eigen::Quaterniond& q) {
  return R"({"x":)" + number(q.x()) + R"(,"y":)" + number(q.y()) + R"(,"z":)" + number(q.z()) +
         R"(,"w":)" + number(q.w()) + "}";
}

inline std::string pose_json(const Pose3& pose) {
  const Eigen::Vector3d& at = pose.translation();
  return R"({"position":)" + vector_json(at.x(), at.y(), at.z()) + R"(,"orientation":)" +
         quaternion_json(Eigen::Quaterniond(pose.linear())) + "}";
}

}  // namespace marco::foxglove
