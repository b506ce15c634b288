#pragma once

#include <optional>

#include "drivers/base/base_driver.hpp"
#include "drivers/p2os/accessories.hpp"
#include "drivers/p2os/codec.hpp"

namespace marco::drivers::p2os {

struct P2osOptions {
  bool sonar = true;
  double sonar_cone_deg = 15.0;
  /// Of a robot that does not tell how many it has (CONFIG). Thesis A's outfit: five ahead and five
  /// behind. 0 = a robot without, whose packets show all of them pressed.
  int bumpers_each_end = 5;
  bool camera_head = false;  ///< a Sony EVI-D30 at the robot's second serial port
  BaseSpeeds speeds{0.3, 0.7, 0.3};
  GuardOptions guard{true, 0.25, 0.30, 0.25};

  template <class Visitor>
  void visit(Visitor& v) {
    v("sonar", sonar);
    v("sonar_cone_deg", sonar_cone_deg, kPositive);
    v("bumpers_each_end", bumpers_each_end, Limits{0, 7});
    v("camera_head", camera_head);
    v("speeds", speeds);
    v("guard", guard);
  }
};

/// Driver of Pioneer robots. Moves are MOVE and DHEAD (whole millimetres and degrees), velocity is
/// VEL and RVEL; odometry is the robot's own, unwrapped. It pulses, so that the robot's watchdog (2
/// s unless its owner set it otherwise) stops it only when this process or the line dies.
class P2osBase : public BaseDriver {
 public:
  explicit P2osBase(const P2osOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  void shut_down(std::vector<uint8_t>& out) override;
  void look(const PanTiltCommand& command, Utime now) override;
  int64_t bad_input() const override { return parser_.bad_checksums() + bad_packets_; }
  const RobotName& name() const { return name_; }

 private:
  void start_leg(const Leg& leg, Utime now) override;
  double leg_remaining() const override;
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) override;
  void stop_wheels(Utime now) override;
  void emergency_brake(Utime now) override;
  void speeds_changed() override;
  double stop_distance_m() const override;

  void on_packet(const Bytes& payload, Utime arrival);
  void on_sync(const Bytes& payload, Utime now);
  void on_sip(const Sip& sip, Utime measured, Utime now);
  void reckon(const Sip& sip, Utime measured);
  void ask_outfit(Utime now);
  bool knows_its_outfit(Utime now);
  std::string outfit_note() const;
  void read_bumpers(const Sip& sip, Utime now);
  void read_sonars(const Sip& sip, Utime now);
  void watch_motion(const Sip& sip, Utime now);
  void restart_sync(Utime now);
  void halt(CommandId how, Utime now);
  void say(CommandId id, std::optional<int> value = std::nullopt);
  void say_to_head(const Bytes& message);
  void ask_head(Utime now);
  void on_head(const Bytes& payload, Utime arrival);

  P2osOptions options_;
  PacketParser parser_;
  Bytes to_send_;
  bool connected_ = false;
  int sync_ = 0;  ///< the SYNC to send next; 3 = open
  RobotName name_;
  std::optional<RobotConfig> config_;  ///< what the robot tells of itself
  int config_asked_ = 0;
  Utime next_config_;
  Utime next_sync_, last_sent_, last_packet_;
  std::optional<Sip> last_sip_;
  Pose2 pose_;
  std::optional<Leg> leg_;
  Pose2 leg_start_;
  double leg_turned_rad_ = 0.0;
  Utime leg_since_;
  int still_ = 0;  ///< packets in a row without motion
  int retries_ = 0;
  bool stop_asked_ = false;
  Utime stop_since_;
  int velocity_mm_per_s_ = 0;
  int rate_deg_per_s_ = 0;
  Utime velocity_sent_;
  SonarRing ring_;
  Utime ring_told_;
  int64_t bad_packets_ = 0;
  Utime next_head_;  ///< when it is asked again where it looks
};

}  // namespace marco::drivers::p2os
