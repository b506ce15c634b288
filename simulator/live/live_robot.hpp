#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"
#include "simulator/devices/hcs12/pantilt_emulator.hpp"
#include "simulator/devices/imu/emulator.hpp"
#include "simulator/devices/transport/emulator.hpp"
#include "simulator/live/faults.hpp"
#include "simulator/live/floor_motion.hpp"
#include "simulator/live/live_laser.hpp"
#include "simulator/live/robot_spec.hpp"

namespace marco::sim {

/// The poses of the robot and its pan-tilt during the last second.
class MotionHistory {
 public:
  struct Moment {
    Utime when;
    Pose2 world_from_robot;
    double pan_rad = 0.0;
    double tilt_rad = 0.0;
  };
  void add(const Moment& moment);
  /// Interpolated; outside the known time the nearest end.
  Moment at(Utime when) const;

 private:
  std::deque<Moment> moments_;
};

/// Where the robot's pan-tilt really points, with the faults `wrong` and `stuck`.
class LivePanTilt {
 public:
  /// @param board, faults  outlive it.
  LivePanTilt(const LivePanTiltSpec& spec,
              const drivers::hcs12::PanTiltEmulator& board,
              const FaultBoard& faults)
      : spec_(spec), board_(board), faults_(faults) {}

  static drivers::hcs12::PanTiltEmulatorOptions board_options(const LivePanTiltSpec& spec);
  /// Sets the angles of a moment.
  void look(MotionHistory::Moment& moment);

 private:
  LivePanTiltSpec spec_;
  const drivers::hcs12::PanTiltEmulator& board_;
  const FaultBoard& faults_;
  double last_pan_rad_ = 0.0;
  double last_tilt_rad_ = 0.0;
};

/// A robot whose devices are emulators in one simulated world. It stands where the emulated wheels
/// took it; its lasers measure from there, beam by beam, pan-tilt included. It has no clock: the
/// caller runs the devices' ports, steps the devices, then calls update().
class LiveRobot {
 public:
  /// @param rays outlives the robot. @throws std::invalid_argument for an invalid spec.
  LiveRobot(const RayCaster& rays, const RobotSpec& spec, const Pose2& start, uint64_t seed);

  struct Device {
    std::string port;  ///< "base", "pantilt", "laser" ...
    drivers::Emulator* emulator = nullptr;
    int tcp_port = -1;  ///< below 0: a pseudo-terminal
  };
  /// In the order in which they must be stepped: those that move before those that measure.
  const std::vector<Device>& devices() const { return devices_; }

  /// Moves the robot by what wheels and pan-tilt did since the last call.
  void update(Utime now);

  const Pose2& world_from_robot() const { return floor_.world_from_robot(); }
  const Contact& contact() const { return floor_.contact(); }
  MotionHistory::Moment at(Utime when) const { return history_.at(when); }

  /// The faults of the devices, named as in devices().
  FaultBoard& faults() { return faults_; }

 private:
  /// How far the wheels have rolled.
  struct Wheels {
    std::function<double()> left_m;
    std::function<double()> right_m;
    double last_left_m = 0.0;
    double last_right_m = 0.0;
  };

  void add_device(const std::string& port,
                  std::unique_ptr<drivers::Emulator> emulator,
                  int tcp_port = -1);
  void add_base();
  void add_hcs12();
  void add_p2os();
  void add_text();
  void add_create();
  void add_kobuki();
  void add_pantilt();
  void add_laser(const LiveLaserSpec& spec, uint64_t seed);
  void add_imu();
  drivers::imu::Motion motion_felt(Utime when);
  double sonar_range_m(const Pose2& robot_from_sonar) const;
  Pose3 world_from_laser(const SensorInfo& laser, Utime when) const;

  const RayCaster& rays_;
  RobotSpec spec_;
  FaultBoard faults_;
  FloorMotion floor_;
  MotionHistory history_;
  std::vector<std::unique_ptr<drivers::Emulator>> emulators_;
  std::vector<Device> devices_;
  Wheels wheels_;
  std::optional<LivePanTilt> pantilt_;
  std::vector<std::unique_ptr<LiveLaser>> lasers_;
  drivers::imu::Motion last_felt_;
  Utime now_;
};

}  // namespace marco::sim
