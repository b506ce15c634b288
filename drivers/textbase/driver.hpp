#pragma once

#include <optional>
#include <string>

#include "drivers/base/click_odometry.hpp"
#include "drivers/base/differential_base.hpp"
#include "drivers/textbase/codec.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "drivers/transport/line_cutter.hpp"

namespace marco::drivers::textbase {

/// The wheels' counters and the clock of a board's reports. Both wrap; a clock that goes back is a
/// reset.
class ReportCounter {
 public:
  struct Step {
    bool after_reset = false;  ///< the board was reset: nothing else is given
    bool plausible = true;     ///< false: more ticks than a wheel makes; they do not count
    ClickOdometry::Step clicks;
    Utime measured;  ///< by the board's clock
  };

  explicit ReportCounter(double tick_m) : tick_m_(tick_m) {}

  /// The next report is the first of a session.
  void restart();
  /// @param left  when the report left the board, by its arrival
  Step add(const Report& report, Utime left);

 private:
  double tick_m_;
  ClockFilter clock_{0.02};
  std::optional<Report> last_;
  double board_s_ = 0.0;  ///< the board's clock without wrapping
};

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

/// Driver of home-made bases that speak the text protocol. The board's watchdog stops the wheels
/// half a second after the last order.
class TextBase : public DifferentialBase {
 public:
  using Options = TextBaseOptions;
  static constexpr const char* kDevice = "/dev/ttyACM0";
  static constexpr int kLineSpeed = kBaud;

  /// @throws std::invalid_argument when ticks, wheel or track are not given.
  explicit TextBase(const TextBaseOptions& options);

  void on_connection(bool connected, Utime now) override;
  void receive(std::span<const uint8_t> bytes, Utime now) override;
  std::vector<uint8_t> stop_bytes() const override;
  int64_t bad_input() const override { return bad_lines_ + cutter_.overlong(); }

 private:
  enum class Phase { booting, asking, setting_up, running };
  void keep_link(Utime now, std::vector<uint8_t>& out) override;
  bool takes_speeds() const override { return phase_ == Phase::running; }
  void send_speeds(const WheelSpeeds& speeds, bool due, std::vector<uint8_t>& out) override;

  void start_session(Phase phase, Utime now);
  void on_line(const std::string& line, Utime now);
  void on_hello(const Hello& hello, Utime now);
  void on_report(const Report& report, Utime now);
  void on_complaint(const Complaint& complaint, Utime now);
  void judge(unsigned flags, Utime now);
  void ask(Utime now, std::vector<uint8_t>& out);

  LineCutter cutter_{kMaxLine};
  Phase phase_ = Phase::booting;
  bool refused_ = false;  ///< of another protocol
  bool has_sums_ = false;
  bool watchdog_set_ = false, reports_set_ = false;
  std::string board_;  ///< its name and firmware
  std::string complaint_;
  ReportCounter reports_;
  int64_t bad_lines_ = 0;
};

}  // namespace marco::drivers::textbase
