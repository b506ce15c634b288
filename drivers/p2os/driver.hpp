#pragma once

#include <optional>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "drivers/base/base_driver.hpp"
#include "drivers/p2os/accessories.hpp"
#include "drivers/p2os/codec.hpp"
#include "drivers/p2os/models.hpp"
#include "drivers/p2os/session.hpp"

namespace marco::drivers::p2os {

/// The driver's side of a camera head at the robot's second serial port: packets for the robot,
/// which passes them on.
class HeadClient {
 public:
  Bytes power_on(Utime now);
  Bytes look(const PanTiltCommand& command, Utime now);
  /// The question for the angles, when it is due; else empty.
  Bytes ask(Utime now);
  /// @param payload of a packet AUX. @returns nothing for anything but the answer.
  static std::optional<PanTiltState> decode(std::span<const uint8_t> payload, Utime arrival);

 private:
  Utime next_ask_;
};

/// The robot's own dead reckoning, unwrapped: steps between information packets, appended to one
/// path. Where the robot's origin is set again, nothing moves here.
class SipOdometry {
 public:
  OdometrySample add(const Sip& sip, const Model& model, Utime measured);
  /// The next packet is the first of a session.
  void restart() { last_.reset(); }

  void begin_leg();
  /// Since begin_leg(): straight on, and turned with all whole turns.
  double moved_m() const { return between(leg_start_, odom_from_robot_).x_m; }
  double turned_rad() const { return turned_rad_; }

 private:
  std::optional<Sip> last_;
  Pose2 odom_from_robot_;
  Pose2 leg_start_;
  double turned_rad_ = 0.0;
};

/// Collects the readings of information packets, a few at a time, to rings of all its sonars.
class SonarCollector {
 public:
  explicit SonarCollector(double cone_rad) { ring_.cone_rad = cone_rad; }

  /// Before the first packet.
  void fit(const Model& model);
  /// @returns the ring each 0.4 s, or 0.8 s of more than sixteen; never one without sonars.
  std::optional<SonarRing> add(const Sip& sip, Utime now);
  /// The host's clock may have been set back.
  void forget_stamps() { last_ring_ = {}; }

 private:
  SonarRing ring_;
  std::vector<std::optional<std::size_t>> reading_of_;  ///< by the sonar's number
  double m_per_range_ = 0.0;
  Utime last_ring_;
};

struct P2osOptions {
  bool sonar = true;
  double sonar_cone_deg = 15.0;
  /// For a robot that does not report how many it has (CONFIG). Thesis A's robot has five in front
  /// and five behind. 0 = none: the packets of such a robot show all of them pressed.
  int bumpers_each_end = 5;
  bool camera_head = false;  ///< a Sony EVI-D30 at the robot's second serial port
  /// Units of a robot whose subtype is not known, or has been changed: DistConvFactor,
  /// RangeConvFactor and DiffConvFactor of its parameter file. 0 = the subtype's; all or none.
  /// Where the sonars of an unknown one sit nobody knows: they are not used.
  double mm_per_distance = 0.0;
  double mm_per_range = 0.0;
  double rad_per_mm_per_s = 0.0;
  BaseSpeeds speeds{0.3, 0.7, 0.3};
  /// Its emulator stops within 0.17 s (a cycle of its packets, and the line) and the ordered
  /// braking.
  GuardOptions guard{.body_m = Footprint::box(0.25, 0.30, 0.25), .delay_s = 0.25};

  template <class Visitor>
  void visit(Visitor& v) {
    v("sonar", sonar);
    v("sonar_cone_deg", sonar_cone_deg, kPositive);
    v("bumpers_each_end", bumpers_each_end, Limits{0, 7});
    v("camera_head", camera_head);
    v("mm_per_distance", mm_per_distance, kNotNegative);
    v("mm_per_range", mm_per_range, kNotNegative);
    v("rad_per_mm_per_s", rad_per_mm_per_s, kNotNegative);
    v("speeds", speeds);
    v("guard", guard);
  }
};

/// Driver of Pioneer robots. Moves are MOVE and DHEAD (whole millimetres and degrees), velocity is
/// VEL and RVEL; odometry is the robot's own, unwrapped. It pulses, so that the robot's watchdog (2
/// s unless its owner set it otherwise) stops it only when this process or the line dies.
class P2osBase : public BaseDriver {
 public:
  using Options = P2osOptions;
  static constexpr const char* kDevice = "/dev/ttyS0";
  static constexpr int kLineSpeed = kBaud;

  explicit P2osBase(const P2osOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  std::vector<uint8_t> stop_bytes() const override;
  void shut_down(std::vector<uint8_t>& out) override { session_.shut_down(out); }
  void look(const PanTiltCommand& command, Utime now) override;
  std::optional<int> take_line_speed() override { return session_.take_line_speed(); }
  BaseDynamics dynamics() const override;
  int64_t bad_input() const override { return session_.bad_packets(); }
  const RobotName& name() const { return session_.name(); }

 private:
  void start_leg(const Leg& leg, Utime now) override;
  double leg_remaining() const override;
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) override;
  void stop_wheels(Utime now) override { halt(CommandId::stop, now); }
  void emergency_brake(Utime now) override { halt(CommandId::emergency_stop, now); }
  void speeds_changed() override;

  void restart_session(Utime now);
  void set_up(Utime now);
  void on_packet(const Bytes& payload, Utime arrival);
  void on_other_packet(const Bytes& payload, Utime arrival);
  /// What its units mean; nothing where nobody says.
  std::optional<Model> model() const;
  void on_sip(const Sip& sip, Utime measured, Utime now);
  void ask_outfit(Utime now);
  void read_bumpers(const Sip& sip, Utime now);
  void watch_motion(const Sip& sip, Utime now);
  void watch_stop(Utime now);
  void halt(CommandId how, Utime now);

  struct SentVelocity {
    int mm_per_s = 0;
    int deg_per_s = 0;
    Utime when;
  };

  P2osOptions options_;
  Session session_;
  Outfit outfit_;
  SipOdometry odometry_;
  std::optional<Model> model_;  ///< of the robot that named itself
  SonarCollector sonars_;
  HeadClient head_;
  std::optional<Leg> leg_;
  Utime leg_since_;
  int retries_ = 0;
  int still_ = 0;                  ///< packets in a row without motion
  std::optional<Utime> stopping_;  ///< since when
  SentVelocity sent_velocity_;
};

}  // namespace marco::drivers::p2os
