#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "drivers/p2os/accessories.hpp"
#include "drivers/p2os/models.hpp"
#include "drivers/transport/paced_output.hpp"
#include "simulator/devices/p2os/camera_head.hpp"
#include "simulator/devices/p2os/emulated_drive.hpp"
#include "simulator/devices/transport/emulator.hpp"

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
  bool encoders_asked_ = false;  ///< with each information packet, until ordered to stop
  bool ports_asked_ = false;
  uint8_t digital_out_ = 0;
  std::size_t aux_wanted_ = 0;
  CameraHead head_;
};

/// A Pioneer 2 as its serial line shows it: synchronization, information packets each 100 ms,
/// watchdog, baud rate. What the floor makes of its motion is the world's.
class P2osEmulator : public Emulator {
 public:
  explicit P2osEmulator(P2osWorld world = {}, const P2osEmulatorOptions& options = {});
  P2osEmulator(const P2osEmulator&) = delete;
  P2osEmulator& operator=(const P2osEmulator&) = delete;

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  /// The reset button.
  void reset();
  double left_m() const { return drive_.left_m(); }  ///< signed travel of the wheels
  double right_m() const { return drive_.right_m(); }
  const Pose2& reckoned() const { return drive_.reckoned(); }
  bool motors_on() const { return drive_.motors_on(); }
  double velocity_m_per_s() const { return drive_.velocity().speed; }
  double yaw_rate_rad_per_s() const { return drive_.rate().speed; }
  const CameraHead& camera_head() const { return requested_.head(); }

 private:
  void run_until(Utime now);
  void handle(std::span<const uint8_t> payload, Utime now);
  void synchronize(std::span<const uint8_t> payload, const Command& command, Utime now);
  void close();
  void set_host_baud(int code);
  int host_baud_code() const;
  Sip sip();
  void add_sonars(Sip& sip);

  struct Client {
    int sync = 0;  ///< the SYNC expected; 3 = synchronized
    bool open = false;
    bool sonars_on = false;
    Utime last_packet;
  };

  P2osWorld world_;
  P2osEmulatorOptions options_;
  Model model_;  ///< a robot of an unknown name counts as a P2DX does
  PacketParser parser_;
  PacedOutput output_{kBaud};
  int baud_after_sending_ = 0;
  std::optional<Utime> now_;  ///< up to which everything has happened; none before power-on
  Utime next_sip_;
  Client client_;
  EmulatedDrive drive_;
  RequestedPackets requested_;
  std::size_t next_sonar_ = 0;
};

}  // namespace marco::drivers::p2os
