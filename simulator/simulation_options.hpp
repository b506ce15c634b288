#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "drivers/laser/beam_order.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::sim {

/// The laser, by default a SICK LMS in its millimetre mode; other devices: device_laser(). Bounds
/// of tests refer to these defaults.
struct LaserOptions {
  int beams = 361;
  double first_bearing_deg = -90.0;
  double step_deg = 0.5;  ///< negative for a mirror that turns clockwise
  double scans_per_s = 37.5;
  int interlaced_turns = 2;       ///< of the mirror that make up a scan, beam after beam
  double scan_duration_s = 0.02;  ///< first beam to last beam
  double range_min_m = 0.05;      ///< for SENSOR_INFO
  double range_max_m = 32.759;
  double no_return_m = 32.759;  ///< the range sent when nothing came back
  double range_sigma_m = 0.010;
  double quantum_m = 0.001;
  double footprint_deg = 0.5;             ///< of one beam: at an edge it sees both surfaces
  double mixing_depth_m = 1.0;            ///< surfaces closer together than this mix into one range
  double missing_part = 0.0005;           ///< share of the beams that are lost without a cause
  double black_max_incidence_deg = 55.0;  ///< beyond it black returns nothing (thesis B ch. 3.2.1)
  double glass_mirror_incidence_deg = 8.0;  ///< below it glass itself returns the beam
  double glass_reflects_beyond_deg =
      70.0;  ///< beyond it glass is a mirror; between the two it is transparent

  template <class Visitor>
  void visit(Visitor& v) {
    v("beams", beams, Limits{2, 10000});
    v("first_bearing_deg", first_bearing_deg);
    v("step_deg", step_deg, Limits{-180.0, 180.0});
    v("scans_per_s", scans_per_s, Limits{0.1, 1000.0});
    v("interlaced_turns", interlaced_turns, Limits{1, 8});
    v("scan_duration_s", scan_duration_s, kNotNegative);
    v("range_min_m", range_min_m, kNotNegative);
    v("range_max_m", range_max_m, kPositive);
    v("no_return_m", no_return_m, kNotNegative);
    v("range_sigma_m", range_sigma_m, kNotNegative);
    v("quantum_m", quantum_m, kNotNegative);
    v("footprint_deg", footprint_deg, kNotNegative);
    v("mixing_depth_m", mixing_depth_m, kNotNegative);
    v("missing_part", missing_part, Limits{0.0, 1.0});
    v("black_max_incidence_deg", black_max_incidence_deg, Limits{0.0, 90.0});
    v("glass_mirror_incidence_deg", glass_mirror_incidence_deg, Limits{0.0, 90.0});
    v("glass_reflects_beyond_deg", glass_reflects_beyond_deg, Limits{0.0, 90.0});
  }

  /// When a beam is measured [s after the first one]: the mirror turns evenly, and the last turn
  /// ends with the fan.
  double time_of_beam_s(int beam) const {
    const double fan_turns = (beams - 1) * std::abs(step_deg) / 360.0;
    const double turn_s = scan_duration_s / (interlaced_turns - 1 + fan_turns);
    return drivers::beam_time_s(beam, step_deg, interlaced_turns, turn_s);
  }
};

/// Errors of the odometry, by wheels and floor. Signs are drawn once a run.
struct OdometryOptions {
  double rate_hz = 50.0;
  double distance_error = 0.05;  ///< share of the distance
  double turn_error = 0.02;      ///< share of each turn
  double drift_deg_per_m = 1.0;
  double slip_every_m = 20.0;  ///< on average; 0 = never
  double slip_m = 0.15;        ///< distance that the wheels turn while the robot stands
  double slip_turn_deg = 2.0;
  double floor_tilt_deg = 0.2;  ///< largest roll and pitch of the uneven floor

  template <class Visitor>
  void visit(Visitor& v) {
    v("rate_hz", rate_hz, Limits{1.0, 1000.0});
    v("distance_error", distance_error, kNotNegative);
    v("turn_error", turn_error, kNotNegative);
    v("drift_deg_per_m", drift_deg_per_m, kNotNegative);
    v("slip_every_m", slip_every_m, kNotNegative);
    v("slip_m", slip_m, kNotNegative);
    v("slip_turn_deg", slip_turn_deg, kNotNegative);
    v("floor_tilt_deg", floor_tilt_deg, kNotNegative);
  }
};

/// Faults of a laser's driver and of a logger: what they say of scans that were measured right.
/// True poses have the stamp of their scan and the robot's place when it truly began.
struct LoggerOptions {
  double stamp_jitter_s = 0.0;  ///< standard deviation of a scan's stamp
  double stamp_late_s = 0.0;    ///< a scan's stamp after its first beam, by everybody else's clock
  double clock_drift = 0.0;     ///< seconds that the laser's clock gains in one
  double dropped_scans = 0.0;   ///< share
  double burst_part = 0.0;      ///< share logged with the stamp of the scan before
  /// What the recording says of the times of the beams; but for `right`, SENSOR_INFO tells no
  /// duration.
  ///   right         LIDAR_RAW with the time of every beam, and LIDAR
  ///   milliseconds  LIDAR_RAW alone, milliseconds added to utime's microseconds
  ///   reversed      LIDAR_RAW alone: the mirror turns the other way, the last beam comes first
  ///   equal         LIDAR_RAW alone, every beam at utime
  ///   missing       LIDAR alone
  std::string beam_times = "right";

