#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/base/robot_spec.hpp"
#include "drivers/hcs12/base_emulator.hpp"
#include "drivers/hcs12/pantilt_emulator.hpp"
#include "drivers/imu/emulator.hpp"
#include "drivers/laser/laser_world.hpp"
#include "drivers/transport/emulator.hpp"
#include "simulator/laser_model.hpp"
#include "simulator/live/faults.hpp"
#include "simulator/live/floor_motion.hpp"

namespace marco::sim {

/// A robot whose devices are emulators in one simulated world: it stands where the emulated wheels
/// brought it, its lasers measure from there, beam by beam, pan-tilt included. It has no clock: the
/// devices are stepped by whoever runs their ports (or a test), update() follows.
class LiveRobot {
 public:
  /// @param rays outlives the robot. @throws std::invalid_argument for a spec that makes no sense.
  LiveRobot(const RayCaster& rays, const RobotSpec& spec, const Pose2& start, uint64_t seed);
  ~LiveRobot();

  struct Device {
    std::string port;  ///< "base", "pantilt", "laser" ...
    drivers::Emulator* emulator = nullptr;
    int tcp_port = -1;  ///< below 0: a pseudo-terminal
  };
  /// In the order in which they must be stepped: what moves before what looks.
  const std::vector<Device>& devices() const { return devices_; }

  /// Takes over what the wheels and the pan-tilt did since the last call.
  void update(Utime now);

  const Pose2& world_from_robot() const { return floor_.world_from_robot(); }
  const Contact& contact() const { return floor_.contact(); }
  MotionHistory::Moment at(Utime when) const { return history_.at(when); }

  /// What goes wrong with which device; its devices' names are those of devices().
  FaultBoard& faults() { return faults_; }

 private:
  struct Laser;

  void add_device(const std::string& port,
                  std::unique_ptr<drivers::Emulator> emulator,
                  int tcp_port = -1);
  void add_base();
  void add_hcs12();
  void add_p2os();
  void add_pantilt();
  void add_laser(const LiveLaserSpec& spec);
  void add_imu();
  std::unique_ptr<drivers::Emulator> laser_emulator(const LiveLaserSpec& spec,
                                                    const drivers::LaserWorld& world) const;
  std::vector<double> sweep(Laser& laser, const drivers::LaserSweep& sweep);
  double sonar_range_m(const Pose2& robot_from_sonar) const;
  Pose3 world_from_laser(const Laser& laser, Utime when) const;

  const RayCaster& rays_;
  RobotSpec spec_;
  FaultBoard faults_;
  FloorMotion floor_;
  MotionHistory history_;
  std::mt19937_64 random_;
  std::vector<std::unique_ptr<drivers::Emulator>> emulators_;
  std::vector<std::unique_ptr<Laser>> lasers_;
  std::vector<Device> devices_;
  std::function<double()> left_m_;  ///< what the wheels have rolled
  std::function<double()> right_m_;
  double left_rolled_m_ = 0.0;
  double right_rolled_m_ = 0.0;
  drivers::hcs12::PanTiltEmulator* pantilt_ = nullptr;
  double stuck_pan_rad_ = 0.0;  ///< as last seen
  double stuck_tilt_rad_ = 0.0;
  drivers::imu::Motion last_felt_;
  Utime now_;
};

}  // namespace marco::sim
