#include "common/relations_metric.hpp"

#include <algorithm>
#include <cmath>

namespace marco {
namespace {

struct Timed {
  double time_s;
  Pose2 pose;
};

const Pose2* nearest(const std::vector<Timed>& poses, double time_s, double tolerance_s) {
  const auto after = std::lower_bound(poses.begin(), poses.end(), time_s,
                                      [](const Timed& pose, double t) { return pose.time_s < t; });
  const Timed* best = nullptr;
  if (after != poses.begin()) best = &*(after - 1);
  if (after != poses.end() &&
      (best == nullptr || std::abs(after->time_s - time_s) < std::abs(best->time_s - time_s))) {
    best = &*after;
  }
  if (best == nullptr || std::abs(best->time_s - time_s) > tolerance_s) return nullptr;
  return &best->pose;
}

ErrorSpread spread(std::vector<double> values) {
  ErrorSpread result;
  const auto count = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / count;
  double squares = 0.0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  result.std = std::sqrt(squares / count);
  std::sort(values.begin(), values.end());
  result.p95 = values[static_cast<std::size_t>(0.95 * static_cast<double>(values.size() - 1))];
  result.max = values.back();
  return result;
}

class Errors {
 public:
  void add(double translation_m, double rotation_deg) {
    translations_m_.push_back(translation_m);
    rotations_deg_.push_back(rotation_deg);
  }
  RelationsError summary() const {
    if (translations_m_.empty()) return {};
    return {translations_m_.size(), spread(translations_m_), spread(rotations_deg_)};
  }

 private:
  std::vector<double> translations_m_;
  std::vector<double> rotations_deg_;
};

}  // namespace

RelationsReport compare_with_relations(const Trajectory& trajectory,
                                       const std::vector<PoseRelation>& relations,
                                       double tolerance_s) {
  std::vector<Timed> poses;
  poses.reserve(trajectory.size());
  for (const StampedPose2& stamped : trajectory) {
    poses.push_back({stamped.utime.seconds(), stamped.world_from_robot});
  }
  std::sort(poses.begin(), poses.end(), [](const Timed& a, const Timed& b) {
    if (a.time_s != b.time_s) return a.time_s < b.time_s;
    if (a.pose.x_m != b.pose.x_m) return a.pose.x_m < b.pose.x_m;
    return a.pose.y_m < b.pose.y_m;
  });
  RelationsReport report;
  Errors all, far_apart;
  for (const PoseRelation& relation : relations) {
    const Pose2* first = nearest(poses, relation.first_time_s, tolerance_s);
    const Pose2* second = nearest(poses, relation.second_time_s, tolerance_s);
    if (first == nullptr || second == nullptr) {
      ++report.skipped;
      continue;
    }
    const Pose2 error = between(relation.first_from_second, between(*first, *second));
    const double translation_m = error.translation_m().norm();
    const double rotation_deg = std::abs(rad_to_deg(normalize_angle(error.theta_rad)));
    all.add(translation_m, rotation_deg);
    constexpr double kFarApartS = 60.0;  // a minute later, loops tell the error, not the last scans
    if (std::abs(relation.second_time_s - relation.first_time_s) > kFarApartS) {
      far_apart.add(translation_m, rotation_deg);
    }
  }
  report.all = all.summary();
  report.far_apart = far_apart.summary();
  return report;
}

}  // namespace marco
