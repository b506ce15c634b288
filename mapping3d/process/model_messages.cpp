#include "mapping3d/process/model_messages.hpp"

#include <algorithm>
#include <unordered_map>

namespace marco::mapping3d {
namespace {

constexpr std::size_t kMaxMessageBytes = 280000;  // five datagrams of LCM

std::vector<float> to_vector(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::vector<scene_t> scene_messages(const Scene& scene) {
  std::vector<scene_t> messages;
  const std::size_t row_bytes = std::size_t{4} * scene.columns() + std::size_t{8} * 7;
  const std::size_t rows_each = std::max<std::size_t>(1, kMaxMessageBytes / row_bytes);
  for (std::size_t first = 0; first < scene.rows.size(); first += rows_each) {
    scene_t message;
    const std::size_t end = std::min(scene.rows.size(), first + rows_each);
    message.utime = scene.rows.front().utime.us;
    message.scene = scene.number;
    message.first_row = static_cast<int32_t>(first);
    message.total_rows = static_cast<int32_t>(scene.rows.size());
    message.rows = static_cast<int32_t>(end - first);
    message.columns = static_cast<int32_t>(scene.columns());
    message.bearing_first_rad = scene.rows[first].first_bearing_rad;
    message.bearing_step_rad = scene.rows[first].bearing_step_rad;
    for (std::size_t row = first; row < end; ++row) {
      const SceneRow& from = scene.rows[row];
      const Pose3 pose = lift(from.world_from_robot) * from.robot_from_sensor_first;
      const Eigen::Quaterniond turn(pose.linear());
      message.ranges_m.push_back(from.ranges_m);
      message.world_from_sensor_m.push_back(
          {pose.translation().x(), pose.translation().y(), pose.translation().z()});
      message.world_from_sensor_quat.push_back({turn.w(), turn.x(), turn.y(), turn.z()});
    }
    messages.push_back(std::move(message));
  }
  return messages;
}

void for_each_tile(const TriangleMesh& mesh,
                   Utime utime,
                   int64_t revision,
                   const std::function<void(const mesh_t&)>& take) {
  // A triangle brings at most three vertices of 24 bytes and 12 bytes of its own.
  constexpr std::size_t kTrianglesEach = kMaxMessageBytes / (3 * 24 + 12);
  const std::size_t tiles =
      std::max<std::size_t>(1, (mesh.triangles.size() + kTrianglesEach - 1) / kTrianglesEach);
  for (std::size_t number = 0; number < tiles; ++number) {
    mesh_t tile{};
    const std::size_t first = number * kTrianglesEach;
    tile.utime = utime.us;
    tile.revision = revision;
    tile.tile = static_cast<int32_t>(number);
    tile.tiles = static_cast<int32_t>(tiles);
    std::unordered_map<uint32_t, int32_t> vertex_of;
    const std::size_t end = std::min(mesh.triangles.size(), first + kTrianglesEach);
    for (std::size_t i = first; i < end; ++i) {
      std::vector<int32_t> triangle;
      for (const uint32_t corner : mesh.triangles[i]) {
        const auto [entry, is_new] =
            vertex_of.try_emplace(corner, static_cast<int32_t>(vertex_of.size()));
        if (is_new) {
          tile.vertices_m.push_back(to_vector(mesh.vertices_m[corner]));
          tile.normals.push_back(to_vector(mesh.normals[corner]));
        }
        triangle.push_back(entry->second);
      }
      tile.triangles.push_back(std::move(triangle));
    }
    tile.num_vertices = static_cast<int32_t>(tile.vertices_m.size());
    tile.num_triangles = static_cast<int32_t>(tile.triangles.size());
    take(tile);
  }
}

}  // namespace marco::mapping3d