  template <class Visitor>
  void visit(Visitor& v) {
    v("stamp_jitter_s", stamp_jitter_s, kNotNegative);
    v("stamp_late_s", stamp_late_s);
    v("clock_drift", clock_drift, Limits{-0.1, 0.1});
    v("dropped_scans", dropped_scans, Limits{0.0, 0.9});
    v("burst_part", burst_part, Limits{0.0, 0.9});
    v("beam_times", beam_times);
  }
};

/// The robot: speeds, and the pan-tilt of thesis B (laser 45 mm ahead of and 8 mm above the tilt
/// axis).
struct RobotOptions {
  double speed_m_per_s = 0.5;
  double acceleration_m_per_s2 = 0.5;
  double turn_rate_deg_per_s = 60.0;
  double turn_acceleration_deg_per_s2 = 120.0;
  double pantilt_ahead_m = 0.10;
  double tilt_axis_height_m = 0.60;  ///< ours: the thesis gives none
  double laser_ahead_m = 0.045;
  double laser_above_m = 0.008;
  std::vector<double> laser_roll_pitch_yaw_deg = {0, 0, 0};
  std::vector<double> level_laser_m = {};  ///< where a second one is fixed, on LIDAR_LEVEL; or none
  double spin_deg_per_s = 0.0;             ///< the pan turns all the time
  double pantilt_rate_deg_per_s = 45.0;    ///< between sweeps
  double pantilt_state_hz = 100.0;  ///< 0 = no pan-tilt: the laser sits where it would be at rest
  /// Contents of ODOMETRY: `wheels`, `gyro` (the turns alone, without drift and slip), `still` (a
  /// pose that never moves) or `none` (not sent).
  std::string odometry = "wheels";

  template <class Visitor>
  void visit(Visitor& v) {
    v("speed_m_per_s", speed_m_per_s, kPositive);
    v("acceleration_m_per_s2", acceleration_m_per_s2, kPositive);
    v("turn_rate_deg_per_s", turn_rate_deg_per_s, kPositive);
    v("turn_acceleration_deg_per_s2", turn_acceleration_deg_per_s2, kPositive);
    v("pantilt_ahead_m", pantilt_ahead_m);
    v("tilt_axis_height_m", tilt_axis_height_m, kPositive);
    v("laser_ahead_m", laser_ahead_m);
    v("laser_above_m", laser_above_m);
    v("laser_roll_pitch_yaw_deg", laser_roll_pitch_yaw_deg);
    v("level_laser_m", level_laser_m);
    v("spin_deg_per_s", spin_deg_per_s, Limits{-3600.0, 3600.0});
    v("pantilt_rate_deg_per_s", pantilt_rate_deg_per_s, kPositive);
    v("pantilt_state_hz", pantilt_state_hz, Limits{0.0, 1000.0});
    v("odometry", odometry);
  }
};

struct SimulationOptions {
  LaserOptions laser;
  OdometryOptions odometry;
  LoggerOptions logger;
  RobotOptions robot;

  template <class Visitor>
  void visit(Visitor& v) {
    v("laser", laser);
    v("odometry", odometry);
    v("logger", logger);
    v("robot", robot);
  }
};

/// The second preset, modelled on intel.log and fr101.log: ranges in whole centimetres with another
/// 7-12 mm of noise about fitted walls, about 5 scans a second, stamps in pairs, wheels that lose a
/// tenth of a turn.
inline SimulationOptions harsh_options() {
  SimulationOptions options;
  options.laser.range_sigma_m = 0.015;
  options.laser.quantum_m = 0.01;
  options.laser.missing_part = 0.01;
  options.laser.scans_per_s = 5.0;
  options.odometry.distance_error = 0.08;
  options.odometry.turn_error = 0.10;
  options.odometry.drift_deg_per_m = 2.0;
  options.odometry.slip_every_m = 10.0;
  options.odometry.floor_tilt_deg = 0.4;
  options.logger.stamp_jitter_s = 0.01;
  options.logger.dropped_scans = 0.02;
  options.logger.burst_part = 0.3;
  return options;
}

/// The third preset, modelled on recordings of small rovers: a rotating lidar of few, noisy beams
/// and nothing else, on wheels that turn by half a right angle between two scans. The first beam
/// looks ahead, the mirror turns clockwise.
/// @param beams  of a turn: 208 at 5 turns a second, 360 at 7
inline SimulationOptions rover_options(double turns_per_s, int beams) {
  SimulationOptions options;
  options.laser.beams = beams;
  options.laser.first_bearing_deg = 0.0;
  options.laser.step_deg = -360.0 / beams;
  options.laser.scans_per_s = turns_per_s;
  options.laser.interlaced_turns = 1;
  options.laser.scan_duration_s = (beams - 1) / (beams * turns_per_s);
  options.laser.range_min_m = 0.15;
  options.laser.range_max_m = 12.0;
  options.laser.no_return_m = 0.0;
  options.laser.range_sigma_m = 0.022;
  options.laser.missing_part = 0.05;
  options.logger.stamp_jitter_s = 0.02;
  options.logger.stamp_late_s = 0.08;
  options.robot.speed_m_per_s = 0.4;
  options.robot.acceleration_m_per_s2 = 2.0;
  options.robot.turn_rate_deg_per_s = 230.0;
  options.robot.turn_acceleration_deg_per_s2 = 2500.0;
  options.robot.pantilt_ahead_m = 0.0;
  options.robot.tilt_axis_height_m = 0.15;
  options.robot.laser_ahead_m = 0.0;
  options.robot.laser_above_m = 0.0;
  options.robot.pantilt_state_hz = 0.0;
  options.robot.odometry = "none";
  return options;
}

}  // namespace marco::sim
