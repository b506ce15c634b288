#pragma once

#include <Eigen/Core>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/laser_scan.hpp"
#include "common/pose2.hpp"
#include "common/pose3.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// Pose and limits of a sensor (lcmtypes/marco/sensor_info_t.lcm).
struct SensorInfo {
  enum class Mount { robot, pantilt };

  Utime utime;
  std::string channel = "LIDAR";  ///< whose messages this describes
  Mount mount = Mount::robot;     ///< parent frame of the pose below
  Pose3 parent_from_sensor = Pose3::Identity();
  Eigen::Vector3d tilt_axis_m = Eigen::Vector3d::Zero();  ///< of a pan-tilt, in its panned frame
  double scan_duration_s = 0.0;                           ///< first beam to last beam
  double range_min_m = 0.0;                               ///< nearer returns are ignored
  double range_max_m = 80.0;                              ///< this range and more: no return
  double range_sigma_m = 0.0;                             ///< 0 = not known
  double focal_length_px = 0.0;                           ///< of a camera
};

/// Whether a laser's scan plane is so steep that it sees floor and ceiling rather than walls: its
/// scans are rows of a 3D scene, not a map's.
bool is_steep(const Pose3& robot_from_sensor);

/// Remembers the newest of each channel. @returns false, and changes nothing, when there are too
/// many channels: any program on the network may announce some.
bool note_sensor(std::map<std::string, SensorInfo>& by_channel, const SensorInfo& info);
inline constexpr const char* kTooManySensors = "sensor_info_t: more than 64 channels";

struct OdometrySample {
  Utime utime;
  Pose2 odom_from_robot;
  double velocity_m_per_s = 0.0;
  double yaw_rate_rad_per_s = 0.0;
  int64_t left_clicks = 0;  ///< signed sums; 0 where not known
  int64_t right_clicks = 0;
};

struct ImuSample {
  Utime utime;
  Eigen::Vector3d angular_velocity_rad_per_s = Eigen::Vector3d::Zero();  ///< robot frame
  Eigen::Vector3d acceleration_m_per_s2 =
      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
};

struct PanTiltAngles {
  double pan_rad = 0.0;
  double tilt_rad = 0.0;
};

struct PanTiltState {
  Utime utime;
  double pan_rad = 0.0;   ///< counter-clockwise, 0 = ahead
  double tilt_rad = 0.0;  ///< 0 = level, > 0 looks up
  double pan_rate_rad_per_s = 0.0;
  double tilt_rate_rad_per_s = 0.0;

  PanTiltAngles angles() const { return {pan_rad, tilt_rad}; }
};

/// From the simulator or motion capture.
struct TruePose {
  Utime utime;
  Pose2 world_from_robot;
  /// The pose is of another clock than the scans: the stamp is good to the time that messages take
  /// to arrive.
  bool is_by_arrival = false;
};

/// Any measurement of a log or a robot, as a value.
using Sample =
    std::variant<SensorInfo, LaserScan, OdometrySample, ImuSample, PanTiltState, TruePose>;

/// Pose of a laser on a pan-tilt. @param base the SensorInfo of the pan-tilt, @param sensor the
/// laser's. robot_from_base · Rz(pan) · T(tilt_axis) · Ry(-tilt) · plate_from_sensor  (thesis B
/// eq. 4.1 in our axes: tilt > 0 looks up; the lever arm is applied before the tilt, where the
/// listing forgot it).
Pose3 robot_from_pantilt_sensor(const SensorInfo& base,
                                const SensorInfo& sensor,
                                double pan_rad,
                                double tilt_rad);

/// Pose of any sensor. @param base  the SensorInfo of its pan-tilt, nullptr: none is known. @param
/// head  its angles. @returns nothing of a sensor on a pan-tilt of which either is missing.
std::optional<Pose3> robot_from_sensor(const SensorInfo& sensor,
                                       const SensorInfo* base,
                                       const std::optional<PanTiltAngles>& head);

/// The channel's; nullptr: none was announced.
const SensorInfo* find_sensor(const std::map<std::string, SensorInfo>& by_channel,
                              const std::string& channel);

}  // namespace marco
