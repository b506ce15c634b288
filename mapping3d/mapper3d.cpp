#include "mapping3d/mapper3d.hpp"

namespace marco::mapping3d {

Mapper3d::Mapper3d(const Mapper3dOptions& options) : options_(options), builder_(options.builder) {
  validate(options, "mapping3d");
}

bool Mapper3d::keep(std::optional<Scene> scene) {
  if (!scene) return false;
  scenes_.push_back(std::move(*scene));
  changed_ = true;
  return true;
}

bool Mapper3d::add(const SceneRow& row, double pan_rad, double tilt_rad) {
  return keep(builder_.add(row, pan_rad, tilt_rad));
}

bool Mapper3d::finish() { return keep(builder_.finish()); }

void Mapper3d::follow(const Trajectory& keys, const std::map<Utime, Pose2>& known) {
  std::map<Utime, Pose2> corrections;  // world today from world until now, by key
  for (const StampedPose2& key : keys) {
    const auto before = known.find(key.utime);
    if (before != known.end()) {
      corrections[key.utime] = key.world_from_robot * before->second.inverse();
    }
  }
  const auto move = [&corrections](std::vector<SceneRow>& rows) {
    for (SceneRow& row : rows) {
      const auto after = corrections.upper_bound(row.utime);
      if (after == corrections.begin()) continue;
      row.world_from_robot = std::prev(after)->second * row.world_from_robot;
    }
  };
  for (Scene& scene : scenes_) move(scene.rows);
  move(builder_.rows());
  changed_ = true;
}

void Mapper3d::refine() {
  if (!changed_ || !options_.refine) return;
  changed_ = false;
  std::vector<ScenePoints> by_path;
  by_path.reserve(scenes_.size());
  for (const Scene& scene : scenes_) by_path.push_back(place(scene, options_.robot));
  registration_ = register_scenes(by_path, options_.registration);
}

ScenePoints Mapper3d::placed(std::size_t scene) const {
  ScenePoints points = place(scenes_[scene], options_.robot);
  if (scene < registration_.world_from_placed.size()) {
    move(points, registration_.world_from_placed[scene]);
  }
  return points;
}

std::vector<ScenePoints> Mapper3d::placed() const {
  std::vector<ScenePoints> all;
  all.reserve(scenes_.size());
  for (std::size_t i = 0; i < scenes_.size(); ++i) all.push_back(placed(i));
  return all;
}

TriangleMesh Mapper3d::model() const {
  TriangleMesh model;
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    append_mesh(model, mesh_scene(placed(i), options_.mesh));
  }
  return model;
}

}  // namespace marco::mapping3d
