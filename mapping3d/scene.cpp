#include "mapping3d/scene.hpp"

#include <algorithm>
#include <cmath>

#include "common/samples.hpp"

namespace marco::mapping3d {

namespace {

// Of a steep laser that the robot sweeps: less repeats the row; and a sweep ends while the path is
// still sure of its beginning.
constexpr double kStepM = 0.01, kStepDeg = 0.25, kLongestDriveM = 4.0;
constexpr double kCreepM = 0.001;  // the path of a robot that stands is still

struct Direction {
  double cosine;
  double sine;
};

std::vector<Direction> directions(const SceneRow& row) {
  std::vector<Direction> all(row.ranges_m.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double bearing_rad =
        row.first_bearing_rad + static_cast<double>(i) * row.bearing_step_rad;
    all[i] = {std::cos(bearing_rad), std::sin(bearing_rad)};
  }
  return all;
}

/// Of the scan plane, in the robot's frame.
Eigen::Vector3d scan_normal(const SceneRow& row) {
  return row.robot_from_sensor_first.linear().col(2);
}

bool inside(const RobotBox& robot, const Eigen::Vector3d& in_robot) {
  return in_robot.x() <= robot.ahead_m && in_robot.x() >= -robot.behind_m &&
         std::abs(in_robot.y()) <= robot.half_width_m && in_robot.z() <= robot.height_m;
}

/// Deskew: the sensor's pose at any part of a row, in the robot's frame at the first beam.
class RowMotion {
 public:
  explicit RowMotion(const SceneRow& row)
      : first_(row.robot_from_sensor_first),
        last_(lift(row.first_robot_from_last_robot) * row.robot_from_sensor_last),
        first_turn_(first_.linear()),
        last_turn_(last_.linear()),
        still_(first_.isApprox(last_, 1e-9)) {}

  Eigen::Vector3d place(const Eigen::Vector3d& in_sensor, double part) const {
    if (still_) return first_ * in_sensor;
    return first_turn_.slerp(part, last_turn_) * in_sensor + (1.0 - part) * first_.translation() +
           part * last_.translation();
  }
  Eigen::Vector3d middle() const { return 0.5 * (first_.translation() + last_.translation()); }

