#include "drivers/hcs12/drive_run.hpp"

#include <algorithm>
#include <cmath>

namespace marco::drivers::hcs12 {
namespace {

constexpr uint32_t kMaxTenths = 65535;
constexpr double kStuckS = 0.5;  // without a click: the wheels do not turn

uint32_t clicks_per_tick(double wheel_m_per_s, const Hcs12BaseOptions& options) {
  const double clicks = std::round(std::abs(wheel_m_per_s) / options.metres_per_click() * kTickS);
  return static_cast<uint32_t>(std::clamp(clicks, 2.0, double{kMaxClicksPerTick}));
}

Ramp ramp_for(double wheel_m_per_s, double wheel_m_per_s2, const Hcs12BaseOptions& options) {
  Ramp ramp;
  ramp.top = clicks_per_tick(wheel_m_per_s, options);
  ramp.start = std::min<uint32_t>(5, ramp.top);
  const double clicks_per_tick2 = wheel_m_per_s2 / options.metres_per_click() * kTickS * kTickS;
  ramp.step_ticks = static_cast<uint32_t>(std::clamp(1.0 / clicks_per_tick2 - 1.0, 1.0, 1000.0));
  return ramp;
}

double tenths_in(double seconds, const Ramp& ramp) {
  return std::ceil(ramp.top * seconds / kTickS / 100.0);
}

char letter_for(bool turns, double way) {
  if (turns) return way > 0.0 ? 'i' : 'd';
  return way > 0.0 ? 'a' : 'r';
}

RampWalk walk_of(const RunOrder& order) {
  return {order.ramp, order.tenths * 100, RampWalk::Brake::to_zero, RampWalk::Wheel::real};
}

}  // namespace

RunOrder RunOrder::of_leg(const BaseDriver::Leg& leg,
                          const BaseSpeeds& speeds,
                          const Hcs12BaseOptions& options) {
  const bool turns = leg.kind == BaseDriver::Leg::Kind::turn;
  const double way_m = turns ? leg.amount * options.track_m / 2.0 : leg.amount;
  const double speed =
      turns ? speeds.yaw_rate_rad_per_s * options.track_m / 2.0 : speeds.velocity_m_per_s;
  const double tenths = std::round(std::abs(way_m) / options.metres_per_click() / 100.0);
  RunOrder order;
  order.letter = letter_for(turns, way_m);
  order.ramp = ramp_for(speed, speeds.acceleration_m_per_s2, options);
  order.tenths = static_cast<uint32_t>(
      std::min({tenths, tenths_in(kLegRunS, order.ramp), double{kMaxTenths}}));
  order.tenths_behind = static_cast<uint32_t>(tenths) - order.tenths;
  return order;
}

std::optional<RunOrder> RunOrder::of_velocity_command(double velocity_m_per_s,
                                                      double yaw_rate_rad_per_s,
                                                      const BaseSpeeds& speeds,
                                                      const Hcs12BaseOptions& options) {
  const double spin = yaw_rate_rad_per_s * options.track_m / 2.0;
  const bool turns = std::abs(spin) > std::abs(velocity_m_per_s);
  const double wheel = std::clamp(turns ? spin : velocity_m_per_s, -options.velocity_limit_m_per_s,
                                  options.velocity_limit_m_per_s);
  if (std::abs(wheel) < 0.01) return std::nullopt;
  RunOrder order;
  order.letter = letter_for(turns, wheel);
  order.of_velocity = true;
  order.ramp = ramp_for(wheel, 4.0 * speeds.acceleration_m_per_s2, options);
  order.ramp.top = std::min(order.ramp.top, static_cast<uint32_t>(options.poll_limit_clicks));
  order.ramp.start = std::min(order.ramp.start, order.ramp.top);
  order.tenths = static_cast<uint32_t>(tenths_in(kVelocityRunS, order.ramp));
  return order;
}

bool RunOrder::differs_in_speed(const RunOrder& driven) const {
  const double top = ramp.top, old_top = driven.ramp.top;
  return top > 1.3 * old_top + 1.0 || top < 0.7 * old_top - 1.0;
}

DriveRun::DriveRun(const RunOrder& run_order, double poll_limit_clicks, Utime now)
    : order(run_order),
      signs(wheel_signs(run_order.letter).value()),
      polled(run_order.ramp.top <= poll_limit_clicks),
      walk(walk_of(run_order)) {
  reading.progress_at = now;
}

void DriveRun::begin(Utime when, Utime now) {
  started = true;
  started_at = reading.at = when;
  reading.progress_at = now;
}

bool DriveRun::is_plausible(const WheelStatus& status, Utime measured) const {
  const double passed_s = std::max(0.0, (measured - started_at).seconds()) + 0.1;
  const double most = (kMaxClicksPerTick + 20) * passed_s / kTickS;
  return status.left_clicks >= reading.left_clicks && status.right_clicks >= reading.right_clicks &&
         status.left_clicks <= most && status.right_clicks <= most;
}

DriveRun::Clicks DriveRun::read(const WheelStatus& status, Utime measured, Utime now) {
  const Clicks clicks{
      signs.left * static_cast<double>(status.left_clicks - reading.left_clicks),
      signs.right * static_cast<double>(status.right_clicks - reading.right_clicks)};
  if (clicks.left != 0.0 || clicks.right != 0.0) reading.progress_at = now;
  if (const double since_s = (measured - reading.at).seconds(); since_s > 0.02) {
    reading.left_clicks_per_s = std::abs(clicks.left) / since_s;
    reading.right_clicks_per_s = std::abs(clicks.right) / since_s;
  }
  reading.at = measured;
  reading.left_clicks = status.left_clicks;
  reading.right_clicks = status.right_clicks;
  return clicks;
}

DriveRun::Clicks DriveRun::clicks_per_s() const {
  return {signs.left * reading.left_clicks_per_s, signs.right * reading.right_clicks_per_s};
}

DriveRun::Clicks DriveRun::extrapolated(Utime when) const {
  const double since_s = std::clamp((when - reading.at).seconds(), 0.0, kVelocityRunS);
  return {std::round(clicks_per_s().left * since_s), std::round(clicks_per_s().right * since_s)};
}

DriveRun::Clicks DriveRun::walked() const {
  const auto clicks =
      static_cast<double>(std::min<int64_t>(walk.clicks(), order.tenths * int64_t{100}));
  const double way = clicks - static_cast<double>(reading.left_clicks);
  return {signs.left * way, signs.right * way};
}

double DriveRun::remaining_clicks() const {
  const auto passed =
      static_cast<double>(polled ? reading.left_clicks : static_cast<uint32_t>(walk.clicks()));
  return std::max(0.0, (order.tenths + order.tenths_behind) * 100.0 - passed);
}

int64_t DriveRun::missing_clicks() const {
  return static_cast<int64_t>(order.tenths) * 100 -
         std::min(reading.left_clicks, reading.right_clicks);
}

bool DriveRun::moves(Utime now) const { return (now - reading.progress_at).seconds() <= kStuckS; }

RunOrder DriveRun::rest() const {
  RunOrder rest = order;
  rest.tenths = static_cast<uint32_t>(missing_clicks() / 100);
  return rest;
}

RunOrder DriveRun::next_piece() const {
  const int64_t too_far =
      (int64_t{reading.left_clicks} + reading.right_clicks) / 2 - order.tenths * int64_t{100};
  const int64_t tenths = std::max<int64_t>(
      0,
      order.tenths_behind - static_cast<int64_t>(std::lround(static_cast<double>(too_far) / 100)));
  RunOrder next = order;
  next.tenths =
      static_cast<uint32_t>(std::min(static_cast<double>(tenths), tenths_in(kLegRunS, order.ramp)));
  next.tenths_behind = static_cast<uint32_t>(tenths) - next.tenths;
  return next;
}

std::optional<double> DriveRun::pace() const {
  constexpr double kLeastTicks = 1000.0;
  const double real_ticks = static_cast<double>((rested_at - started_at).us) / kTickUs;
  if (polled || stood_still || real_ticks < kLeastTicks) return std::nullopt;
  RampWalk whole = walk_of(order);
  whole.finish();
  return static_cast<double>(whole.ticks()) / real_ticks;
}

}  // namespace marco::drivers::hcs12
