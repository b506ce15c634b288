#include "mapping3d/mapper3d.hpp"

#include <algorithm>

namespace marco::mapping3d {

Mapper3d::Mapper3d(const Mapper3dOptions& options) : options_(options), builder_(options.builder) {
  validate(options, "mapping3d");
}

bool Mapper3d::keep(std::optional<Scene> scene) {
  if (!scene) return false;
  scenes_.push_back(std::move(*scene));
  placed_.emplace_back();
  return true;
}

bool Mapper3d::add(const SceneRow& row, double pan_rad, double tilt_rad) {
  return keep(builder_.add(row, pan_rad, tilt_rad));
}

bool Mapper3d::finish() { return keep(builder_.finish()); }

void Mapper3d::follow(const Trajectory& keys, const std::map<Utime, Pose2>& first_published) {
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    const Utime scene_utime = scenes_[i].rows.front().utime;
    const StampedPose2* before = nullptr;
    for (const StampedPose2& key : keys) {
      if (key.utime <= scene_utime && (before == nullptr || key.utime > before->utime))
        before = &key;
    }
    if (before == nullptr) continue;
    const auto published = first_published.find(before->utime);
    if (published == first_published.end()) continue;
    placed_[i].correction = before->world_from_robot * published->second.inverse();
  }
}

TriangleMesh Mapper3d::model() const {
  TriangleMesh model;
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    Scene scene = scenes_[i];
    for (SceneRow& row : scene.rows) {
      row.world_from_robot = placed_[i].correction * row.world_from_robot;
    }
    append_mesh(model, mesh_scene(place(scene), options_.mesh));
  }
  return model;
}

}  // namespace marco::mapping3d
