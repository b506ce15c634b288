#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <vector>

#include "guard_bench.hpp"

namespace marco::drivers::testing {

enum class Commander { random, hostile, jerky, backwards };
enum class Rule { guard, swept_arc };

struct GuardRun {
  Commander commander = Commander::random;
  Rule rule = Rule::guard;
  double delay_s = 0.1;
  double view_deg = 360.0;
  double control_hz = 50.0;
  double seconds = 30.0;
  double noise_m = 0.0;
};

struct GuardOutcome {
  std::optional<Touch> touch;
  int64_t steps = 0, stopped_steps = 0;  ///< with an order; and of these with none to the wheels
  double way_m = 0.0;
};

/// The rule of which it is known that it works (0 of 50 random runs), slow and obvious: the largest
/// fifth of the order with which the body, driven on through the delay and braked then, meets none
/// of the newest scan's points.
inline double swept_arc_part(const std::vector<Eigen::Vector2d>& points_in_robot,
                             const BaseVelocity& is,
                             const BaseVelocity& order,
                             const std::deque<BaseVelocity>& late,
                             double step_s) {
  constexpr double kMargin = 0.03, kFront = 0.30, kSide = 0.27;
  for (const double part : {1.0, 0.8, 0.6, 0.4, 0.2}) {
    Pose2 at;
    BaseVelocity speed = is;
    bool clear = true;
    const double drive_s = step_s * static_cast<double>(late.size()) + 0.12;
    for (double t = 0.0; clear && t < 6.0; t += step_s) {
      BaseVelocity goal;
      const auto i = static_cast<std::size_t>(t / step_s + 0.5);
      if (i < late.size()) {
        goal = late[i];
      } else if (t < drive_s) {
        goal = order * part;
      } else if (speed.is_zero()) {
        break;
      }
      speed.ahead_m_per_s +=
          std::clamp(goal.ahead_m_per_s - speed.ahead_m_per_s, -0.3 * step_s, 0.3 * step_s);
      speed.turn_rad_per_s +=
          std::clamp(goal.turn_rad_per_s - speed.turn_rad_per_s, -step_s, step_s);
      at = at * along_arc(speed.ahead_m_per_s * step_s, speed.turn_rad_per_s * step_s);
      const Pose2 back = at.inverse();
      clear = std::none_of(points_in_robot.begin(), points_in_robot.end(), [&](const auto& p) {
        const Eigen::Vector2d q = back * p;
        return std::abs(q.x()) < kFront + kMargin && std::abs(q.y()) < kSide + kMargin;
      });
    }
    if (clear) return part;
  }
  return 0.0;
}

/// Somebody who drives: at random, or as badly as he can.
class Driver {
 public:
  Driver(Commander commander, std::mt19937& random) : commander_(commander), random_(random) {}

  BaseVelocity order(const GuardWorld& world,
                     const Footprint& body,
                     const Pose2& pose,
                     double t_s) {
    if (t_s >= until_s_) choose(t_s);
    if (commander_ != Commander::hostile) return order_;
    // At the nearest thing, whichever end of the body it is at.
    const Eigen::Vector2d to = pose.inverse() * world.gap(body, pose).at;
    const double bearing = std::atan2(to.y(), to.x());
    const bool ahead = std::abs(bearing) < std::numbers::pi / 2.0;
    const double off = ahead ? bearing : normalize_angle(bearing + std::numbers::pi);
    return {ahead ? 0.8 : -0.8, std::clamp(2.0 * off, -1.2, 1.2)};
  }

 private:
  double draw(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }
  void choose(double t_s) {
    if (commander_ == Commander::jerky) {
      until_s_ = t_s + draw(0.05, 0.6);
      order_ = {random_() % 2 == 0 ? 0.8 : -0.8, random_() % 2 == 0 ? 1.2 : -1.2};
      return;
    }
    until_s_ = t_s + 2.0;
    const bool back = commander_ == Commander::backwards;
    order_ = {back ? draw(-0.8, 0.1) : draw(-0.4, 0.8), draw(-1.2, 1.2)};
    if (random_() % 4 == 0) order_.turn_rad_per_s = 0.0;
  }

  Commander commander_;
  std::mt19937& random_;
  double until_s_ = 0.0;
  BaseVelocity order_;
};

/// One drive in one world.
class GuardDrive {
 public:
  GuardDrive(const GuardRun& run, const GuardWorld& world, unsigned seed)
      : run_(run),
        random_(seed),
        driver_(run.commander, random_),
        bench_(world, options(run), random_) {
    bench_.delay_s = run.delay_s;
    bench_.laser.view_deg = run.view_deg;
    bench_.laser.noise_m = run.noise_m;
    bench_.step_s = 1.0 / run.control_hz;
    bench_.start({0.0, 0.0, std::uniform_real_distribution<double>(-3.14, 3.14)(random_)});
  }

  GuardOutcome drive() {
    GuardOutcome outcome;
    for (double t_s = 0.0; t_s < run_.seconds && !bench_.touched(); t_s += bench_.step_s) {
      const PlainBase& base = bench_.base();
      bench_.look();
      const BaseVelocity order =
          driver_.order(bench_.world(), bench_.body(), base.world_from_robot, t_s);
      const Pose2 before = base.world_from_robot;
      bench_.step(run_.rule == Rule::guard ? order : swept(order));
      late_.push_back(base.told());
      if (static_cast<double>(late_.size()) > run_.delay_s / bench_.step_s + 0.5) late_.pop_front();
      outcome.way_m += between(before, base.world_from_robot).translation_m().norm();
      if (order.is_zero()) continue;
      ++outcome.steps;
      outcome.stopped_steps += base.told().is_zero() ? 1 : 0;
    }
    outcome.touch = bench_.touched();
    return outcome;
  }

 private:
  static GuardOptions options(const GuardRun& run) {
    GuardOptions options;
    options.enabled = run.rule == Rule::guard;
    options.delay_s = run.delay_s;
    return options;
  }
  BaseVelocity swept(const BaseVelocity& order) const {
    std::vector<Eigen::Vector2d> near;
    const Pose2 robot_from_world = bench_.base().world_from_robot.inverse();
    for (const Eigen::Vector2d& point : bench_.scanned()) {
      if (const Eigen::Vector2d p = robot_from_world * point; p.norm() < 2.5) near.push_back(p);
    }
    return order * swept_arc_part(near, bench_.base().velocity(), order, late_, bench_.step_s);
  }

  GuardRun run_;
  std::mt19937 random_;
  Driver driver_;
  GuardBench bench_;
  std::deque<BaseVelocity> late_;
};

}  // namespace marco::drivers::testing
