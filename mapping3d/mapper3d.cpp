#include "mapping3d/mapper3d.hpp"

#include <Eigen/SVD>

namespace marco::mapping3d {
namespace {

/// The rigid motion that lays the joined scenes best on where the path put them, all together: one
/// scene alone, held fixed, would hand its own error on to the whole model.
Pose3 path_from_joined(const std::vector<ScenePoints>& by_path, const RegistrationResult& joined) {
  constexpr std::size_t kEach = 97;  // a sample
  Eigen::Vector3d path_sum = Eigen::Vector3d::Zero(), joined_sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < by_path.size(); ++i) {
    if (!joined.joined[i]) continue;
    for (std::size_t at = 0; at < by_path[i].points_m.size(); at += kEach) {
      if (by_path[i].valid[at] == 0) continue;
      const Eigen::Vector3d path_m = by_path[i].points_m[at].cast<double>();
      const Eigen::Vector3d joined_m = joined.world_from_placed[i] * path_m;
      path_sum += path_m;
      joined_sum += joined_m;
      products += path_m * joined_m.transpose();
      count += 1.0;
    }
  }
  Pose3 fit = Pose3::Identity();
  if (count < 3.0) return fit;
  // Kabsch 1976; a reflection cannot be, for the two sets are nearly the same.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(products - path_sum * joined_sum.transpose() / count,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  fit.linear() = svd.matrixU() * svd.matrixV().transpose();
  if (fit.linear().determinant() < 0.0) return Pose3::Identity();
  fit.translation() = path_sum / count - fit.linear() * (joined_sum / count);
  return fit;
}

}  // namespace

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
  refined_ = registration_.overlaps > 0 &&
             registration_.after.median_m < options_.min_gain * registration_.before.median_m;
  const Pose3 back = path_from_joined(by_path, registration_);
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    Pose3& world_from_placed = registration_.world_from_placed[i];
    if (registration_.joined[i]) world_from_placed = back * world_from_placed;
  }
}

ScenePoints Mapper3d::placed(std::size_t scene) const {
  ScenePoints points = place(scenes_[scene], options_.robot);
  if (refined_ && scene < registration_.world_from_placed.size()) {
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
