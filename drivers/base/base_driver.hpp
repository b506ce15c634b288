#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "drivers/base/obstacle_guard.hpp"
#include "drivers/base/order_gate.hpp"

namespace marco::drivers {

/// What a base driver has produced since it was last asked.
struct BaseOutput {
  std::vector<OdometrySample> odometry;
  std::vector<BaseStatus> status;
  std::vector<SonarRing> sonar;
  std::vector<PanTiltState> head;
  std::vector<ImuSample> imu;  ///< of a gyro on the base's own line
};

/// Speeds of moves and turns, unless an order sets others.
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

/// Driver of a base without port or clock: bytes in, bytes out, stepped by its process or a test.
/// This class holds what all bases share: the life of an order, the emergency stop, the obstacle
/// guard, and the timeout of a velocity that nobody repeats (kOrderHoldsS). A derived class
/// implements the private virtuals for its protocol.
class BaseDriver {
 public:
  /// A straight move or a turn on the spot.
  struct Leg {
    enum class Kind { move, turn };
    Kind kind = Kind::move;
    double amount = 0.0;  ///< m or rad, signed
  };

  BaseDriver(std::string name, const BaseSpeeds& speeds, const GuardOptions& guard);
  virtual ~BaseDriver() = default;

  /// The line was opened or lost. A lost line aborts the running order; nothing resumes later.
  virtual void on_connection(bool connected, Utime now) = 0;
  virtual void receive(std::span<const uint8_t> bytes, Utime now) = 0;
  /// Call every few milliseconds. Appends what is to be sent.
  virtual void advance(Utime now, std::vector<uint8_t>& out) = 0;
  /// What stops the wheels at once and leaves the link as it is, also behind a packet that was sent
  /// in part. Its guardian sends it.
  virtual std::vector<uint8_t> stop_bytes() const = 0;
  /// Appends the commands that switch the motors off.
  virtual void shut_down(std::vector<uint8_t>& out);
  /// The speed that the line shall have from now on; nothing: as it is. Asked before advance().
  virtual std::optional<int> take_line_speed() { return std::nullopt; }
  /// Bytes or lines that could not be decoded or were implausible.
  virtual int64_t bad_input() const = 0;

  /// A refused order does not affect the running one.
  void command(const BaseCommand& command, Utime now);
  /// Stops at once and refuses to move until a release comes.
  void emergency_stop(const EmergencyStop& message, Utime now);
  /// The process stood still, and its guardian has stopped the wheels: aborts the running order.
  void on_hang(double seconds, Utime now);
  /// For a camera's pan-tilt on the base's own line; a base without one ignores it.
  virtual void look(const PanTiltCommand& /*command*/, Utime /*now*/) {}
  ObstacleGuard& guard() { return guard_; }
  BaseOutput take_output();
  /// Odometry as of now, prediction included.
  const Pose2& odom_from_robot() const { return odom_from_robot_; }
  /// One line for a person.
  std::string state() const;
  /// How the wheels follow an order.
  virtual BaseDynamics dynamics() const = 0;
  /// As published: while an emergency stop is latched, the note begins with it; it ends with what
  /// the guard has to say (kGuardNote).
  BaseStatus status() const;

 protected:
  /// The derived class calls these.
  void set_link(BaseStatus::Link link, const std::string& note, Utime now);
  void advance_motion(Utime now);
  void leg_ended(bool reached, const std::string& note, Utime now);
  void stopped(Utime now);
  void publish_odometry(const OdometrySample& sample);
  void tell(Utime now);
  BaseStatus& edit_status() { return status_; }
  BaseOutput& output() { return output_; }
  /// As ordered, and no faster than the guard lets a leg go.
  BaseSpeeds speeds() const;
  bool idle() const { return mode_ == Mode::idle; }

 private:
  enum class Mode { idle, leg_due, leg, velocity, stopping };

  /// Starts a leg. The base is at rest.
  virtual void start_leg(const Leg& leg, Utime now) = 0;
  /// The rest of the leg, signed.
  virtual double leg_remaining() const = 0;
  /// Drives at this velocity until the next call; called at each step.
  virtual void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) = 0;
  /// Stops the wheels, then calls stopped().
  virtual void stop_wheels(Utime now) = 0;
  /// The same, as hard as the base can.
  virtual void emergency_brake(Utime now) { stop_wheels(now); }
  virtual void speeds_changed() {}
  /// What drive() makes of a velocity: not every base drives every arc.
  virtual BaseVelocity as_driven(const BaseVelocity& order) const { return order; }

  struct RunningOrder {
    BaseCommand command;
    Utime newest_came;  ///< the last order that was accepted
  };
  /// The running order as legs.
  struct Journey {
    Leg leg;
    bool on_first_leg = true;
    std::string limited = {};    ///< why the leg was shortened before it began; "" = it was not
    bool then_to_point = false;  ///< it turns towards a point; the move follows
  };
  struct Ending {
    BaseStatus::Command fate = BaseStatus::Command::none;
    std::string note;
  };

  void begin(const BaseCommand& command, Utime now);
  void begin_leg(Utime now);
  void watch_leg(Utime now);
  void watch_velocity(Utime now);
  void watch_sensors(Utime now);
  std::string why_held(const BaseCommand& command, Utime now);
  bool judgement_is_due(Utime now);
  void limit_legs(double m_per_s);
  ObstacleGuard::Drive drive_of() const;
  void request_stop(BaseStatus::Command fate, const std::string& note, Utime now);
  void brake(const std::string& note, Utime now);
  /// To an order that does not change the running one.
  void answer(const BaseCommand& command,
              BaseStatus::Command fate,
              const std::string& note,
              Utime now);
  void finish(BaseStatus::Command fate, const std::string& note, Utime now);

  BaseSpeeds speeds_;
  ObstacleGuard guard_;
  OrderGate gate_;
  BaseStatus status_;
  BaseOutput output_;
  Pose2 odom_from_robot_;
  Mode mode_ = Mode::idle;
  RunningOrder order_;
  std::optional<BaseCommand> next_order_;
  Journey journey_;
  /// Velocities that come without a pause are one order, even while they are refused.
  struct Stream {
    Utime came;         ///< the last of them
    bool held = false;  ///< a sensor fell silent meanwhile: it needs a new one
  };
  Ending after_stop_;
  Stream stream_;
  ObstacleGuard::Verdict verdict_;
  double leg_limit_m_per_s_ = std::numeric_limits<double>::infinity();
  Utime judged_, last_told_;
};

}  // namespace marco::drivers
