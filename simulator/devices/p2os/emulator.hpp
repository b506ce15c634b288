#pragma once

#include <optional>

#include "drivers/p2os/models.hpp"
#include "drivers/transport/paced_output.hpp"
#include "simulator/devices/p2os/emulated_drive.hpp"
#include "simulator/devices/p2os/requested_packets.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::p2os {

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
