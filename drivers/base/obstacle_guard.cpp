#include "drivers/base/obstacle_guard.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/base/arc.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr const char* kObstacle = "an obstacle is in the way";
constexpr const char* kUnseen = "no sensor sees the ground there";
constexpr double kUnseenMPerS = 0.1, kUnseenM = 0.5;  // into ground that no sensor sees
constexpr double kGroundAheadM = 0.3;                 // of a leg's way; the rest is watched
constexpr double kLegStepM = 0.01;
constexpr double kMostWayM = 3.0;  // what is farther is not remembered
constexpr double kEarlyM = 0.02;   // so near a leg's end it is left to the leg
constexpr double kLeastPeriodS = 0.1, kMostPeriodS = 0.2;

double direction(double value) { return value == 0.0 ? 0.0 : std::copysign(1.0, value); }

}  // namespace

ObstacleGuard::ObstacleGuard(const GuardOptions& options)
    : options_(options),
      body_(options.body_m),
      around_(body_, {options.min_height_m, options.max_height_m}),
      forecast_(options.delay_s) {
  validate(options, "guard");
}

void ObstacleGuard::on_scan(const LaserScan& scan, const Pose2& odom_from_robot, Utime now) {
  if (options_.enabled) around_.on_scan(scan, odom_from_robot, now);
}

void ObstacleGuard::on_sonar(const SonarRing& ring,
                             const Pose2& odom_from_robot,
                             Utime now,
                             Surroundings::Sonars read) {
  if (options_.enabled) around_.on_sonar(ring, odom_from_robot, now, read);
}

void ObstacleGuard::on_bumpers(std::vector<int> front_pressed, std::vector<int> rear_pressed) {
  front_pressed_ = std::move(front_pressed);
  rear_pressed_ = std::move(rear_pressed);
}

std::string ObstacleGuard::pressed_bumpers(double ahead) const {
  const bool back = std::signbit(ahead);
  const std::vector<int>& pressed = back ? rear_pressed_ : front_pressed_;
  if (!options_.enabled || ahead == 0.0 || pressed.empty()) return "";
  std::string text = back ? "rear bumper" : "front bumper";
  if (pressed.size() > 1) text += "s";
  for (const int number : pressed) text += " " + std::to_string(number);
  return text + (pressed.size() > 1 ? " are pressed" : " is pressed");
}

double ObstacleGuard::speed_limit_m_per_s() const {
  const bool sees = !options_.enabled || around_.why_blind().empty();
  return sees ? kInfinity : options_.without_sensors_m_per_s;
}

std::string ObstacleGuard::words() const {
  if (!options_.enabled) return "off";
  const std::string blind = around_.why_blind(), dispute = around_.dispute();
  std::string words;
  if (!blind.empty()) words = format("at most %g m/s: ", options_.without_sensors_m_per_s) + blind;
  add_words(words, dispute);
  return words;
}

void ObstacleGuard::on_odometry(const OdometrySample& sample) {
  around_.on_odometry(sample);
  const Pose2 step = between(odom_from_robot_, sample.odom_from_robot);
  odom_from_robot_ = sample.odom_from_robot;
  const double since_s = (sample.utime - std::exchange(measured_at_, sample.utime)).seconds();
  const BaseVelocity velocity{sample.velocity_m_per_s, sample.yaw_rate_rad_per_s};
  forecast_.on_measured(velocity, since_s, around_.now());
  // A turn leads nowhere, and so begins no new half metre.
  const bool leads = std::abs(step.x_m) > std::abs(step.theta_rad) * body_.radius_m();
  const bool seen =
      leads && ground_of(Sweep(1), {step.x_m, step.theta_rad}) == LocalMap::Ground::seen;
  const double moved_m = step.translation_m().norm();
  unseen_m_ = seen || moved_m > Surroundings::kJumpM ? 0.0 : unseen_m_ + moved_m;
}

Sweep ObstacleGuard::way_of(const BaseVelocity& order, const Drive& drive) const {
  return forecast_.stopping_way(drive.as_driven ? drive.as_driven(order) : order, period_s_,
                                around_.now(), body_.radius_m());
}

