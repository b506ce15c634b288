#include "slam/calibration/motion_samples.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {

double motion_length_s(const OdometryTravel& odometry) {
  // Of intel.log, odometry 0.3 s late, the wheels' scales came out 9 % too small from motions of
  // one reading, 2.5 % of 5, 1 % of 10: within their standard deviation.
  constexpr double kReadings = 10.0;
  return std::max(kShortestMotionS, kReadings * odometry.interval_s());
}

std::vector<LaserMotion> laser_motions(const Trajectory& world_from_laser, double shortest_s) {
  constexpr double kGapS = 1.0;  // more than scans of a running laser are apart
  Trajectory ascending;
  for (const StampedPose2& pose : world_from_laser) {
    while (!ascending.empty() && ascending.back().utime >= pose.utime) ascending.pop_back();
    ascending.push_back(pose);
  }
  std::vector<LaserMotion> motions;
  for (std::size_t begin = 0, end = 1; end < ascending.size(); ++end) {
    const double begin_s = ascending[begin].utime.seconds();
    const double end_s = ascending[end].utime.seconds();
    if (end_s - begin_s < shortest_s) continue;
    if (end_s - begin_s <= shortest_s + kGapS) {
      motions.push_back(
          {begin_s, end_s,
           between(ascending[begin].world_from_robot, ascending[end].world_from_robot)});
    }
    begin = end;
  }
  return motions;
}

std::vector<LaserMotion> known_motions(const std::vector<LaserMotion>& motions,
                                       const OdometryTravel& travel) {
  std::vector<LaserMotion> known;
  std::copy_if(motions.begin(), motions.end(), std::back_inserter(known),
               [&](const LaserMotion& motion) {
                 return travel.knows(motion.begin_s - kMostLateS, motion.end_s + kMostLateS);
               });
  return known;
}

double mean_way_to_samples_m(const std::vector<LaserMotion>& motions,
                             const OdometryTravel& travel,
                             double late_s) {
  double sum_m = 0.0;
  for (const LaserMotion& motion : motions) {
    const double speed_m_per_s =
        motion.moved.translation_m().norm() / (motion.end_s - motion.begin_s);
    sum_m += speed_m_per_s * travel.to_sample_s(motion.end_s + late_s);
  }
  return sum_m / static_cast<double>(std::max<std::size_t>(motions.size(), 1));
}

SplitMotions split(const std::vector<LaserMotion>& motions, std::size_t fold) {
  constexpr std::size_t kLongest = 20;  // of a stretch, in motions
  const std::size_t stretch = std::clamp<std::size_t>(motions.size() / 10, 1, kLongest);
  SplitMotions parts;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const bool is_held_out = i / stretch % kFolds == fold;
    (is_held_out ? parts.held_out : parts.seen).push_back(motions[i]);
  }
  return parts;
}

std::vector<MotionSample> motion_samples(const std::vector<LaserMotion>& motions,
                                         const OdometryTravel& travel,
                                         const OdometryCalibration& signs) {
  constexpr double kStepS = 0.1;  // of the wheels' path within a motion: an arc each
  const Pose2 robot_from_axle = signs.robot_from_axle();
  std::vector<MotionSample> samples;
  samples.reserve(motions.size());
  for (const LaserMotion& motion : motions) {
    const double length_s = motion.end_s - motion.begin_s;
    const int count = static_cast<int>(std::ceil(length_s / kStepS));
    MotionSample sample;
    sample.laser_moved = motion.moved;
    sample.robot_from_axle = robot_from_axle;
    for (int i = 0; i < count; ++i) {
      const double begin_s = motion.begin_s + signs.late_s + i * length_s / count;
      const ArcMotion counted =
          travel.between_moments(begin_s, begin_s + length_s / count).seen_at(robot_from_axle);
      const double ahead_m = signs.forward_sign * counted.ahead_m;
      const double apart_m = 0.5 * kCountedTrackM * signs.turn_sign * counted.turn_rad;
      sample.wheels.push_back(
          {ahead_m - apart_m, ahead_m + apart_m, signs.forward_sign * counted.left_m});
    }
    samples.push_back(std::move(sample));
  }
  return samples;
}

}  // namespace marco::slam
