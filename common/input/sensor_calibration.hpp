#pragma once

#include <string>
#include <vector>

#include "common/input/floor_line.hpp"
#include "common/input/own_body.hpp"
#include "common/samples.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco {

/// What a laser's beams are found to be, over what its messages say. By default as said.
struct BeamCalibration {
  std::string channel;          ///< of the laser
  double bearing_scale = 1.0;   ///< true bearing over the said one, both from the sensor's x axis
  double range_offset_m = 0.0;  ///< true range less the measured one

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("bearing_scale", bearing_scale, Limits{0.5, 2.0});
    v("range_offset_m", range_offset_m, Limits{-1.0, 1.0});
  }
  bool operator==(const BeamCalibration&) const = default;

  /// Puts bearings and ranges right. What is no return stays none: 0 and less, and ranges from
  /// `range_max_m` on. A range that the offset takes below 0 becomes none.
  void correct(LaserScan& scan, double range_max_m) const;
};

/// A short motion at a steady velocity, in the frame at its begin: an arc.
struct ArcMotion {
  double ahead_m = 0.0;  ///< along the arc
  double left_m = 0.0;
  double turn_rad = 0.0;

  /// The pose at its end, seen from its begin; and back.
  Pose2 moved() const;
  static ArcMotion of(const Pose2& moved);
  /// The same motion as a frame fixed to the body makes it.
  ArcMotion seen_at(const Pose2& body_from_frame) const;
};

/// Odometry given as poses is taken for that of two wheels so far apart: only `turn` and `ahead`
/// together say what each wheel did.
inline constexpr double kCountedTrackM = 0.4;

/// How odometry is to be corrected. By default, not at all.
struct OdometryCalibration {
  double forward_sign = 1.0;  ///< -1: it counts the way backwards
  double turn_sign = 1.0;     ///< -1: it counts turns the wrong way round
  double left_scale = 1.0;    ///< the left wheel's true way over the counted one; < 0: backwards
  double right_scale = 1.0;
  double track_scale = 1.0;  ///< the wheels' true distance over the one that turns are counted by
  /// Where the poses are not those of the axle's middle, looking ahead: that place, seen from them.
  double axle_x_m = 0.0;
  double axle_yaw_deg = 0.0;
  double late_s = 0.0;  ///< a stamp is so much later than the motion it comes with

  template <class Visitor>
  void visit(Visitor& v) {
    v("forward_sign", forward_sign, Limits{-1.0, 1.0});
    v("turn_sign", turn_sign, Limits{-1.0, 1.0});
    v("left_scale", left_scale, Limits{-100.0, 100.0});
    v("right_scale", right_scale, Limits{-100.0, 100.0});
    v("track_scale", track_scale, Limits{0.01, 100.0});
    v("axle_x_m", axle_x_m, Limits{-100.0, 100.0});
    v("axle_yaw_deg", axle_yaw_deg, Limits{-360.0, 360.0});
    v("late_s", late_s, Limits{-10.0, 10.0});
  }
  Pose2 robot_from_axle() const { return {axle_x_m, 0.0, deg_to_rad(axle_yaw_deg)}; }
  bool operator==(const OdometryCalibration&) const = default;

  /// What really was driven.
  ArcMotion corrected(const ArcMotion& by_odometry) const;
};

/// How a gyroscope is to be corrected: true rate = scale (rate - bias).
struct GyroCalibration {
  double scale = 1.0;  ///< < 0: it is mounted upside down
  double bias_rad_per_s = 0.0;
  double late_s = 0.0;  ///< as OdometryCalibration's

  template <class Visitor>
  void visit(Visitor& v) {
    v("scale", scale, Limits{-1000.0, 1000.0});
    v("bias_rad_per_s", bias_rad_per_s);
    v("late_s", late_s, Limits{-10.0, 10.0});
  }
  bool operator==(const GyroCalibration&) const = default;

  ImuSample corrected(ImuSample sample) const;
};

/// Where a laser, or the pan-tilt that bears it, really sits, over what SENSOR_INFO says. Height
/// and tilt stay. What is corrected already stays as it is.
struct LaserCalibration {
  std::string channel;  ///< whose SENSOR_INFO is corrected; "": none
  double x_m = 0.0;     ///< on the robot
  double y_m = 0.0;
  double yaw_deg = 0.0;
  bool upside_down = false;  ///< its z axis points down

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("x_m", x_m, Limits{-100.0, 100.0});
    v("y_m", y_m, Limits{-100.0, 100.0});
    v("yaw_deg", yaw_deg, Limits{-360.0, 360.0});
    v("upside_down", upside_down);
  }

  bool operator==(const LaserCalibration&) const = default;

  /// Of another channel, or a laser on a pan-tilt: as it is.
  SensorInfo corrected(SensorInfo as_said) const;
};

/// What a robot's sensors are found to be, over what their messages say.
struct SensorCalibration {
  LaserCalibration laser;
  OdometryCalibration odometry;
  GyroCalibration gyro;
  std::vector<BeamCalibration> beams;  ///< of its lasers
  std::vector<BodyPart> body;          ///< of the robot, in view of its lasers
  std::vector<FloorLine> floor;        ///< in view of its lasers

  template <class Visitor>
  void visit(Visitor& v) {
    v("laser", laser);
    v("odometry", odometry);
    v("gyro", gyro);
    v("beams", beams);
    v("body", body);
    v("floor", floor);
  }
  bool operator==(const SensorCalibration&) const = default;
};

/// Corrects odometry pose by pose. Not thread-safe.
class OdometryCorrector {
 public:
  /// The next sample, its stamp and velocities corrected too. The first keeps its pose.
  OdometrySample corrected(OdometrySample sample, const OdometryCalibration& calibration);

  template <class Visitor>
  void visit(Visitor& v) {
    v("started", started_);
    v("counted", counted_);
    v("corrected", corrected_);
  }

 private:
  bool started_ = false;
  Pose2 counted_;  ///< the last sample's
  Pose2 corrected_;
};

}  // namespace marco