 private:
  Pose3 first_, last_;
  Eigen::Quaterniond first_turn_, last_turn_;
  bool still_;
};

}  // namespace

ScenePoints place(const Scene& scene, const RobotBox& robot) {
  validate(robot, "robot_box");
  ScenePoints placed;
  placed.rows = scene.rows.size();
  placed.columns = scene.columns();
  const std::size_t count = placed.rows * placed.columns;
  placed.points_m.resize(count, Eigen::Vector3f::Zero());
  placed.valid.resize(count, 0);
  std::vector<Direction> beams;
  for (std::size_t row = 0; row < placed.rows; ++row) {
    const SceneRow& from = scene.rows[row];
    const std::size_t columns = std::min(placed.columns, from.ranges_m.size());
    const SceneRow& before = scene.rows[row == 0 ? 0 : row - 1];
    if (row == 0 || beams.size() != from.ranges_m.size() ||
        from.first_bearing_rad != before.first_bearing_rad ||
        from.bearing_step_rad != before.bearing_step_rad) {
      beams = directions(from);
    }
    const Pose3 world_from_robot = lift(from.world_from_robot);
    const RowMotion motion(from);
    const bool timed = from.beam_parts.size() == from.ranges_m.size();
    const double per_column = columns > 1 ? 1.0 / static_cast<double>(columns - 1) : 0.0;
    for (std::size_t column = 0; column < columns; ++column) {
      const auto range_m = static_cast<double>(from.ranges_m[column]);
      if (!(range_m > 0.0) || !std::isfinite(range_m)) continue;
      const double part = timed ? static_cast<double>(from.beam_parts[column])
                                : static_cast<double>(column) * per_column;
      const Eigen::Vector3d in_robot =
          motion.place({range_m * beams[column].cosine, range_m * beams[column].sine, 0.0}, part);
      if (robot.height_m > 0.0 && inside(robot, in_robot)) continue;
      placed.points_m[placed.index(row, column)] = (world_from_robot * in_robot).cast<float>();
      placed.valid[placed.index(row, column)] = 1;
    }
    placed.origins_m.push_back((world_from_robot * motion.middle()).cast<float>());
  }
  return placed;
}

void move(ScenePoints& scene, const Pose3& to_from_world) {
  for (auto* points_m : {&scene.points_m, &scene.origins_m}) {
    for (Eigen::Vector3f& p : *points_m) p = (to_from_world * p.cast<double>()).cast<float>();
  }
}

SceneBuilder::SceneBuilder(const SceneBuilderOptions& options) : options_(options) {
  validate(options, "scene_builder");
}

SceneBuilder::Step SceneBuilder::step_to(const SceneRow& row,
                                         double pan_rad,
                                         double tilt_rad) const {
  const double pan_deg = rad_to_deg(normalize_angle(pan_rad - pan_rad_));
  const double tilt_deg = rad_to_deg(tilt_rad - tilt_rad_);
  const bool by_tilt = std::abs(tilt_deg) >= std::abs(pan_deg);
  const double step_deg = by_tilt ? tilt_deg : pan_deg;
  Step step;
  const double swept_deg =
      rad_to_deg((scan_normal(row) - scan_normal(rows_.back())).norm());  // of a small angle
  if (std::min(std::abs(step_deg), swept_deg) < options_.min_step_deg) return step_by_robot(row);
  step.axis = by_tilt ? Axis::tilt : Axis::pan;
  step.sign = step_deg > 0.0 ? 1 : -1;
  step.jump = std::abs(step_deg) > options_.max_step_deg;
  step.turned_deg = step_deg;
  return step;
}

SceneBuilder::Step SceneBuilder::step_by_robot(const SceneRow& row) const {
  Step step;
  const SceneRow& last = rows_.back();
  if (!is_steep(row.robot_from_sensor_first)) return step;
  const Pose3 before = lift(last.world_from_robot) * last.robot_from_sensor_first;
  const Pose3 now = lift(row.world_from_robot) * row.robot_from_sensor_first;
  step.drove_m = before.linear().col(2).dot(now.translation() - before.translation());
  step.turned_deg =
      rad_to_deg(normalize_angle(row.world_from_robot.theta_rad - last.world_from_robot.theta_rad));
  const double drives = std::abs(step.drove_m) / kStepM;
  const double turns = std::abs(step.turned_deg) / kStepDeg;
  if (std::max(drives, turns) < 1.0) return {};
  step.axis = drives >= turns ? Axis::drive : Axis::turn;
  step.sign = (drives >= turns ? step.drove_m : step.turned_deg) > 0.0 ? 1 : -1;
  step.jump = std::abs(step.drove_m) > options_.max_drive_m ||
              std::abs(step.turned_deg) > options_.max_step_deg;
  return step;
}

bool SceneBuilder::turns_back(const Step& step) const {
  if (direction_.axis == Axis::none) return false;
  if (step.axis == direction_.axis) return step.sign != direction_.sign;
  const auto by_robot = [](Axis axis) { return axis == Axis::drive || axis == Axis::turn; };
  return !by_robot(step.axis) || !by_robot(direction_.axis);  // round a bend it does both
}

bool SceneBuilder::is_whole() const {
  return std::abs(direction_.turned_deg) >= 360.0 || std::abs(direction_.drove_m) >= kLongestDriveM;
}

bool SceneBuilder::is_shifted(const SceneRow& row) const {
  constexpr double kShift = 0.1;  // of a step
  const double min_step_rad = deg_to_rad(options_.min_step_deg);
  for (auto known = rows_.rbegin(); known != rows_.rend(); ++known) {
    const double turned_rad =
        Eigen::AngleAxisd(known->robot_from_sensor_first.linear().transpose() *
                          row.robot_from_sensor_first.linear())
            .angle();
    // The last row's plane is this row's: it turned within it.
    if (turned_rad >= min_step_rad) return known != rows_.rbegin();
    const double shift_rad = std::abs(known->first_bearing_rad - row.first_bearing_rad);
    if (shift_rad < kShift * std::abs(row.bearing_step_rad)) return false;
  }
  return true;
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
  Step step = step_to(row, pan_rad, tilt_rad);
  const bool same_columns = row.ranges_m.size() == rows_.back().ranges_m.size();
  if (!same_columns && rows_.size() > 1 && !last_was_odd_) {
    last_was_odd_ = true;
    ++rows_without_scene_;
    return std::nullopt;
  }
  last_was_odd_ = false;
  const Duration since = row.utime - rows_.back().utime;
  if (step.axis == Axis::none && same_columns) {
    const Pose2 drove = between(rows_.back().world_from_robot, row.world_from_robot);
    const bool over = std::abs(since.seconds()) > options_.pause_s ||
                      drove.translation_m().norm() > options_.max_drive_m;
    if (!over && is_shifted(row)) {
      rows_.push_back(std::move(row));
      return std::nullopt;
    }
    // The same row once more. Of a robot that creeps the first one stays: its steps add up.
    const bool creeps = drove.translation_m().norm() > kCreepM;
    if (!over && (rows_.size() > 1 || creeps)) return std::nullopt;
    std::optional<Scene> scene = over ? finish() : std::nullopt;
    start(std::move(row), pan_rad, tilt_rad);
    return scene;
  }
  if (turns_back(step) || step.jump || !same_columns ||
      std::abs(since.seconds()) > options_.pause_s) {
    std::optional<Scene> scene = finish();
    start(std::move(row), pan_rad, tilt_rad);
    return scene;
  }
  rows_.push_back(std::move(row));
  pan_rad_ = pan_rad;
  tilt_rad_ = tilt_rad;
  step.turned_deg += direction_.turned_deg;
  step.drove_m += direction_.drove_m;
  direction_ = step;
  if (!is_whole()) return std::nullopt;
  SceneRow seam = rows_.back();
  std::optional<Scene> scene = finish();
  start(std::move(seam), pan_rad, tilt_rad);
  return scene;
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
