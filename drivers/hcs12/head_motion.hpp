#pragma once

#include <vector>

#include "common/robot_values.hpp"
#include "common/samples.hpp"
#include "drivers/hcs12/codec.hpp"
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
  /// As of the base: up to this speed [clicks per tick] the board is asked while it moves.
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

/// One axis of the pan-tilt: its order, and where it is as far as is known.
struct HeadAxis {
  PanTiltAxisOptions options;
  char go = 'g';
  char ramp_letter = 'k';
  int from = 0;  ///< units
  int to = 0;
  bool started = false;
  Utime started_at;
  Ramp ramp;
  RampWalk walk;
  struct Place {
    double units = 0.0;
    double units_per_s = 0.0;
    double reported_units = 0.0;      ///< the last status as it was written
    double steady_units_per_s = 0.0;  ///< from readings within one unit
    bool on = false;
  };
  Place place;

  bool moves() const { return from != to; }
  int direction() const { return to < from ? -1 : 1; }
  double angle_deg() const { return options.home_deg + place.units * options.deg_per_unit; }
};

/// How the pan-tilt moves: plans moves of the two axes, follows their ramps, and judges what the
/// board reports of them.
class HeadMotion {
 public:
  /// @param options outlives it.
  explicit HeadMotion(const PanTiltOptions& options);

  /// Orders outside the limits are clipped. @returns whether an axis has to move.
  bool plan(const PanTiltCommand& command);
  /// Axes whose move has been planned.
  std::vector<const HeadAxis*> moving_axes() const;
  /// Whether the planned move is slow enough to ask the board while it moves.
  bool polled() const;
  /// Ticks of the longer of the two planned moves.
  int64_t longest_ticks() const;
  /// The board has echoed the order to move.
  void begin(char go, Utime now);
  /// Ends each move at the next unit it can be sent to instead. @returns those axes.
  std::vector<const HeadAxis*> shorten();
  void come_to_rest();

  void on_status(const PanTiltStatus& status, Utime measured);
  /// Predicts the angles of a fast move.
  void follow_ramps(Utime now);
  std::vector<PanTiltState> take_states();
  /// The host's clock may have been set back.
  void forget_stamps() { last_stamp_ = next_prediction_ = {}; }

 private:
  void plan(HeadAxis& axis, double angle_rad, double rate_rad_per_s) const;
  struct Reading {
    int units = 0;
    int clicks = 0;
    bool on = false;
    bool full = true;  ///< the listing's form
  };
  void update(HeadAxis& axis, const Reading& reading, Utime measured) const;
  void publish(Utime measured);

  const PanTiltOptions& options_;
  HeadAxis pan_, tilt_;
  std::vector<PanTiltState> states_;
  Utime last_stamp_;
  Utime next_prediction_;
};

}  // namespace marco::drivers::hcs12
