#pragma once

#include <optional>
#include <string>

#include "drivers/base/base_driver.hpp"
#include "drivers/base/click_odometry.hpp"
#include "drivers/base/wheel_counters.hpp"
#include "drivers/base/wheel_plan.hpp"
#include "drivers/kobuki/codec.hpp"
#include "drivers/transport/clock_filter.hpp"

namespace marco::drivers::kobuki {

struct KobukiOptions {
  double ticks_per_m = kTicksPerM;
  double track_m = kTrackM;
  BaseSpeeds speeds{0.3, 1.0, 0.3};
  /// Its emulator stops within 0.10 s and the plan's braking; a slower host adds to that.
  GuardOptions guard{.body_m = Footprint::box(0.18, 0.18, 0.18), .delay_s = 0.2};

  template <class Visitor>
  void visit(Visitor& v) {
    v("ticks_per_m", ticks_per_m, kPositive);
    v("track_m", track_m, kPositive);
    v("speeds", speeds);
    v("guard", guard);
  }
};

/// Driver of a Kobuki (TurtleBot 2): odometry and its gyro's rates, on the robot's own clock. The
/// host plans (WheelPlan), and stops it at a cliff or a hanging wheel, which the robot's firmware
/// leaves to its host. Its watchdog is not documented: when this process hangs or dies its guardian
/// stops it; when the cable falls out it may drive on.
class KobukiBase : public BaseDriver {
 public:
  using Options = KobukiOptions;
  static constexpr const char* kDevice = "/dev/ttyUSB0";
  static constexpr int kLineSpeed = kBaud;

  explicit KobukiBase(const KobukiOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  std::vector<uint8_t> stop_bytes() const override;
  BaseDynamics dynamics() const override { return plan_.dynamics(); }
  int64_t bad_input() const override {
    return parser_.garbage_bytes() + undecodable_ + counters_.implausible();
  }

 private:
  void start_leg(const Leg& leg, Utime now) override;
  double leg_remaining() const override { return plan_.leg_remaining(odom_from_robot()); }
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) override;
  void stop_wheels(Utime /*now*/) override { plan_.stop(); }
  void emergency_brake(Utime now) override;
  void speeds_changed() override { plan_.set_speeds(speeds()); }

  void begin_session(Utime now);
  void on_feedback(const Feedback& feedback, Utime left);
  /// Advances the robot's clock. @returns the seconds since the frame before.
  double tell_time(const Feedback& feedback);
  void publish_gyro(const Feedback& feedback, Utime when);
  void judge_bumpers(const Feedback& feedback, Utime now);
  void judge_link(const Feedback& feedback, Utime now);
  static std::string why_unsafe(const Feedback& feedback);
  void send_motion(Utime now, std::vector<uint8_t>& out);

  KobukiOptions options_;
  FrameParser parser_;
  ClickOdometry odometry_;
  WheelCounters counters_;
  WheelPlan plan_;
  ClockFilter clock_;
  double robot_s_ = 0.0;  ///< its clock, without wraps
  bool connected_ = false;
  bool speaks_ = false;  ///< its frames come
  bool frame_came_ = false;
  Utime understood_;  ///< when a frame was, last
  Utime next_ask_, next_motion_;
  std::optional<uint16_t> last_clock_ms_;
  std::string firmware_;
  int64_t undecodable_ = 0;
};

}  // namespace marco::drivers::kobuki
