#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::sim {

/// What can go wrong with a device of the simulated robot.
enum class FaultKind {
  off,           ///< its cable is cut: no bytes pass in either direction
  stuck,         ///< it repeats its last values: a laser's ranges, an IMU's rates; wheels and
                 ///< pan-tilt count but do not move
  garbage,       ///< three of ten bytes it sends are random
  slow,          ///< its bytes arrive half a second late
  wrong,         ///< a constant offset: laser 0.2 m, IMU 3 deg/s, left wheel 10 %, tilt 2 deg
  intermittent,  ///< off for 0.4 s of each second
  unplugged,     ///< its port is gone
};

/// @throws std::invalid_argument naming what is known.
FaultKind fault_kind_named(const std::string& name);
/// The list of `marco-sim --faults`.
std::string describe_faults();

struct FaultSpec {
  std::string device;
  std::string kind = "off";
  double start_s = 0.0;  ///< from the start of the simulator, or from the order's arrival
  double duration_s = 5.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("kind", kind);
    v("start_s", start_s, kNotNegative);
    v("duration_s", duration_s, kPositive);
  }
};

/// A script of faults (`marco-sim --fault-script FILE`).
struct FaultScript {
  std::vector<FaultSpec> faults;

  template <class Visitor>
  void visit(Visitor& v) {
    v("faults", faults);
  }
};

/// Which device has which fault, and when. One thread.
class FaultBoard {
 public:
  explicit FaultBoard(std::vector<std::string> devices = {}) : devices_(std::move(devices)) {}
  void add_device(const std::string& device) { devices_.push_back(device); }

  /// @param now  start_s counts from here. Kind "none" ends all faults of the device.
  /// @throws std::invalid_argument for an unknown device or kind, or invalid times.
  void add(const FaultSpec& spec, Utime now);

  bool has(const std::string& device, FaultKind kind, Utime now) const;
  /// "laser off, imu wrong"; "" without faults.
  std::string state(Utime now) const;

 private:
  struct Fault {
    std::string device;
    FaultKind kind;
    Utime from, until;
  };
  std::vector<std::string> devices_;
  std::vector<Fault> faults_;
};

}  // namespace marco::sim
