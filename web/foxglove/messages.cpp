#include "web/foxglove/messages.hpp"

#include <algorithm>

namespace marco::foxglove {
namespace {

struct Line {
  Eigen::Vector2d from_m, to_m;
};

// One entity, which replaces the one of this name before. @param head  as in_frame()
std::string lines_scene(const std::string& head,
                        const std::string& id,
                        const std::string& color,
                        const std::vector<Line>& lines) {
  constexpr int kLineList = 2;
  std::string points;
  for (const Line& line : lines) {
    points += (points.empty() ? "" : ",") + vector_json(line.from_m.x(), line.from_m.y(), 0.0) +
              "," + vector_json(line.to_m.x(), line.to_m.y(), 0.0);
  }
  return R"({"deletions":[],"entities":[)" + head + R"(,"id":)" + text_json(id) +
         R"(,"lifetime":{"sec":0,"nsec":0},"frame_locked":true,"metadata":[],)"
         R"("arrows":[],"cubes":[],"spheres":[],"cylinders":[],"lines":[{"type":)" +
         std::to_string(kLineList) + R"(,"pose":)" + pose_json(Pose3::Identity()) +
         R"(,"thickness":2,"scale_invariant":true,"points":[)" + points + R"(],"color":{)" + color +
         R"(,"a":1},"colors":[],"indices":[]}],"triangles":[],"texts":[],"models":[]}]})";
}

}  // namespace

std::string stamp_json(int64_t utime_us) {
  const int64_t us = std::max<int64_t>(0, utime_us);
  return R"("timestamp":{"sec":)" + std::to_string(us / 1000000) + R"(,"nsec":)" +
         std::to_string(us % 1000000 * 1000) + "}";
}

std::string in_frame(int64_t utime_us, const std::string& frame) {
  return "{" + stamp_json(utime_us) + R"(,"frame_id":)" + text_json(frame);
}

std::string pose_in_frame(int64_t utime_us, const std::string& frame, const Pose3& pose) {
  return in_frame(utime_us, frame) + R"(,"pose":)" + pose_json(pose) + "}";
}

std::string poses_in_frame(int64_t utime_us, const std::string& frame, const Trajectory& path) {
  std::string json = in_frame(utime_us, frame) + R"(,"poses":[)";
  for (const StampedPose2& pose : path) {
    if (&pose != &path.front()) json += ',';
    json += pose_json(lift(pose.world_from_robot));
  }
  return json + "]}";
}

std::string laser_scan(const LaserScan& regular, const std::string& frame) {
  const double last = static_cast<double>(regular.size()) - 1.0;
  std::string json =
      in_frame(regular.utime.us, frame) + R"(,"pose":)" + pose_json(Pose3::Identity()) +
      R"(,"start_angle":)" + number(regular.first_bearing_rad) + R"(,"end_angle":)" +
      number(regular.first_bearing_rad + last * regular.bearing_step_rad) + R"(,"ranges":[)";
  for (std::size_t beam = 0; beam < regular.size(); ++beam) {
    if (beam > 0) json += ',';
    json += number(regular.ranges_m[beam]);
  }
  return json + R"(],"intensities":[]})";
}

std::string frame_transform(int64_t utime_us, const Transform& transform) {
  const Eigen::Vector3d& at = transform.parent_from_child.translation();
  const Eigen::Quaterniond turn(transform.parent_from_child.linear());
  return "{" + stamp_json(utime_us) + R"(,"parent_frame_id":)" + text_json(transform.parent) +
         R"(,"child_frame_id":)" + text_json(transform.child) + R"(,"translation":)" +
         vector_json(at.x(), at.y(), at.z()) + R"(,"rotation":)" + quaternion_json(turn) + "}";
}

std::string frame_transforms(int64_t utime_us, const std::vector<Transform>& transforms) {
  std::string json = R"({"transforms":[)";
  for (const Transform& transform : transforms) {
    if (&transform != &transforms.front()) json += ',';
    json += frame_transform(utime_us, transform);
  }
  return json + "]}";
}

std::string walls_scene(int64_t utime_us, const std::string& frame, const Walls& walls) {
  std::vector<Line> lines;
  lines.reserve(walls.size());
  for (const Wall& wall : walls) lines.push_back({wall.start_m, wall.end_m});
  return lines_scene(in_frame(utime_us, frame), "walls", R"("r":0.85,"g":0.2,"b":0.2)", lines);
}

std::string loops_scene(int64_t utime_us, const std::string& frame, const LoopClosures& loops) {
  std::vector<Line> lines;
  lines.reserve(loops.size());
  for (const LoopClosure& loop : loops) lines.push_back({loop.from_m, loop.to_m});
  return lines_scene(in_frame(utime_us, frame), "loops", R"("r":0.2,"g":0.65,"b":0.3)", lines);
}

std::string compressed_image(int64_t utime_us,
                             const std::string& frame,
                             std::span<const uint8_t> jpeg) {
  return in_frame(utime_us, frame) + R"(,"data":")" + lcm_schema::to_base64(jpeg) +
         R"(","format":"jpeg"})";
}

std::string log_line(int64_t utime_us,
                     Level level,
                     const std::string& program,
                     const std::string& text) {
  return "{" + stamp_json(utime_us) + R"(,"level":)" + std::to_string(2 + static_cast<int>(level)) +
         R"(,"message":)" + text_json(text) + R"(,"name":)" + text_json(program) +
         R"(,"file":"","line":0})";
}

}  // namespace marco::foxglove
