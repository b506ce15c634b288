#pragma once

#include <optional>
#include <string>

#include "drivers/base/differential_base.hpp"
#include "drivers/base/wheel_counters.hpp"
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

/// Driver of a Kobuki (TurtleBot 2): odometry and its gyro's rates, on the robot's own clock. It
/// stops the robot at a cliff or a hanging wheel, which the firmware leaves to its host. Its
/// watchdog is not documented: when this process hangs or dies its guardian stops it; when the
/// cable falls out it may drive on.
class KobukiBase : public DifferentialBase {
 public:
  using Options = KobukiOptions;
  static constexpr const char* kDevice = "/dev/ttyUSB0";
  static constexpr int kLineSpeed = kBaud;

  explicit KobukiBase(const KobukiOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  std::vector<uint8_t> stop_bytes() const override;
  int64_t bad_input() const override {
    return parser_.garbage_bytes() + undecodable_ + counters_.implausible();
  }

 private:
  void keep_link(Utime now, std::vector<uint8_t>& out) override;
  bool takes_speeds() const override { return speaks_; }
  void send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>& out) override;

  void start_session(Utime now);
  void on_feedback(const Feedback& feedback, Utime left);
  void count(const Feedback& feedback, Utime left);
  /// Advances the robot's clock. @returns the seconds since the frame before.
  double tell_time(const Feedback& feedback);
  void publish_gyro(const Feedback& feedback, Utime when);
  void judge(const Feedback& feedback, Utime now);
  static std::string why_unsafe(const Feedback& feedback);

  FrameParser parser_;
  WheelCounters counters_;
  ClockFilter clock_;
  double robot_s_ = 0.0;  ///< its clock, without wraps
  bool speaks_ = false;   ///< its frames come
  bool frame_came_ = false;
  std::optional<uint16_t> last_clock_ms_;
  std::string firmware_;
  int64_t undecodable_ = 0;
};

}  // namespace marco::drivers::kobuki
