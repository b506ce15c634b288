#pragma once

#include <string>
#include <vector>

#include "common/pose3.hpp"
#include "drivers/hcs12/base_driver.hpp"
#include "drivers/hcs12/pantilt_driver.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/camera_view.hpp"
#include "simulator/simulation_options.hpp"

namespace marco::sim {

/// @throws std::invalid_argument naming `what` unless there are three.
inline Eigen::Vector3d three(const std::vector<double>& values, const char* what) {
  require(values.size() == 3, std::string(what) + ": expected three numbers");
  return Eigen::Vector3d(values.data());
}

/// The body that meets walls: a box about the turning centre.
struct BodySpec {
  double front_m = 0.30;
  double back_m = 0.30;
  double half_width_m = 0.27;
  double height_m = 0.70;

  template <class Visitor>
  void visit(Visitor& v) {
    v("front_m", front_m, kPositive);
    v("back_m", back_m, kPositive);
    v("half_width_m", half_width_m, kPositive);
    v("height_m", height_m, kPositive);
  }
};

struct LiveLaserSpec {
  std::string port = "laser";  ///< name of its link
  /// sick, leuze, leuze_service, hokuyo, rplidar (an A1), rplidar_a2, rplidar_a3, rplidar_s1,
  /// rplidar_c1, rplidar_s2, rplidar_s3, ld19, stl27l, ydlidar_x2, ydlidar_x4, ydlidar_g4,
  /// hokuyo_scip1, hokuyo_utm, hokuyo_ust, tim551, tim561 or lms111
  std::string device = "sick";
  std::string mount = "robot";  ///< or "pantilt"
  std::vector<double> position_m{0.0, 0.0, 0.3};
  std::vector<double> roll_pitch_yaw_deg{0.0, 0.0, 0.0};
  int tcp_port = -1;    ///< 0 and above: on TCP instead of a pseudo-terminal
  int baud = 0;         ///< at power-on; 0 = the device's own
  LaserOptions optics;  ///< noise and materials; the device sets beams and bearings

  template <class Visitor>
  void visit(Visitor& v) {
    v("port", port);
    v("device", device);
    v("mount", mount);
    v("position_m", position_m);
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg);
    v("tcp_port", tcp_port, Limits{-1, 65535});
    v("baud", baud, Limits{0, 1000000});
    v("optics", optics);
  }
};

struct LivePanTiltSpec {
  bool fitted = false;
  std::vector<double> position_m{0.10, 0.0, 0.60};
  std::vector<double> tilt_axis_m{0.0, 0.0, 0.0};
  bool manual_firmware = false;  ///< the manual's replies instead of the listing's
  drivers::hcs12::PanTiltAxisOptions pan{360.0 / 248.0, 0.0, 248, 36.0};
  drivers::hcs12::PanTiltAxisOptions tilt{0.65, -20.0, 100, 20.0};

  template <class Visitor>
  void visit(Visitor& v) {
    v("fitted", fitted);
    v("position_m", position_m);
    v("tilt_axis_m", tilt_axis_m);
    v("manual_firmware", manual_firmware);
    v("pan", pan);
    v("tilt", tilt);
  }
};

struct LiveCameraSpec {
  std::string channel = "CAMERA";
  std::string mount = "robot";  ///< or "pantilt"
  std::vector<double> position_m{0.1, 0.0, 0.4};
  std::vector<double> roll_pitch_yaw_deg{0.0, 0.0, 0.0};
  double rate_hz = 1.0;
  int jpeg_quality = 85;
  CameraView view;

  template <class Visitor>
  void visit(Visitor& v) {
    v("channel", channel);
    v("mount", mount);
    v("position_m", position_m);
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg);
    v("rate_hz", rate_hz, Limits{0.01, 60.0});
    v("jpeg_quality", jpeg_quality, Limits{1, 100});
    v("view", view);
  }
};

/// A robot file (config/robots/*.toml): what marco-sim puts on wheels.
struct RobotSpec {
  std::string base = "hcs12";  ///< or p2os, text or create
  bool manual_sonar = false;   ///< hcs12: the manual's reply of `s`
  double wheel_diameter_m = 0.30;
  double track_m = 0.50;
  std::string pioneer = "P2DX";       ///< p2os: its subtype, such as p3dx-sh or amigo
  double sonar_ring_radius_m = 0.25;  ///< hcs12; the Pioneer's ring is its maker's
  double sonar_height_m = 0.25;
  bool imu = false;
  std::string imu_device = "witmotion";  ///< or bno055
  bool gamepad = false;
  BodySpec body;
  LivePanTiltSpec pantilt;
  std::vector<LiveLaserSpec> lasers;
  std::vector<LiveCameraSpec> cameras;
  OdometryOptions wheels;  ///< how far the floor is from what the wheels say

  template <class Visitor>
  void visit(Visitor& v) {
    v("base", base);
    v("manual_sonar", manual_sonar);
    v("wheel_diameter_m", wheel_diameter_m, kPositive);
    v("track_m", track_m, kPositive);
    v("pioneer", pioneer);
    v("sonar_ring_radius_m", sonar_ring_radius_m, kNotNegative);
    v("sonar_height_m", sonar_height_m, kPositive);
    v("imu", imu);
    v("imu_device", imu_device);
    v("gamepad", gamepad);
    v("body", body);
    v("pantilt", pantilt);
    v("lasers", lasers);
    v("cameras", cameras);
    v("wheels", wheels);
  }
};

}  // namespace marco::sim