/// Carries the way on along the order's arc, by the margin ahead: the less, the more it turns.
void ObstacleGuard::keep_margin(Sweep& sweep, const BaseVelocity& order) const {
  const double fastest = order.fastest_m_per_s(body_.radius_m());
  const double more_m = options_.margin_m - options_.side_margin_m;
  if (order.ahead_m_per_s == 0.0 || more_m <= 0.0) return;
  const double length_m = more_m * std::abs(order.ahead_m_per_s) / fastest;
  const int steps = static_cast<int>(std::ceil(length_m / kLegStepM));
  const BaseVelocity step = order * (length_m / fastest / steps);
  for (int i = 0; i < steps; ++i) {
    advance(sweep, along_arc(step.ahead_m_per_s, step.turn_rad_per_s), body_.radius_m());
  }
}

ObstacleGuard::Points ObstacleGuard::points_near(const Sweep& sweep) const {
  double way_m = 0.0;
  for (const SweptPose& pose : sweep) {
    way_m = std::max(way_m, pose.start_from_robot.translation_m().norm());
  }
  return around_.points_within(way_m + body_.radius_m() + options_.side_margin_m + kEarlyM);
}

/// The worst that the body's leading edge meets.
LocalMap::Ground ObstacleGuard::ground_of(const Sweep& sweep, const BaseVelocity& velocity) const {
  const double ahead = velocity.ahead_m_per_s, turn = velocity.turn_rad_per_s;
  const double edge_m = ahead > 0.0 ? body_.front_m() : -body_.back_m();
  const double side_m = std::max(0.0, body_.half_width_m() - 0.09);  // of cells that the body fills
  LocalMap::Ground worst = LocalMap::Ground::seen;
  double next_m = 0.0;
  for (const SweptPose& pose : sweep) {
    if (pose.swept_m < next_m) continue;
    next_m = pose.swept_m + 2.0 * kLegStepM;
    for (const double y_m : {-side_m, 0.0, side_m}) {
      // Where it swings sideways, or back, it does not lead.
      const Eigen::Vector2d moves(ahead - turn * y_m, turn * edge_m);
      if (moves.x() * ahead <= 0.0 || std::abs(moves.x()) < std::abs(moves.y())) continue;
      worst =
          std::min(worst, around_.ground_at(pose.start_from_robot * Eigen::Vector2d(edge_m, y_m)));
    }
  }
  return worst;
}

/// @returns "" = the way is free.
std::string ObstacleGuard::why_not(const Sweep& sweep,
                                   const BaseVelocity& order,
                                   const Points& points) const {
  if (first_contact(body_, sweep, points, options_.side_margin_m) < sweep.size()) return kObstacle;
  if (!around_.why_blind().empty()) return "";
  const double way_m = sweep.back().start_from_robot.translation_m().norm();
  if (way_m > kMostWayM) return kUnseen;
  const LocalMap::Ground ground = ground_of(sweep, order);
  const bool slow = std::abs(order.ahead_m_per_s) <= kUnseenMPerS && unseen_m_ + way_m <= kUnseenM;
  const bool may =
      ground == LocalMap::Ground::seen || (ground == LocalMap::Ground::remembered && slow);
  return may ? "" : kUnseen;
}

/// The part of the order that is free, and why it is not all.
std::pair<double, std::string> ObstacleGuard::free_part(const BaseVelocity& order,
                                                        const Drive& drive) const {
  const auto way = [&](double part) {
    Sweep sweep = way_of(order * part, drive);
    keep_margin(sweep, order);
    return sweep;
  };
  const Sweep whole = way(1.0);
  const Points points = points_near(whole);
  std::string why = why_not(whole, order, points);
  if (why.empty()) return {1.0, ""};
  double free = 0.0;
  for (double step = 0.5; step > 1.0 / 64.0; step /= 2.0) {
    if (why_not(way(free + step), order * (free + step), points).empty()) free += step;
  }
  return {free, why};
}

void ObstacleGuard::note_drive(const Drive& drive) {
  const double since_s = (around_.now() - std::exchange(judged_at_, around_.now())).seconds();
  period_s_ = std::clamp(std::max(since_s, 0.9 * period_s_), kLeastPeriodS, kMostPeriodS);
  BaseDynamics dynamics = drive.dynamics;
  const double sure = std::min(1.0, options_.braking_m_per_s2 / dynamics.braking_m_per_s2);
  dynamics.braking_m_per_s2 *= sure;
  dynamics.turn_braking_rad_per_s2 *= sure;
  forecast_.set_dynamics(dynamics);
}

