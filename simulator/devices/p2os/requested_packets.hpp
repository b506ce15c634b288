#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "drivers/p2os/accessories.hpp"
#include "simulator/devices/p2os/camera_head.hpp"
#include "simulator/devices/p2os/emulated_drive.hpp"

namespace marco::drivers::p2os {

/// Touched bumpers and blocked wheels.
struct Touch {
  uint8_t front = 0;  ///< bit i = bumper i, from left to right
  uint8_t rear = 0;
  bool stalled = false;
};

struct P2osWorld {
  std::function<double(const Pose2& robot_from_sonar)> sonar_range_m;  ///< infinity = no echo
  std::function<Touch()> touch;
  std::function<double()> battery_v;

  double volts() const { return battery_v ? battery_v() : 12.6; }
  /// A robot without bumpers shows all of them pressed.
  Touch touched(int bumpers_each_end) const;
};

/// The emulated robot's answers: packets sent only on request, and the camera head at its second
/// serial port.
class RequestedPackets {
 public:
  /// All outlive it.
  RequestedPackets(const P2osWorld& world,
                   const P2osEmulatorOptions& options,
                   const EmulatedDrive& drive)
      : world_(world), options_(options), drive_(drive) {}

  /// Power-on state; the head has a supply of its own.
  void reset();
  void stop_repeating() { encoders_asked_ = ports_asked_ = false; }
  /// @returns nothing for a command of another kind; else the packet to send, which may be empty.
  std::optional<Bytes> answer(const Command& command, int host_baud_code, Utime now);
  /// What is sent after each information packet.
  std::vector<Bytes> repeated();

  CameraHead& head() { return head_; }
  const CameraHead& head() const { return head_; }
  uint8_t digital_out() const { return digital_out_; }

 private:
  RobotConfig config(int host_baud_code) const;
  Encoders encoders() const;
  IoPorts ports() const;

  const P2osWorld& world_;
  const P2osEmulatorOptions& options_;
  const EmulatedDrive& drive_;
  bool encoders_asked_ = false;  ///< with each information packet, until told to stop
  bool ports_asked_ = false;
  uint8_t digital_out_ = 0;
  std::size_t aux_wanted_ = 0;
  CameraHead head_;
};

}  // namespace marco::drivers::p2os
