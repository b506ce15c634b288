#pragma once

#include <string>

#include "drivers/base/base_driver.hpp"
#include "drivers/base/wheel_plan.hpp"
#include "drivers/textbase/report_odometry.hpp"
#include "drivers/transport/line_cutter.hpp"

namespace marco::drivers::textbase {

struct TextBaseOptions {
  double ticks_per_turn = 0.0;    ///< of a wheel; no default: count them
  double wheel_diameter_m = 0.0;  ///< no default
  double track_m = 0.0;           ///< between the wheels' middles; no default
  BaseSpeeds speeds{0.3, 1.0, 0.3};
  /// The emulated board stops within 0.11 s and the plan's braking; nobody knows how soon yours
  /// does.
  GuardOptions guard{.body_m = Footprint::box(0.15, 0.15, 0.12), .delay_s = 0.3};

  template <class Visitor>
  void visit(Visitor& v) {
    v("ticks_per_turn", ticks_per_turn, kNotNegative);
    v("wheel_diameter_m", wheel_diameter_m, kNotNegative);
    v("track_m", track_m, kNotNegative);
    v("speeds", speeds);
    v("guard", guard);
  }
};

/// Driver of home-made bases that speak the text protocol. The host plans: moves and turns are
/// speeds that follow a trapezoid, closed by the wheels' ticks. The board's watchdog stops the
/// wheels half a second after the last order.
class TextBase : public BaseDriver {
 public:
  using Options = TextBaseOptions;
  static constexpr const char* kDevice = "/dev/ttyACM0";
  static constexpr int kLineSpeed = kBaud;

  /// @throws std::invalid_argument when ticks, wheel or track are not given.
  explicit TextBase(const TextBaseOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  std::vector<uint8_t> stop_bytes() const override;
  BaseDynamics dynamics() const override { return plan_.dynamics(); }
  int64_t bad_input() const override { return bad_lines_ + cutter_.overlong(); }

 private:
  enum class Phase { booting, asking, setting_up, running };
  void start_leg(const Leg& leg, Utime now) override;
  double leg_remaining() const override;
  void drive(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) override;
  void stop_wheels(Utime now) override;
  void emergency_brake(Utime now) override;
  void speeds_changed() override;

  void begin_session(Phase phase, Utime now);
  void on_line(const std::string& line, Utime now);
  void on_hello(const Hello& hello, Utime now);
  void on_report(const Report& report, Utime now);
  void on_complaint(const Complaint& complaint, Utime now);
  void judge_link(unsigned flags, Utime now);
  void ask(Utime now, std::vector<uint8_t>& out);
  void send_motion(Utime now, std::vector<uint8_t>& out);
  Motion wheel_speeds() const;
  double tick_m() const;

  TextBaseOptions options_;
  LineCutter cutter_{kMaxLine};
  Phase phase_ = Phase::booting;
  bool connected_ = false;
  bool refused_ = false;  ///< of another protocol
  bool has_sums_ = false;
  bool watchdog_set_ = false, reports_set_ = false;
  Utime next_ask_;
  Utime understood_;  ///< when a line was, last
  Utime next_motion_;
  std::string board_;  ///< its name and firmware
  std::string complaint_;

  ReportOdometry odometry_;

  WheelPlan plan_;
  int64_t bad_lines_ = 0;
};

}  // namespace marco::drivers::textbase