ObstacleGuard::Verdict ObstacleGuard::judge(const BaseVelocity& order, const Drive& drive) {
  note_drive(drive);
  if (!options_.enabled) return {order};
  Verdict verdict{order, pressed_bumpers(order.ahead_m_per_s)};
  if (!verdict.why.empty()) verdict.velocity.ahead_m_per_s = 0.0;
  const double fastest = verdict.velocity.fastest_m_per_s(body_.radius_m());
  if (fastest == 0.0) return verdict;
  const BaseVelocity wanted = verdict.velocity * std::min(1.0, speed_limit_m_per_s() / fastest);
  const auto [part, why] = free_part(wanted, drive);
  if (part == 1.0) return {wanted, verdict.why};
  if (part > 0.0) return {wanted * part, why == kObstacle ? "slowed down before an obstacle" : why};
  const BaseVelocity turn{0.0, wanted.turn_rad_per_s};
  if (turn == wanted || turn.is_zero()) return {{}, why};
  return {turn * free_part(turn, drive).first, why};
}

ObstacleGuard::FreeWay ObstacleGuard::free_way(double wanted, const BaseVelocity& unit) const {
  if (!options_.enabled) return {wanted};
  if (const std::string bumpers = pressed_bumpers(wanted * unit.ahead_m_per_s); !bumpers.empty()) {
    return {0.0, bumpers};
  }
  const double swept_m = unit.fastest_m_per_s(body_.radius_m());  // of one
  const double sign = direction(wanted), most = std::min(std::abs(wanted), kMostWayM / swept_m);
  const double step = kLegStepM / swept_m;
  const BaseVelocity way = unit * sign;
  Sweep sweep(1);
  for (double done = 0.0; done < most; done += step) {
    const BaseVelocity moved = way * std::min(step, most - done);
    advance(sweep, along_arc(moved.ahead_m_per_s, moved.turn_rad_per_s), body_.radius_m());
  }
  const double end_m = sweep.back().swept_m;
  keep_margin(sweep, way);
  const std::size_t first = first_contact(body_, sweep, points_near(sweep), options_.side_margin_m);
  FreeWay free{wanted};
  if (first < sweep.size()) {
    const double margin_m = sweep.back().swept_m - end_m;
    free = {sign * std::max(0.0, sweep[first - 1].swept_m - margin_m) / swept_m, kObstacle};
  }
  return way.ahead_m_per_s == 0.0 ? free : on_seen_ground(std::move(free), sweep, way);
}

/// What of a move is allowed for the ground that it begins with; the rest is watched.
ObstacleGuard::FreeWay ObstacleGuard::on_seen_ground(FreeWay free,
                                                     const Sweep& sweep,
                                                     const BaseVelocity& way) const {
  if (!around_.why_blind().empty()) return free;
  const auto begin_of = [&](double length_m) {
    const auto end = std::find_if(sweep.begin(), sweep.end(),
                                  [&](const SweptPose& pose) { return pose.swept_m > length_m; });
    return Sweep(sweep.begin(), end);
  };
  const bool may = ground_of(begin_of(kEarlyM), way) != LocalMap::Ground::unknown;
  if (!may || unseen_m_ > kUnseenM - kEarlyM) return {0.0, kUnseen};
  if (ground_of(begin_of(kGroundAheadM), way) != LocalMap::Ground::seen) {
    free.speed_limit_m_per_s = kUnseenMPerS;
  }
  return free;
}

ObstacleGuard::FreeWay ObstacleGuard::free_move(double wanted_m) const {
  return free_way(wanted_m, {1.0, 0.0});
}

ObstacleGuard::FreeWay ObstacleGuard::free_turn(double wanted_rad) const {
  return free_way(wanted_rad, {0.0, 1.0});
}

std::string ObstacleGuard::why_end_leg(const BaseVelocity& speed,
                                       double remaining,
                                       const Drive& drive) {
  note_drive(drive);
  if (!options_.enabled) return "";
  if (std::string bumpers = pressed_bumpers(speed.ahead_m_per_s); !bumpers.empty()) return bumpers;
  Sweep sweep = way_of(speed, drive);
  const bool turns = speed.ahead_m_per_s == 0.0;
  const double left_m = std::abs(remaining) * (turns ? body_.radius_m() : 1.0) - kEarlyM;
  while (sweep.size() > 1 && sweep.back().swept_m > left_m) sweep.pop_back();
  if (sweep.size() == 1) return "";
  keep_margin(sweep, speed);
  return why_not(sweep, speed, points_near(sweep));
}

}  // namespace marco::drivers
