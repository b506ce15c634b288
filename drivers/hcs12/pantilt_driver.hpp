#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "drivers/hcs12/codec.hpp"
#include "drivers/hcs12/line_exchange.hpp"
#include "drivers/hcs12/ramp.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco::drivers::hcs12 {

/// One axis: a unit is a turn of its motor. Thesis B gives the spans, not the outer gears.
struct PanTiltAxisOptions {
  double deg_per_unit = 1.0;
  double home_deg = 0.0;  ///< where the axis looks at unit 0
  int limit_units = 100;
  double rate_deg_per_s = 12.0;  ///< unless ordered otherwise

  template <class Visitor>
  void visit(Visitor& v) {
    v("deg_per_unit", deg_per_unit);
    v("home_deg", home_deg);
    v("limit_units", limit_units, Limits{1, 254});
    v("rate_deg_per_s", rate_deg_per_s, kPositive);
  }
};

struct PanTiltOptions {
  PanTiltAxisOptions pan{360.0 / 248.0, 0.0, 248, 36.0};
  PanTiltAxisOptions tilt{0.65, -20.0, 100, 20.0};
  /// As of the base: up to so many clicks a tick the board is asked while it moves.
  double poll_limit_clicks = 9.0;
  double poll_period_s = 0.06;
  double idle_period_s = 0.1;
  int ramp_start = 3;  ///< the listing's defaults
  int ramp_step_ticks = 30;

  template <class Visitor>
  void visit(Visitor& v) {
    v("pan", pan);
    v("tilt", tilt);
    v("poll_limit_clicks", poll_limit_clicks, Limits{1.0, 90.0});
    v("poll_period_s", poll_period_s, Limits{0.03, 10.0});
    v("idle_period_s", idle_period_s, Limits{0.05, 10.0});
    v("ramp_start", ramp_start, Limits{1, 50});
    v("ramp_step_ticks", ramp_step_ticks, Limits{0, 1000});
  }
};

/// Driver of thesis B's pan-tilt board, without port or clock. A move up to poll_limit_clicks is
/// followed by the board's own clicks, a faster one by its ramp, settled at its end. Orders outside
/// the limits are clipped. The listing's firmware cannot stop: it is sent to the next unit instead.
class PanTiltDriver {
 public:
  enum class Link { down, homing, up };

  explicit PanTiltDriver(const PanTiltOptions& options);

  void on_connection(bool connected, Utime now);
  void receive(std::span<const uint8_t> bytes, Utime now);
  void advance(Utime now, std::vector<uint8_t>& out);
  void command(const PanTiltCommand& command, Utime now);
  /// Appends what stops the board as far as it can be stopped.
  void shut_down(std::vector<uint8_t>& out) const;

  std::vector<PanTiltState> take_states();
  Link link() const { return link_; }
  bool moving() const { return phase_ != Phase::idle; }
  std::string state() const;
  int64_t bad_input() const { return bad_lines_ + exchange_.overlong(); }
  int64_t resets() const { return resets_; }

 private:
  enum class Phase { idle, moving, stopping };
  struct Axis {
    PanTiltAxisOptions options;
    char go = 'g';
    char ramp_letter = 'k';
    double units = 0.0;  ///< as last known
    double units_per_s = 0.0;
    int from = 0;
    int to = 0;
    double reported_units = 0.0;      ///< the last status as it was written
    double steady_units_per_s = 0.0;  ///< from readings within one unit
    bool on = false;
    bool started = false;
    Ramp ramp;
    RampWalk walk;
    Utime started_at;

    bool moves() const { return from != to; }
    int direction() const { return to < from ? -1 : 1; }
  };

  void on_line(const std::string& line, Utime now);
  void on_status(const PanTiltStatus& status, Utime measured, Utime now);
  void begin(const PanTiltCommand& command, Utime now);
  void plan(Axis& axis, double angle_rad, double rate_rad_per_s) const;
  void begin_stop();
  void stop_by_going_on();
  void come_to_rest(Utime now);
  void schedule(Utime now);
  void follow_ramps(Utime now);
  void publish(Utime measured);
  void update(Axis& axis, int units, int clicks, bool full, bool on, Utime measured) const;
  static double settle_late_index(Axis& axis, double reported_units, double passed_s);
  void on_timeout(const LineExchange::Request& request, Utime now);
  void ask_status();
  bool polled() const;

  PanTiltOptions options_;
  LineExchange exchange_;
  Axis pan_, tilt_;
  Link link_ = Link::down;
  Phase phase_ = Phase::idle;
  std::optional<PanTiltCommand> wanted_;
  std::vector<PanTiltState> states_;
  bool connected_ = false;
  bool wait_armed_ = false;
  bool stop_answered_ = true;  ///< `p` does something on this board; learnt
  int silent_ = 0;
  Utime last_stamp_, next_status_, next_ping_, next_prediction_;
  int64_t bad_lines_ = 0;
  int64_t resets_ = 0;
};

}  // namespace marco::drivers::hcs12
