#pragma once

#include <deque>
#include <functional>

#include "drivers/p2os/accessories.hpp"
#include "drivers/p2os/camera_head.hpp"
#include "drivers/transport/emulator.hpp"
#include "drivers/transport/paced_output.hpp"

namespace marco::drivers::p2os {

/// Touched bumpers and blocked wheels.
struct Touch {
  uint8_t front = 0;  ///< bit i = bumper i, from left to right
  uint8_t rear = 0;
  bool stalled = false;
};

struct P2osWorld {
  std::function<double(std::size_t sonar)> sonar_range_m;  ///< infinity = no echo
  std::function<Touch()> touch;
  std::function<double()> battery_v;
};

struct P2osEmulatorOptions {
  RobotName name{"MARCO", "Pioneer", "P2DX"};
  double track_m = 0.357;  ///< 2 / DiffConvFactor mm
  double cycle_s = 0.1;    ///< of the information packets
  double watchdog_s = 2.0;
  double max_velocity_m_per_s = 2.2;
  double default_velocity_m_per_s = 0.4;
  double default_acceleration_m_per_s2 = 0.3;
  double default_rate_deg_per_s = 50.0;
  double default_rate_acceleration_deg_per_s2 = 100.0;
  int bumpers_each_end = 5;  ///< 0 = none: then its packets show all of them pressed
  bool tells_config = true;  ///< old firmware does not
  int ticks_per_mm = 39;     ///< of the wheel encoders; ours
};

/// A Pioneer 2 as its serial line shows it: sync, motion with trapezoids, information packets each
/// 100 ms, watchdog, stall; what it tells when asked: its settings, encoders, ports; a camera head
/// at its second serial port. Its wheels do what they are told and its own reckoning is exact; what
/// the floor makes of it is the world's.
class P2osEmulator : public Emulator {
 public:
  explicit P2osEmulator(P2osWorld world = {}, const P2osEmulatorOptions& options = {});

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

  /// The reset button.
  void reset();
  double left_m() const { return left_m_; }  ///< signed travel of the wheels
  double right_m() const { return right_m_; }
  const Pose2& reckoned() const { return reckoned_; }
  bool motors_on() const { return motors_on_; }
  double velocity_m_per_s() const { return velocity_; }
  double yaw_rate_rad_per_s() const { return rate_; }
  const CameraHead& camera_head() const { return head_; }

 private:
  void run_until(Utime now);
  void move(double dt_s);
  void handle(std::span<const uint8_t> payload, Utime now);
  void obey(const Command& command);
  void set_limit(const Command& command);
  bool answer(const Command& command, Utime now);
  void set_host_baud(int code);
  void send_asked(Utime now);
  RobotConfig config() const;
  Encoders encoders() const;
  IoPorts ports() const;
  void send(const Bytes& packet, Utime now) { output_.send(packet, now); }
  Sip sip();
  Touch touch() const;
  double wanted_velocity() const;
  double wanted_rate() const;

  P2osWorld world_;
  P2osEmulatorOptions options_;
  const Model& model_;
  PacketParser parser_;
  PacedOutput output_{kBaud};
  Utime now_, next_sip_, last_packet_;
  bool started_ = false;
  int sync_ = 0;  ///< the SYNC expected; 3 = synchronized
  bool open_ = false;
  bool motors_on_ = false;
  bool sonars_on_ = false;
  bool stalled_ = false;
  double max_velocity_, max_rate_, acceleration_, rate_acceleration_;
  double deceleration_, rate_deceleration_;
  double velocity_ = 0.0, rate_ = 0.0;
  double velocity_goal_ = 0.0, rate_goal_ = 0.0;
  std::optional<double> way_left_m_;    ///< of MOVE, signed
  std::optional<double> heading_goal_;  ///< of HEAD and DHEAD
  double left_m_ = 0.0, right_m_ = 0.0;
  Pose2 reckoned_;  ///< since SETO
  std::size_t next_sonar_ = 0;
  int baud_ = kBaud;
  int baud_after_sending_ = 0;
  bool encoders_asked_ = false;  ///< with each information packet, until told to stop
  bool ports_asked_ = false;
  uint8_t digital_out_ = 0;
  std::size_t aux_wanted_ = 0;
  CameraHead head_;
};

}  // namespace marco::drivers::p2os
