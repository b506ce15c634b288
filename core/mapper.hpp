#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>

#include "common/grid_map.hpp"
#include "common/input/sensor_synchronizer.hpp"
#include "common/pose_estimate.hpp"
#include "common/trajectory.hpp"
#include "slam/doctor/doctor.hpp"
#include "slam/slam.hpp"

namespace marco {

/// 2D laser SLAM for a program of your own: scans, odometry and yaw rates in; a pose for each scan,
/// a map, and a verdict on the map out. The same code as marco-slam and `marco map`, without
/// messages, files or threads. Needs Eigen only. What differs: if turns show that a laser's beams
/// come in another order than announced, the scans before are not mapped again.
///
/// Lengths are in metres, angles in radians, counter-clockwise. The robot's frame is the one whose
/// motion odometry reports (x ahead, y left); the world is the robot's frame at the first scan.
///
/// A pure function of its inputs: the same calls give the same bytes. Not thread-safe. Memory
/// grows with the area mapped, and by 100 bytes a scan; by 220 if next_pose() is not called.
class Mapper {
 public:
  /// The channel of a pan-tilt's own SensorInfo.
  static constexpr const char* kPanTilt = "PANTILT_STATE";
  struct Options {
    SynchronizerOptions input;
    slam::SlamOptions slam;
  };

  Mapper();
  /// @throws std::invalid_argument for an option outside its limits.
  explicit Mapper(const Options& options);

  /// Where a laser sits on the robot, and its range limits; before its first scan. A laser's name
  /// is the `channel` of both: "LIDAR", or whatever you call it.
  /// @throws std::invalid_argument beyond 64 lasers.
  void add(const SensorInfo& laser);
  /// Optional. A scan waits for odometry at its last beam, half a second at most.
  void add(const OdometrySample& odometry);
  /// Optional: the yaw rate of a gyroscope.
  void add(const ImuSample& imu);
  /// Of a laser on a pan-tilt (SensorInfo::Mount::pantilt). The pan-tilt's own place on the robot
  /// is the SensorInfo of the channel kPanTilt. Scans of a tilted or panning laser get a pose only.
  void add(const PanTiltState& head);
  /// @param scan  of a laser that was announced; others are ignored, see ignored().
  void add(LaserScan scan);

  /// The pose of the oldest scan that was mapped and not asked for yet. Scans are mapped when all
  /// that belongs to them has arrived: mostly one call of add() later.
  std::optional<PoseEstimate> next_pose();

  /// Maps the scans that still wait and optimizes the whole map: minutes of recording take seconds.
  /// More may follow.
  void finish();

  /// A pose for each scan, after the newest optimization: loop closures move past poses.
  Trajectory path() const { return slam_.trajectory(); }
  /// Occupied, free and unknown cells.
  GridMap map() const { return slam_.grid().to_map(); }
  /// Whether the map contradicts itself, its loops or its odometry, with reasons and places. Takes
  /// as long as some hundred scans. Of a map after finish().
  slam::Diagnosis verdict() const;
  /// How many scans and samples were not used, by reason.
  const std::map<std::string, int>& ignored() const { return ignored_; }

 private:
  void map_complete_scans();
  void map_scan(const SynchronizedScan& scan);

  slam::SlamOptions options_;
  std::map<std::string, int> ignored_;
  SensorSynchronizer input_;
  slam::Slam slam_;
  Trajectory odometry_;  ///< at the scans
  slam::MapEvidence counted_;
  std::deque<PoseEstimate> poses_;
};

}  // namespace marco
