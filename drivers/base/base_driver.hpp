#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "drivers/base/obstacle_guard.hpp"
#include "drivers/base/order_gate.hpp"

namespace marco::drivers {

/// What a base driver has to tell since it was last asked.
struct BaseOutput {
  std::vector<OdometrySample> odometry;
  std::vector<BaseStatus> status;
  std::vector<SonarRing> sonar;
  std::vector<PanTiltState> head;
};

/// How fast moves and turns go unless ordered otherwise.
struct BaseSpeeds {
  double velocity_m_per_s = 0.4;
  double yaw_rate_rad_per_s = 0.8;
  double acceleration_m_per_s2 = 0.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v("velocity_m_per_s", velocity_m_per_s, kPositive);
    v("yaw_rate_rad_per_s", yaw_rate_rad_per_s, kPositive);
    v("acceleration_m_per_s2", acceleration_m_per_s2, kPositive);
  }
};

/// A base as its driver process sees it, without port or clock: bytes in, bytes out, stepped by
/// whoever has both. Here is what all bases do alike: the fate of orders, the emergency stop, the
/// guard, the end of a velocity that nobody repeats (kOrderHoldsS). What a base does in its own way
/// is in the private virtuals.
class BaseDriver {
 public:
  BaseDriver(std::string name, const BaseSpeeds& speeds, const GuardOptions& guard);
  virtual ~BaseDriver() = default;

  /// The line was opened or lost. A lost one ends the running order; nothing is taken up again.
  virtual void on_connection(bool connected, Utime now) = 0;
  virtual void receive(std::span<const uint8_t> bytes, Utime now) = 0;
  /// Call every few milliseconds. Appends what is to be sent.
  virtual void advance(Utime now, std::vector<uint8_t>& out) = 0;
  /// Appends what leaves the motors off, whatever else was going on.
  virtual void shut_down(std::vector<uint8_t>& out) = 0;
  /// Bytes or lines that were not understood or believed.
  virtual int64_t bad_input() const = 0;

  /// An order that is refused changes nothing of what the base does.
  void command(const BaseCommand& command, Utime now);
  /// Stops at once and refuses to move until a release comes.
  void emergency_stop(const EmergencyStop& message, Utime now);
  /// For a camera's pan-tilt on the base's own line; a base that carries none passes it over.
  virtual void look(const PanTiltCommand& /*command*/, Utime /*now*/) {}
  ObstacleGuard& guard() { return guard_; }
  BaseOutput take_output();
  /// Odometry as of now, prediction included.
  const Pose2& odom_from_robot() const { return odom_from_robot_; }
  /// One line for a person.
  std::string state() const;
  /// As told to the others: the note begins with the emergency stop's while one is latched.
  BaseStatus status() const;

 protected:
  struct Leg {
    enum class Kind { move, turn };
    Kind kind = Kind::move;
    double amount = 0.0;  ///< m or rad, signed
  };

  /// The derived class calls these.
  void set_link(BaseStatus::Link link, const std::string& note, Utime now);
  void advance_motion(Utime now);
  void leg_ended(bool reached, const std::string& note, Utime now);
  void stopped(Utime now);
  void publish_odometry(const OdometrySample& sample);
  void tell(Utime now);
  BaseStatus& edit_status() { return status_; }
  BaseOutput& output() { return output_; }
  const BaseSpeeds& speeds() const { return speeds_; }
  bool idle() const { return mode_ == Mode::idle; }

 private:
  enum class Mode { idle, leg_due, leg, velocity, stopping };

  /// Sets off. The base is at rest.
  virtual void start_leg(const Leg& leg, Utime now) = 0;
  /// What is left of the leg, signed.
  virtual double leg_remaining() const = 0;
  /// Keeps this velocity until told otherwise; called at each step.
  virtual void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) = 0;
  /// Stops the wheels, then calls stopped().
  virtual void stop_wheels(Utime now) = 0;
  /// The same, as hard as the base can.
  virtual void emergency_brake(Utime now) { stop_wheels(now); }
  virtual void speeds_changed() {}
  /// What a move needs to come to rest from its top speed when it is stopped now.
  virtual double stop_distance_m() const = 0;

  void begin(const BaseCommand& command, Utime now);
  void begin_leg(Utime now);
  void watch_leg(Utime now);
  void watch_velocity(Utime now);
  void request_stop(BaseStatus::Command fate, const std::string& note, Utime now);
  void refuse(const BaseCommand& command, const std::string& why, Utime now);
  void finish(BaseStatus::Command fate, const std::string& note, Utime now);
  double free_part(const Leg& leg, Utime now) const;
  std::string what_is_in_the_way() const;

  BaseSpeeds speeds_;
  ObstacleGuard guard_;
  OrderGate gate_;
  BaseStatus status_;
  BaseOutput output_;
  Pose2 odom_from_robot_;
  Mode mode_ = Mode::idle;
  BaseCommand order_;
  std::optional<BaseCommand> next_order_;
  Leg leg_;
  bool first_leg_ = true;
  bool leg_limited_ = false;
  bool point_to_reach_ = false;
  Utime order_came_;  ///< the newest that was taken
  BaseStatus::Command fate_after_stop_ = BaseStatus::Command::none;
  std::string note_after_stop_;
  Utime last_told_;
};

}  // namespace marco::drivers
