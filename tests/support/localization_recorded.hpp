#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/files/relations.hpp"
#include "common/input/stamp_repair.hpp"
#include "common/relations_metric.hpp"
#include "recordings/text_formats.hpp"
#include "tests/support/localization_trials.hpp"

namespace marco::testing {

/// The scans of a CARMEN log, each with the odometry before it.
inline std::vector<slam::SlamInput> read_carmen_scans(const std::string& path) {
  std::vector<slam::SlamInput> inputs;
  const auto reader = files::open_carmen(path);
  Pose2 odom_from_robot;
  SensorInfo info;
  StampRepair stamps;
  while (const std::optional<Sample> sample = reader->next()) {
    if (const auto* told = std::get_if<SensorInfo>(&*sample)) info = *told;
    if (const auto* odometry = std::get_if<OdometrySample>(&*sample)) {
      odom_from_robot = odometry->odom_from_robot;
    }
    const auto* scan = std::get_if<LaserScan>(&*sample);
    if (scan == nullptr) continue;
    slam::SlamInput input;
    input.scan = deskew_and_project(*scan, info, info.parent_from_sensor, {});
    input.motion = {
        stamps.repair(scan->utime), odom_from_robot, {}, stamps.period_s(), stamps.off_beat()};
    inputs.push_back(std::move(input));
  }
  return inputs;
}

/// The last third of a log whose first two thirds are a map. What is true is said by relations
/// between scans of both; a robot is switched on 5 m of path before the relation's second scan and
/// judged there.
class SplitLog {
 public:
  struct Trial {
    std::size_t first_scan = 0;  ///< where it was switched on
    std::size_t last_scan = 0;
    std::vector<TrialStep> steps;
  };

  SplitLog(const std::string& log, const std::string& relations)
      : inputs_(read_carmen_scans(log)), split_(inputs_.size() * 2 / 3) {
    slam::Slam mapper, whole;
    for (std::size_t i = 0; i < split_; ++i) mapper.process(inputs_[i]);
    mapper.finish();
    // How far it drove, and where it roughly was between the relations.
    for (const slam::SlamInput& input : inputs_) whole.process(input);
    whole.finish();
    path_ = whole.trajectory();
    keys_ = mapper.keys();
    take(files::read_relations(relations), mapper.trajectory());
  }

  const std::vector<slam::Keyframe>& map() const { return keys_; }
  /// The last third.
  std::vector<slam::SlamInput> rest() const {
    return {inputs_.begin() + static_cast<std::ptrdiff_t>(split_), inputs_.end()};
  }
  struct Errors {
    int count = 0;
    double mean_m = 0.0;
    double max_m = 0.0;
  };
  /// Of poses of the rest, in the map, by the relations.
  Errors errors(const std::vector<std::optional<Pose2>>& map_from_robots) const {
    Errors errors;
    for (const auto& [scan, map_from_robot] : ends_) {
      const std::optional<Pose2>& found = map_from_robots.at(scan - split_);
      if (!found) continue;
      const double off_m = between(map_from_robot, *found).translation_m().norm();
      ++errors.count;
      errors.mean_m += off_m;
      errors.max_m = std::max(errors.max_m, off_m);
    }
    errors.mean_m /= std::max(1, errors.count);
    return errors;
  }
  /// One for each scan that relations lead to from the map, and that was driven so far to.
  std::vector<Trial> trials(double path_m) const {
    std::vector<Trial> result;
    for (const auto& [scan, map_from_robot] : ends_) {
      Trial trial{scan, scan, {}};
      double driven_m = 0.0;
      while (trial.first_scan > split_ && driven_m < path_m) {
        --trial.first_scan;
        driven_m += between(path_[trial.first_scan].world_from_robot,
                            path_[trial.first_scan + 1].world_from_robot)
                        .translation_m()
                        .norm();
      }
      if (driven_m < path_m) continue;
      for (std::size_t i = trial.first_scan; i <= scan; ++i) {
        trial.steps.push_back({inputs_[i], path_[i].world_from_robot});
      }
      trial.steps.back().map_from_robot = map_from_robot;
      result.push_back(std::move(trial));
    }
    return result;
  }

 private:
  std::optional<std::size_t> scan_at(double time_s) const {
    for (std::size_t i = 0; i < path_.size(); ++i) {
      if (std::abs(static_cast<double>(path_[i].utime.us) * 1e-6 - time_s) < 2e-6) return i;
    }
    return std::nullopt;
  }
  void take(const std::vector<PoseRelation>& relations, const Trajectory& mapped) {
    for (const PoseRelation& relation : relations) {
      auto first = scan_at(relation.first_time_s), second = scan_at(relation.second_time_s);
      if (!first || !second) continue;
      Pose2 first_from_second = relation.first_from_second;
      if (*first > *second) {
        std::swap(first, second);
        first_from_second = first_from_second.inverse();
      }
      if (*first >= split_ || *second < split_) continue;
      ends_.emplace_back(*second, mapped[*first].world_from_robot * first_from_second);
    }
  }

  std::vector<slam::SlamInput> inputs_;
  std::size_t split_;
  Trajectory path_;
  std::vector<slam::Keyframe> keys_;
  std::vector<std::pair<std::size_t, Pose2>> ends_;
};

}  // namespace marco::testing
