// How the pan-tilt moves: plans, ramps, and what the board says of them.
#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/hcs12/pantilt_driver.hpp"

namespace marco::drivers::hcs12 {
namespace {

constexpr double kClicksPerUnit = 1000.0;
constexpr double kHeadPredictionS = 0.02;
constexpr uint32_t kFastest = 50;  // the firmware's own default top

}  // namespace

void PanTiltDriver::plan(Axis& axis, double angle_rad, double rate_rad_per_s) const {
  const double per_unit = axis.options.deg_per_unit;
  double unit = (rad_to_deg(angle_rad) - axis.options.home_deg) / per_unit;
  // A pan of -90 deg is one of 270 deg.
  const double turn = std::abs(360.0 / per_unit);
  if (&axis == &pan_ && unit < -0.5) unit += turn;
  axis.from = static_cast<int>(std::lround(axis.units));
  axis.to = static_cast<int>(std::clamp(std::round(unit), 0.0, double(axis.options.limit_units)));
  const double rate_deg =
      rate_rad_per_s > 0.0 ? rad_to_deg(rate_rad_per_s) : axis.options.rate_deg_per_s;
  const double clicks = rate_deg / std::abs(per_unit) * kClicksPerUnit * kTickS;
  axis.ramp.top = static_cast<uint32_t>(std::clamp(std::round(clicks), 1.0, double{kFastest}));
  axis.ramp.start = std::min(static_cast<uint32_t>(options_.ramp_start), axis.ramp.top);
  axis.ramp.step_ticks = static_cast<uint32_t>(options_.ramp_step_ticks);
  axis.walk = RampWalk(axis.ramp, static_cast<uint32_t>(std::abs(axis.to - axis.from) * 1000),
                       RampWalk::Brake::to_start, RampWalk::Wheel::real);
  axis.started = false;
}

bool PanTiltDriver::polled() const {
  const auto slow = [this](const Axis& axis) {
    return !axis.moves() || axis.ramp.top <= options_.poll_limit_clicks;
  };
  return slow(pan_) && slow(tilt_);
}

void PanTiltDriver::command(const PanTiltCommand& command, Utime now) {
  if (link_ != Link::up) return;
  if (phase_ == Phase::idle) {
    begin(command, now);
    return;
  }
  wanted_ = command;
  if (phase_ == Phase::moving) begin_stop();
}

void PanTiltDriver::begin(const PanTiltCommand& command, Utime now) {
  if (command.kind == PanTiltCommand::Kind::stop) return;
  plan(pan_, command.pan_rad, command.pan_rate_rad_per_s);
  plan(tilt_, command.tilt_rad, command.tilt_rate_rad_per_s);
  if (!pan_.moves() && !tilt_.moves()) return;
  phase_ = Phase::moving;
  exchange_.clear_queue();
  for (const Axis* axis : {&pan_, &tilt_}) {
    if (!axis->moves()) continue;
    exchange_.ask({encode_command(axis->ramp_letter,
                                  {axis->ramp.start, axis->ramp.top, axis->ramp.step_ticks}),
                   axis->ramp_letter});
  }
  int64_t longest = 0;
  for (const Axis* axis : {&pan_, &tilt_}) {
    if (!axis->moves()) continue;
    exchange_.ask({encode_command(axis->go, {static_cast<uint32_t>(axis->to)}), axis->go});
    RampWalk walk = axis->walk;
    while (!walk.done()) walk.tick();
    longest = std::max(longest, walk.ticks());
  }
  next_status_ = now;
  if (polled()) return;
  // Three numbers here, against the base's four.
  wait_armed_ = true;
  const auto patience = static_cast<uint32_t>(std::min<int64_t>(longest * 5 / 4 + 500, 65000));
  exchange_.ask({encode_command('w', {patience, 1, 1}), '\0'});
}

void PanTiltDriver::begin_stop() {
  phase_ = Phase::stopping;
  wait_armed_ = false;
  exchange_.clear_queue();
  if (stop_answered_) {
    exchange_.ask({encode_command('p'), 'p', 0.1});
    ask_status();
  } else {
    stop_by_going_on();
  }
}

void PanTiltDriver::stop_by_going_on() {
  for (Axis* axis : {&pan_, &tilt_}) {
    if (!axis->moves() || !axis->started) continue;
    // Past the unit it will be at when the line has arrived, ending on an index as it must.
    const double ahead =
        axis->units + axis->direction() * (1.0 + std::abs(axis->units_per_s) * 0.1);
    const double unit = axis->direction() > 0 ? std::ceil(ahead) : std::floor(ahead);
    const int last = std::max(axis->from, axis->to), first = std::min(axis->from, axis->to);
    axis->to = std::clamp(static_cast<int>(unit), first, last);
    exchange_.ask({encode_command(axis->go, {static_cast<uint32_t>(axis->to)}), axis->go});
  }
  ask_status();
}

void PanTiltDriver::ask_status() { exchange_.ask({encode_command('l'), 'l'}); }

double PanTiltDriver::settle_late_index(Axis& axis, double reported_units, double passed_s) {
  // An index pulse that falls into the printing of a status is seen after it, and the clicks since
  // are lost up to the next pulse. Within a unit differences are true; at the change of a unit a
  // reading that falls behind the steady motion, by no more than a printing, is such a late one.
  constexpr double kLeastDeficit = 0.03, kMostDeficit = 0.26;
  const double step = reported_units - axis.reported_units;
  const bool same_unit = std::floor(reported_units) == std::floor(axis.reported_units);
  if (same_unit) {
    const double rate = step / passed_s;
    axis.steady_units_per_s +=
        (axis.steady_units_per_s == 0.0 ? 1.0 : 0.6) * (rate - axis.steady_units_per_s);
    return axis.units + step;
  }
  const double expected = axis.units + axis.steady_units_per_s * passed_s;
  const double deficit = axis.direction() * (expected - reported_units);
  return deficit > kLeastDeficit && deficit < kMostDeficit ? expected : reported_units;
}

void PanTiltDriver::update(
    Axis& axis, int units, int clicks, bool full, bool on, Utime measured) const {
  double now_units = units + clicks / kClicksPerUnit;
  const double reported_units = now_units;
  const double passed_s = (measured - last_stamp_).seconds();
  if (!full && on) {
    // Whole units only: within the unit by the ramp.
    const double walked =
        axis.from + axis.direction() * static_cast<double>(axis.walk.clicks()) / kClicksPerUnit;
    now_units = axis.direction() > 0 ? std::clamp(walked, units + 0.0, units + 1.0)
                                     : std::clamp(walked, units - 1.0, units + 0.0);
  } else if (on && axis.on && passed_s > 1e-3 && passed_s < 0.3) {
    now_units = settle_late_index(axis, reported_units, passed_s);
  }
  if (!on) axis.steady_units_per_s = 0.0;
  axis.units_per_s = on && passed_s > 1e-3 ? (now_units - axis.units) / passed_s : 0.0;
  axis.units = now_units;
  axis.reported_units = reported_units;
  axis.on = on;
}

void PanTiltDriver::on_status(const PanTiltStatus& status, Utime measured, Utime now) {
  link_ = Link::up;
  update(pan_, status.pan_units, status.pan_clicks, status.full, status.pan_on, measured);
  update(tilt_, status.tilt_units, status.tilt_clicks, status.full, status.tilt_on, measured);
  publish(measured);
  const bool still = !status.pan_on && !status.tilt_on;
  if (phase_ == Phase::stopping) {
    if (still) {
      come_to_rest(now);
    } else {
      next_status_ = now + Duration::from_seconds(options_.poll_period_s);
    }
  } else if (phase_ == Phase::moving && still && exchange_.quiet()) {
    come_to_rest(now);
  } else if (phase_ == Phase::moving && !polled() && exchange_.quiet()) {
    wait_armed_ = true;
    exchange_.ask({encode_command('w', {500, 1, 1}), '\0'});
  }
}

void PanTiltDriver::come_to_rest(Utime now) {
  phase_ = Phase::idle;
  pan_.units_per_s = tilt_.units_per_s = 0.0;
  pan_.from = pan_.to;
  tilt_.from = tilt_.to;
  if (const auto next = std::exchange(wanted_, std::nullopt)) begin(*next, now);
}

void PanTiltDriver::publish(Utime measured) {
  last_stamp_ = std::max(measured, last_stamp_ + Duration::from_us(1));
  PanTiltState state;
  state.utime = last_stamp_;
  const auto angle = [](const Axis& axis) {
    return deg_to_rad(axis.options.home_deg + axis.units * axis.options.deg_per_unit);
  };
  state.pan_rad = normalize_angle(angle(pan_));
  state.tilt_rad = angle(tilt_);
  state.pan_rate_rad_per_s = deg_to_rad(pan_.units_per_s * pan_.options.deg_per_unit);
  state.tilt_rate_rad_per_s = deg_to_rad(tilt_.units_per_s * tilt_.options.deg_per_unit);
  states_.push_back(state);
}

void PanTiltDriver::follow_ramps(Utime now) {
  bool any = false;
  for (Axis* axis : {&pan_, &tilt_}) {
    if (!axis->moves() || !axis->started) continue;
    const int64_t ticks = (now - axis->started_at).us / kTickUs;
    while (axis->walk.ticks() < ticks && !axis->walk.done()) axis->walk.tick();
    any = true;
  }
  if (!any || polled() || now < next_prediction_) return;
  next_prediction_ = now + Duration::from_seconds(kHeadPredictionS);
  for (Axis* axis : {&pan_, &tilt_}) {
    if (!axis->moves() || !axis->started) continue;
    const double way = static_cast<double>(axis->walk.clicks()) / kClicksPerUnit;
    axis->units =
        axis->from +
        axis->direction() * std::min(way, std::abs(static_cast<double>(axis->to - axis->from)));
    axis->units_per_s =
        axis->direction() * static_cast<double>(axis->walk.speed()) / kClicksPerUnit / kTickS;
  }
  publish(now);
}

}  // namespace marco::drivers::hcs12
