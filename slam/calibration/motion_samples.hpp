#pragma once

#include <vector>

#include "slam/calibration/odometry_travel.hpp"
#include "slam/calibration/robot_model.hpp"

namespace marco::slam {

/// The laser's motion between two of its scans.
struct LaserMotion {
  double begin_s = 0.0;
  double end_s = 0.0;
  Pose2 moved;  ///< the laser at the end, seen from its own pose at the begin
};

/// How far stamps may be wrong.
inline constexpr double kMostLateS = 1.0;

/// Long enough to move by many times the matches' noise.
inline constexpr double kShortestMotionS = 0.5;

/// How long motions are that odometry is fitted to: ten of its readings. Between two readings the
/// way is a guess, which makes short motions look longer or shorter than they are, their scale too
/// small (errors in variables), and turns more certain than they are.
double motion_length_s(const OdometryTravel& odometry);

/// The laser's path cut into motions of `shortest_s` to 1 s more, one after another; what takes
/// longer is a gap. Stamps that step back replace what is later.
/// @param world_from_laser  a pose a scan, by scan matching
std::vector<LaserMotion> laser_motions(const Trajectory& world_from_laser,
                                       double shortest_s = kShortestMotionS);

/// Those during which the odometry is known, however late it is.
std::vector<LaserMotion> known_motions(const std::vector<LaserMotion>& motions,
                                       const OdometryTravel& travel);

/// The mean way [m] that the robot goes between the end of a motion and the nearest sample of
/// odometry that is so late. Whether it went first and turned then, nobody knows.
double mean_way_to_samples_m(const std::vector<LaserMotion>& motions,
                             const OdometryTravel& travel,
                             double late_s);

/// Blocked cross-validation. Blocks of up to 20 motions, some 10 s, are dealt to kFolds folds in
/// turn, for neighbours share their errors: one fold is held out, the others are fitted to.
inline constexpr std::size_t kFolds = 5;
struct SplitMotions {
  std::vector<LaserMotion> seen;
  std::vector<LaserMotion> held_out;
};
/// @param fold  that is held out, below kFolds
SplitMotions split(const std::vector<LaserMotion>& motions, std::size_t fold = kFolds - 1);

/// The laser's motions, each with what the wheels counted meanwhile.
/// @param signs  its signs, axle and late_s count; its scales do not
std::vector<MotionSample> motion_samples(const std::vector<LaserMotion>& motions,
                                         const OdometryTravel& travel,
                                         const OdometryCalibration& signs);

}  // namespace marco::slam
