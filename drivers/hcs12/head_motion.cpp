#include "drivers/hcs12/head_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::drivers::hcs12 {
namespace {

constexpr double kClicksPerUnit = 1000.0;
constexpr double kPredictionS = 0.02;
constexpr uint32_t kFastest = 50;  // the firmware's own default top

double settle_late_index(HeadAxis& axis, double reported_units, double passed_s) {
  // An index pulse that falls into the printing of a status is seen after it, and the clicks since
  // are lost up to the next pulse. Within a unit differences are true; at the change of a unit a
  // reading that falls behind the steady motion, by no more than a printing, is such a late one.
  constexpr double kLeastDeficit = 0.03, kMostDeficit = 0.26;
  const double step = reported_units - axis.place.reported_units;
  const bool same_unit = std::floor(reported_units) == std::floor(axis.place.reported_units);
  if (same_unit) {
    const double rate = step / passed_s;
    axis.place.steady_units_per_s +=
        (axis.place.steady_units_per_s == 0.0 ? 1.0 : 0.6) * (rate - axis.place.steady_units_per_s);
    return axis.place.units + step;
  }
  const double expected = axis.place.units + axis.place.steady_units_per_s * passed_s;
  const double deficit = axis.direction() * (expected - reported_units);
  return deficit > kLeastDeficit && deficit < kMostDeficit ? expected : reported_units;
}

}  // namespace

HeadMotion::HeadMotion(const PanTiltOptions& options) : options_(options) {
  pan_.options = options.pan;
  tilt_.options = options.tilt;
  tilt_.go = 'e';
  tilt_.ramp_letter = 'K';
}

std::vector<PanTiltState> HeadMotion::take_states() { return std::exchange(states_, {}); }

void HeadMotion::plan(HeadAxis& axis, double angle_rad, double rate_rad_per_s) const {
  const double per_unit = axis.options.deg_per_unit;
  double unit = (rad_to_deg(angle_rad) - axis.options.home_deg) / per_unit;
  // A pan of -90 deg is one of 270 deg.
  const double turn = std::abs(360.0 / per_unit);
  if (&axis == &pan_ && unit < -0.5) unit += turn;
  axis.from = static_cast<int>(std::lround(axis.place.units));
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

bool HeadMotion::plan(const PanTiltCommand& command) {
  plan(pan_, command.pan_rad, command.pan_rate_rad_per_s);
  plan(tilt_, command.tilt_rad, command.tilt_rate_rad_per_s);
  return pan_.moves() || tilt_.moves();
}

std::vector<const HeadAxis*> HeadMotion::moving_axes() const {
  std::vector<const HeadAxis*> axes;
  for (const HeadAxis* axis : {&pan_, &tilt_}) {
    if (axis->moves()) axes.push_back(axis);
  }
  return axes;
}

bool HeadMotion::polled() const {
  const auto slow = [this](const HeadAxis& axis) {
    return !axis.moves() || axis.ramp.top <= options_.poll_limit_clicks;
  };
  return slow(pan_) && slow(tilt_);
}

int64_t HeadMotion::longest_ticks() const {
  int64_t longest = 0;
  for (const HeadAxis* axis : moving_axes()) {
    RampWalk walk = axis->walk;
    walk.finish();
    longest = std::max(longest, walk.ticks());
  }
  return longest;
}

void HeadMotion::begin(char go, Utime now) {
  HeadAxis& axis = go == pan_.go ? pan_ : tilt_;
  if (axis.go != go) return;
  axis.started = true;
  axis.started_at = now;
}

std::vector<const HeadAxis*> HeadMotion::shorten() {
  std::vector<const HeadAxis*> shortened;
  for (HeadAxis* axis : {&pan_, &tilt_}) {
    if (!axis->moves() || !axis->started) continue;
    // Past the unit it will be at when the line has arrived, ending on an index as it must.
    const double ahead =
        axis->place.units + axis->direction() * (1.0 + std::abs(axis->place.units_per_s) * 0.1);
    const double unit = axis->direction() > 0 ? std::ceil(ahead) : std::floor(ahead);
    const int last = std::max(axis->from, axis->to), first = std::min(axis->from, axis->to);
    axis->to = std::clamp(static_cast<int>(unit), first, last);
    shortened.push_back(axis);
  }
  return shortened;
}

void HeadMotion::come_to_rest() {
  for (HeadAxis* axis : {&pan_, &tilt_}) {
    axis->place.units_per_s = 0.0;
    axis->from = axis->to;
  }
}

void HeadMotion::update(HeadAxis& axis, const Reading& reading, Utime measured) const {
  HeadAxis::Place& place = axis.place;
  const double reported_units = reading.units + reading.clicks / kClicksPerUnit;
  double now_units = reported_units;
  const double passed_s = (measured - last_stamp_).seconds();
  if (!reading.full && reading.on) {
    // Whole units only: within the unit by the ramp.
    const double walked =
        axis.from + axis.direction() * static_cast<double>(axis.walk.clicks()) / kClicksPerUnit;
    now_units = axis.direction() > 0 ? std::clamp(walked, reading.units + 0.0, reading.units + 1.0)
                                     : std::clamp(walked, reading.units - 1.0, reading.units + 0.0);
  } else if (reading.on && place.on && passed_s > 1e-3 && passed_s < 0.3) {
    now_units = settle_late_index(axis, reported_units, passed_s);
  }
  if (!reading.on) place.steady_units_per_s = 0.0;
  place.units_per_s = reading.on && passed_s > 1e-3 ? (now_units - place.units) / passed_s : 0.0;
  place.units = now_units;
  place.reported_units = reported_units;
  place.on = reading.on;
}

void HeadMotion::on_status(const PanTiltStatus& status, Utime measured) {
  update(pan_, {status.pan_units, status.pan_clicks, status.pan_on, status.full}, measured);
  update(tilt_, {status.tilt_units, status.tilt_clicks, status.tilt_on, status.full}, measured);
  publish(measured);
}

void HeadMotion::publish(Utime measured) {
  last_stamp_ = std::max(measured, last_stamp_ + Duration::from_us(1));
  PanTiltState state;
  state.utime = last_stamp_;
  state.pan_rad = normalize_angle(deg_to_rad(pan_.angle_deg()));
  state.tilt_rad = deg_to_rad(tilt_.angle_deg());
  state.pan_rate_rad_per_s = deg_to_rad(pan_.place.units_per_s * pan_.options.deg_per_unit);
  state.tilt_rate_rad_per_s = deg_to_rad(tilt_.place.units_per_s * tilt_.options.deg_per_unit);
  states_.push_back(state);
}

void HeadMotion::follow_ramps(Utime now) {
  std::vector<HeadAxis*> started;
  for (HeadAxis* axis : {&pan_, &tilt_}) {
    if (axis->moves() && axis->started) started.push_back(axis);
  }
  for (HeadAxis* axis : started) axis->walk.advance_to((now - axis->started_at).us / kTickUs);
  if (started.empty() || polled() || now < next_prediction_) return;
  next_prediction_ = now + Duration::from_seconds(kPredictionS);
  for (HeadAxis* axis : started) {
    const double way = static_cast<double>(axis->walk.clicks()) / kClicksPerUnit;
    axis->place.units =
        axis->from +
        axis->direction() * std::min(way, std::abs(static_cast<double>(axis->to - axis->from)));
    axis->place.units_per_s =
        axis->direction() * static_cast<double>(axis->walk.speed()) / kClicksPerUnit / kTickS;
  }
  publish(now);
}

}  // namespace marco::drivers::hcs12
