#include "mapping3d/interlaced.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace marco::mapping3d {
namespace {

constexpr double kSameShift = 0.05;  // of a step
constexpr std::size_t kMostShifts = 8;
constexpr double kRegularPart = 0.9;  // of the rows

double angle_rad(const Pose3& a, const Pose3& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

// A standing robot's pose differs by as much from scan to scan.
bool is_small(const Pose2& moved) {
  constexpr double kSmall = 5e-4;  // metres and radians
  return moved.vector().cwiseAbs().maxCoeff() < kSmall;
}

/// Whether a row can be joined to the one before.
bool is_continued(const SceneRow& before, const SceneRow& row) {
  return row.bearing_step_rad > 0.0 &&
         std::abs(row.bearing_step_rad - before.bearing_step_rad) < 1e-3 * row.bearing_step_rad &&
         is_small(between(before.world_from_robot, row.world_from_robot)) &&
         is_small(row.first_robot_from_last_robot);
}

/// How its rows' beams are shifted against each other.
class Shifts {
 public:
  explicit Shifts(const Scene& scene) : scene_(scene) {
    if (scene.rows.size() < 2 * kMostShifts || !is_still()) return;
    step_rad_ = scene.rows.front().bearing_step_rad;
    for (std::size_t count = 2; count <= kMostShifts && count_ == 0; ++count) {
      if (has_turns_of(count)) count_ = count;
    }
  }

  /// 0 = they are not
  std::size_t count() const { return count_; }

  /// Of a row: 0 to count() - 1, in the order of bearings.
  std::size_t of(const SceneRow& row) const {
    const double shift = steps(row) * static_cast<double>(count_);
    return static_cast<std::size_t>(std::lround(shift)) % count_;
  }

 private:
  /// The row's first bearing in steps, without whole ones; what is almost 1 is 0.
  double steps(const SceneRow& row) const {
    const double steps = row.first_bearing_rad / step_rad_;
    const double part = steps - std::floor(steps);
    return part > 1.0 - kSameShift ? 0.0 : part;
  }

  bool is_still() const {
    std::size_t moved = 0;
    for (std::size_t i = 1; i < scene_.rows.size(); ++i) {
      moved += is_continued(scene_.rows[i - 1], scene_.rows[i]) ? 0 : 1;
    }
    return moved <= few();
  }

  std::size_t few() const {
    return static_cast<std::size_t>((1.0 - kRegularPart) * static_cast<double>(scene_.rows.size()));
  }

  bool has_turns_of(std::size_t count) const {
    std::vector<bool> seen(count, false);
    std::size_t next = 0, off = 0, wide = 0;
    for (std::size_t i = 0; i < scene_.rows.size(); ++i) {
      const double shift = steps(scene_.rows[i]) * static_cast<double>(count);
      if (std::abs(shift - std::round(shift)) > kSameShift * static_cast<double>(count))
        return false;
      const std::size_t slot = static_cast<std::size_t>(std::lround(shift)) % count;
      off += i > 0 && slot != next ? 1 : 0;
      next = (slot + 1) % count;
      seen[slot] = true;
      wide += i > 0 && angle_rad(scene_.rows[i - 1].robot_from_sensor_first,
                                 scene_.rows[i].robot_from_sensor_first) > step_rad_
                  ? 1
                  : 0;
    }
    return off <= few() && wide <= few() &&
           std::all_of(seen.begin(), seen.end(), [](bool s) { return s; });
  }

  const Scene& scene_;
  double step_rad_ = 0.0;
  std::size_t count_ = 0;
};

/// Rows of different shifts as one.
SceneRow join(const std::vector<const SceneRow*>& rows,
              double first_bearing_rad,
              double step_rad,
              std::size_t columns) {
  SceneRow joined = *rows.front();
  joined.first_bearing_rad = first_bearing_rad;
  joined.bearing_step_rad = step_rad;
  joined.ranges_m.assign(columns, 0.0F);
  joined.beam_parts.assign(columns, 0.0F);
  const SceneRow& last = *rows.back();
  joined.robot_from_sensor_last = last.robot_from_sensor_last;
  joined.pan_last_rad = last.pan_last_rad;
  joined.tilt_last_rad = last.tilt_last_rad;
  joined.duration_s = (last.utime - joined.utime).seconds() + last.duration_s;
  const Pose3 begin = joined.robot_from_sensor_first;
  const double whole_rad = angle_rad(begin, joined.robot_from_sensor_last);
  const auto part_at = [&](const Pose3& robot_from_sensor) {
    return whole_rad > 1e-9 ? std::min(1.0, angle_rad(begin, robot_from_sensor) / whole_rad) : 0.0;
  };
  for (const SceneRow* row : rows) {
    const double from = part_at(row->robot_from_sensor_first);
    const double until = part_at(row->robot_from_sensor_last);
    const bool timed = row->beam_parts.size() == row->ranges_m.size();
    const double beams = std::max(1.0, static_cast<double>(row->ranges_m.size()) - 1.0);
    for (std::size_t beam = 0; beam < row->ranges_m.size(); ++beam) {
      const double bearing_rad =
          row->first_bearing_rad + static_cast<double>(beam) * row->bearing_step_rad;
      const auto column =
          static_cast<std::size_t>(std::lround((bearing_rad - first_bearing_rad) / step_rad));
      if (column >= columns) continue;
      const double own =
          timed ? static_cast<double>(row->beam_parts[beam]) : static_cast<double>(beam) / beams;
      joined.ranges_m[column] = row->ranges_m[beam];
      joined.beam_parts[column] = static_cast<float>(from + own * (until - from));
    }
  }
  return joined;
}

}  // namespace

Scene joined_rows(const Scene& scene) {
  const Shifts shifts(scene);
  if (shifts.count() == 0) return scene;
  const double step_rad = scene.rows.front().bearing_step_rad / static_cast<double>(shifts.count());
  double first_rad = std::numeric_limits<double>::infinity(), last_rad = -first_rad;
  for (const SceneRow& row : scene.rows) {
    first_rad = std::min(first_rad, row.first_bearing_rad);
    last_rad =
        std::max(last_rad, row.first_bearing_rad +
                               row.bearing_step_rad * static_cast<double>(row.ranges_m.size() - 1));
  }
  const auto columns = static_cast<std::size_t>(std::lround((last_rad - first_rad) / step_rad)) + 1;
  Scene joined{scene.number, {}, scene.laser};
  std::vector<const SceneRow*> rows;
  const auto end_row = [&] {
    if (!rows.empty()) joined.rows.push_back(join(rows, first_rad, step_rad, columns));
    rows.clear();
  };
  for (const SceneRow& row : scene.rows) {
    const bool ends = !rows.empty() && (shifts.of(row) <= shifts.of(*rows.back()) ||
                                        !is_continued(*rows.back(), row));
    if (ends) end_row();
    rows.push_back(&row);
  }
  end_row();
  return joined;
}

}  // namespace marco::mapping3d
