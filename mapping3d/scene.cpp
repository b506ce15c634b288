#include "mapping3d/scene.hpp"

#include <cmath>

namespace marco::mapping3d {

ScenePoints place(const Scene& scene) {
  ScenePoints placed;
  placed.rows = scene.rows.size();
  placed.columns = scene.columns();
  const std::size_t count = placed.rows * placed.columns;
  placed.points_m.resize(count, Eigen::Vector3f::Zero());
  placed.valid.resize(count, 0);
  for (std::size_t row = 0; row < placed.rows; ++row) {
    const SceneRow& from = scene.rows[row];
    const Pose3 world_from_robot = lift(from.world_from_robot);
    const Pose3 first = world_from_robot * from.robot_from_sensor_first;
    const Pose3 last = world_from_robot * from.robot_from_sensor_last;
    const Eigen::Quaterniond first_turn(first.linear()), last_turn(last.linear());
    const bool still = first.isApprox(last, 1e-9);
    const std::size_t columns = std::min(placed.columns, from.ranges_m.size());
    for (std::size_t column = 0; column < columns; ++column) {
      const auto range_m = static_cast<double>(from.ranges_m[column]);
      if (range_m <= 0.0) continue;
      const double bearing =
          from.first_bearing_rad + static_cast<double>(column) * from.bearing_step_rad;
      const Eigen::Vector3d in_sensor(range_m * std::cos(bearing), range_m * std::sin(bearing),
                                      0.0);
      Eigen::Vector3d in_world = first * in_sensor;
      if (!still) {
        const double part =
            columns > 1 ? static_cast<double>(column) / static_cast<double>(columns - 1) : 0.0;
        in_world = first_turn.slerp(part, last_turn) * in_sensor +
                   (1.0 - part) * first.translation() + part * last.translation();
      }
      placed.points_m[placed.index(row, column)] = in_world.cast<float>();
      placed.valid[placed.index(row, column)] = 1;
    }
    placed.origins_m.push_back((0.5 * (first.translation() + last.translation())).cast<float>());
  }
  return placed;
}

SceneBuilder::SceneBuilder(const SceneBuilderOptions& options) : options_(options) {
  validate(options, "scene_builder");
}

SceneBuilder::Step SceneBuilder::step_to(double pan_rad, double tilt_rad) const {
  const double pan_deg = rad_to_deg(normalize_angle(pan_rad - pan_rad_));
  const double tilt_deg = rad_to_deg(tilt_rad - tilt_rad_);
  const bool by_tilt = std::abs(tilt_deg) >= std::abs(pan_deg);
  const double step_deg = by_tilt ? tilt_deg : pan_deg;
  Step step;
  if (std::abs(step_deg) < options_.min_step_deg) return step;
  step.axis = by_tilt ? Axis::tilt : Axis::pan;
  step.sign = step_deg > 0.0 ? 1 : -1;
  step.jump = std::abs(step_deg) > options_.max_step_deg;
  return step;
}

void SceneBuilder::start(SceneRow row, double pan_rad, double tilt_rad) {
  rows_.clear();
  rows_.push_back(std::move(row));
  pan_rad_ = pan_rad;
  tilt_rad_ = tilt_rad;
  direction_ = Step{};
}

std::optional<Scene> SceneBuilder::add(SceneRow row, double pan_rad, double tilt_rad) {
  if (rows_.empty()) {
    start(std::move(row), pan_rad, tilt_rad);
    return std::nullopt;
  }
  const Step step = step_to(pan_rad, tilt_rad);
  const bool same_columns = row.ranges_m.size() == rows_.back().ranges_m.size();
  const Duration since = row.utime - rows_.back().utime;
  if (step.axis == Axis::none && same_columns) {
    const Pose2 drove = between(rows_.back().world_from_robot, row.world_from_robot);
    const bool over = std::abs(since.seconds()) > options_.pause_s ||
                      drove.translation_m().norm() > options_.max_drive_m;
    if (!over && rows_.size() > 1) return std::nullopt;  // the same row once more
    std::optional<Scene> scene = over ? finish() : std::nullopt;
    start(std::move(row), pan_rad, tilt_rad);
    return scene;
  }
  const bool turns = direction_.axis != Axis::none &&
                     (step.axis != direction_.axis || step.sign != direction_.sign);
  if (turns || step.jump || !same_columns || std::abs(since.seconds()) > options_.pause_s) {
    std::optional<Scene> scene = finish();
    start(std::move(row), pan_rad, tilt_rad);
    return scene;
  }
  rows_.push_back(std::move(row));
  pan_rad_ = pan_rad;
  tilt_rad_ = tilt_rad;
  direction_ = step;
  return std::nullopt;
}

std::optional<Scene> SceneBuilder::finish() {
  if (static_cast<int>(rows_.size()) < options_.min_rows) {
    rows_without_scene_ += static_cast<int64_t>(rows_.size());
    rows_.clear();
    return std::nullopt;
  }
  Scene scene{scenes_++, std::move(rows_)};
  rows_.clear();
  return scene;
}

}  // namespace marco::mapping3d
