#include "mapping3d/mapper3d.hpp"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "mapping3d/interlaced.hpp"
#include "mapping3d/sweep_body.hpp"

namespace marco::mapping3d {
Mapper3d::Mapper3d(const Mapper3dOptions& options) : options_(options) {
  validate(options, "mapping3d");
}

bool Mapper3d::keep(std::optional<Scene> scene, const std::string& laser) {
  if (!scene) return false;
  scene->laser = laser;
  blank(*scene, own_body_);
  scene->number = static_cast<int>(scenes_.size());
  scenes_.push_back(std::move(*scene));
  settle(first_scene_of_last_stop());
  set_changed();
  return true;
}

std::size_t Mapper3d::first_scene_of_last_stop() const {
  std::size_t first = scenes_.size() - 1;
  const std::optional<Utime> stop = scenes_[first].rows.back().stop;
  while (stop && first > 0 && scenes_[first - 1].rows.back().stop == stop) --first;
  return first > 0 ? first - 1 : 0;  // one that began before the stop and ended in it
}

void Mapper3d::settle(std::size_t first_scene) {
  std::vector<std::vector<SceneRow>*> all;
  for (std::size_t scene = first_scene; scene < scenes_.size(); ++scene) {
    all.push_back(&scenes_[scene].rows);
  }
  for (auto& [laser, builder] : builders_) all.push_back(&builder.rows());
  std::map<Utime, const SceneRow*> newest;
  for (const std::vector<SceneRow>* rows : all) {
    for (const SceneRow& row : *rows) {
      if (!row.stop) continue;
      const SceneRow*& known = newest[*row.stop];
      if (known == nullptr || known->utime <= row.utime) known = &row;
    }
  }
  for (std::vector<SceneRow>* rows : all) {
    for (SceneRow& row : *rows) {
      if (row.stop) row.world_from_robot = newest.at(*row.stop)->world_from_robot;
    }
  }
}

int64_t Mapper3d::rows_without_scene() const {
  int64_t rows = 0;
  for (const auto& [laser, builder] : builders_) rows += builder.rows_without_scene();
  return rows;
}

void Mapper3d::require_ranges() const {
  if (finished_) throw std::logic_error("Mapper3d: the ranges went with finish_model()");
}

void Mapper3d::set_changed() {
  require_ranges();
  changed_ = true;
  model_.reset();
}

bool Mapper3d::add(const SceneRow& row, double pan_rad, double tilt_rad, const std::string& laser) {
  SceneBuilder& builder = builders_.try_emplace(laser, options_.builder).first->second;
  return keep(builder.add(row, pan_rad, tilt_rad), laser);
}

std::size_t Mapper3d::finish() {
  const std::size_t before = scenes_.size();
  for (auto& [laser, builder] : builders_) keep(builder.finish(), laser);
  return scenes_.size() - before;
}

void Mapper3d::follow(const PathCorrection& correction) {
  const auto move = [&correction](std::vector<SceneRow>& rows) {
    for (SceneRow& row : rows) {
      row.world_from_robot = correction.corrected(row.utime, row.world_from_robot);
    }
  };
  for (Scene& scene : scenes_) move(scene.rows);
  for (auto& [laser, builder] : builders_) move(builder.rows());
  settle(0);
  set_changed();
}

void Mapper3d::leave_out_own_body() {
  const std::vector<BodyPart> found = find_own_body(scenes_);
  if (found.empty()) return;
  for (Scene& scene : scenes_) blank(scene, found);
  own_body_.insert(own_body_.end(), found.begin(), found.end());
}

void Mapper3d::refine() {
  if (!changed_) return;
  changed_ = false;
  model_.reset();
  leave_out_own_body();
  if (!options_.refine) return;
  const PlacedScenes by_path{scenes_.size(),
                             [this](std::size_t i) { return place(scenes_[i], options_.robot); }};
  const std::vector<std::size_t> stops = stop_of_each();
  registration_ = register_scenes(by_path, options_.registration, stops);
  refined_ = std::find(registration_.joined.begin(), registration_.joined.end(), true) !=
             registration_.joined.end();
  straighten_sweeps(stops);
}

void Mapper3d::straighten_sweeps(const std::vector<std::size_t>& stops) {
  straightening_ = {};
  if (!options_.straighten || scenes_.size() < 2) return;
  std::vector<Pose3> start(scenes_.size(), Pose3::Identity());
  if (refined_) start = registration_.world_from_placed;
  straightening_ = straighten(scenes_, options_.robot, start, stops, options_.straightening);
  if (!straightening_.bent) return;
  registration_.world_from_placed = straightening_.world_from_placed;
  refined_ = true;
}

std::vector<std::size_t> Mapper3d::stop_of_each() const {
  std::vector<std::size_t> stops;
  Pose2 at;
  const auto still = [&](const Scene& scene) {
    return std::all_of(scene.rows.begin(), scene.rows.end(), [&](const SceneRow& row) {
      const Pose2 moved = between(at, row.world_from_robot);
      return moved.translation_m().norm() <= options_.stop_m &&
             std::abs(moved.theta_rad) <= deg_to_rad(options_.stop_deg);
    });
  };
  for (const Scene& scene : scenes_) {
    const bool same = !stops.empty() && still(scene);
    stops.push_back(stops.empty() ? 0 : stops.back() + (same ? 0 : 1));
    if (!same) at = scene.rows.front().world_from_robot;
  }
  return stops;
}

ScenePoints Mapper3d::placed(std::size_t scene) const {
  require_ranges();
  const bool bent = straightening_.bent && scene < straightening_.turns_rad.size();
  ScenePoints points =
      place(joined_rows(bent ? straightened(scenes_[scene], straightening_.turns_rad[scene],
                                            straightening_.range_m)
                             : scenes_[scene]),
            options_.robot);
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

const TriangleMesh& Mapper3d::model() const {
  if (!model_) {
    model_ = fuse({scenes_.size(), [this](std::size_t i) { return placed(i); }}, options_.surface);
  }
  return *model_;
}

void Mapper3d::finish_model() {
  if (!finished_) model();
  finished_ = true;
  for (Scene& scene : scenes_) {
    for (SceneRow& row : scene.rows) {
      row.ranges_m = std::vector<float>();  // {} would keep its memory
      row.beam_parts = std::vector<float>();
    }
  }
  malloc_trim(0);  // the heap would keep small blocks for itself
}

TriangleMesh Mapper3d::scene_meshes() const {
  TriangleMesh meshes;
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    append_mesh(meshes, mesh_scene(placed(i), options_.mesh));
  }
  return meshes;
}

}  // namespace marco::mapping3d
