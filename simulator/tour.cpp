#include "simulator/tour.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::sim {
namespace {

constexpr double kSettleS = 0.3;  // of the pan-tilt

}  // namespace

MotionPlan::MotionPlan(const Tour& tour, const RobotOptions& robot, double scans_per_s)
    : robot_(robot) {
  validate(robot, "robot");
  require(tour.start_m.size() == 2, "start_m: expected two numbers, x and y");
  now_.world_from_robot = {tour.start_m[0], tour.start_m[1], deg_to_rad(tour.start_heading_deg)};
  for (const TourStep& step : tour.steps) {
    if (step.kind == "go") {
      go(step);
    } else if (step.kind == "face") {
      turn_to(deg_to_rad(step.heading_deg));
    } else if (step.kind == "sweep") {
      sweep(step, scans_per_s);
    } else if (step.kind == "pan") {
      pan(step, scans_per_s);
    } else {
      require(step.kind == "wait",
              "steps.kind '" + step.kind + "': expected go, face, sweep, pan or wait");
      append(Phase::Kind::wait, step.seconds, 1.0, 0.0);
    }
  }
}

void MotionPlan::append(Phase::Kind kind, double amount, double rate, double acceleration) {
  const double size = std::abs(amount);
  if (size < 1e-9) return;
  double duration_s = size / rate;
  if (acceleration > 0.0) {
    // A trapezoid, or a triangle where the way is too short for the full rate.
    duration_s = size >= rate * rate / acceleration ? size / rate + rate / acceleration
                                                    : 2.0 * std::sqrt(size / acceleration);
  }
  const double start_s = this->duration_s();
  phases_.push_back({kind, start_s, start_s + duration_s, amount, acceleration, now_});
  now_ = advance(phases_.back(), duration_s);
}

RobotState MotionPlan::advance(const Phase& phase, double seconds) {
  const double duration_s = phase.end_s - phase.start_s;
  const double t = std::clamp(seconds, 0.0, duration_s), size = std::abs(phase.amount);
  double done = size * t / duration_s;
  if (phase.acceleration > 0.0) {
    // Of the trapezoid: ramp time r from size = a r (duration - r).
    const double a = phase.acceleration;
    const double root = std::max(0.0, 0.25 * duration_s * duration_s - size / a);
    const double ramp_s = 0.5 * duration_s - std::sqrt(root);
    if (t < ramp_s) {
      done = 0.5 * a * t * t;
    } else if (t > duration_s - ramp_s) {
      done = size - 0.5 * a * (duration_s - t) * (duration_s - t);
    } else {
      done = 0.5 * a * ramp_s * ramp_s + a * ramp_s * (t - ramp_s);
    }
  }
  const double signed_done = phase.amount < 0.0 ? -done : done;
  RobotState state = phase.from;
  if (phase.kind == Phase::Kind::drive) {
    state.world_from_robot = state.world_from_robot * Pose2{signed_done, 0.0, 0.0};
  } else if (phase.kind == Phase::Kind::turn) {
    state.world_from_robot = state.world_from_robot * Pose2{0.0, 0.0, signed_done};
  } else if (phase.kind == Phase::Kind::pan) {
    state.pan_rad += signed_done;
  } else if (phase.kind == Phase::Kind::tilt) {
    state.tilt_rad += signed_done;
  }
  return state;
}

void MotionPlan::turn_to(double heading_rad) {
  append(Phase::Kind::turn, normalize_angle(heading_rad - now_.world_from_robot.theta_rad),
         deg_to_rad(robot_.turn_rate_deg_per_s), deg_to_rad(robot_.turn_acceleration_deg_per_s2));
}

void MotionPlan::go(const TourStep& step) {
  require(step.to_m.size() == 2, "steps.to_m: expected two numbers, x and y");
  const Eigen::Vector2d way =
      Eigen::Vector2d(step.to_m[0], step.to_m[1]) - now_.world_from_robot.translation_m();
  if (way.norm() < 1e-6) return;
  turn_to(std::atan2(way.y(), way.x()));
  append(Phase::Kind::drive, way.norm(), robot_.speed_m_per_s, robot_.acceleration_m_per_s2);
}

void MotionPlan::sweep(const TourStep& step, double scans_per_s) {
  const double between_rad_per_s = deg_to_rad(robot_.pantilt_rate_deg_per_s);
  const double from = deg_to_rad(step.tilt_from_deg), to = deg_to_rad(step.tilt_to_deg);
  require(std::abs(to - from) > 1e-3, "steps: a sweep needs two different tilts");
  for (const double pan_deg : step.pans_deg) {
    append(Phase::Kind::pan, deg_to_rad(pan_deg) - now_.pan_rad, between_rad_per_s, 0.0);
    append(Phase::Kind::tilt, from - now_.tilt_rad, between_rad_per_s, 0.0);
    append(Phase::Kind::wait, kSettleS, 1.0, 0.0);
    append(Phase::Kind::tilt, to - from, std::abs(to - from) * scans_per_s / step.rows, 0.0);
    append(Phase::Kind::wait, kSettleS, 1.0, 0.0);
  }
  append(Phase::Kind::tilt, -now_.tilt_rad, between_rad_per_s, 0.0);
  append(Phase::Kind::pan, -now_.pan_rad, between_rad_per_s, 0.0);
  append(Phase::Kind::wait, kSettleS, 1.0, 0.0);
}

void MotionPlan::pan(const TourStep& step, double scans_per_s) {
  const double between_rad_per_s = deg_to_rad(robot_.pantilt_rate_deg_per_s);
  const double from = deg_to_rad(step.pan_from_deg), to = deg_to_rad(step.pan_to_deg);
  require(std::abs(to - from) > 1e-3, "steps: pan needs two different angles");
  append(Phase::Kind::pan, from - now_.pan_rad, between_rad_per_s, 0.0);
  append(Phase::Kind::wait, kSettleS, 1.0, 0.0);
  append(Phase::Kind::pan, to - from, std::abs(to - from) * scans_per_s / step.rows, 0.0);
  append(Phase::Kind::wait, kSettleS, 1.0, 0.0);
  append(Phase::Kind::pan, -now_.pan_rad, between_rad_per_s, 0.0);
  append(Phase::Kind::wait, kSettleS, 1.0, 0.0);
}

RobotState MotionPlan::at(double seconds) const {
  if (phases_.empty()) return now_;
  const auto after =
      std::upper_bound(phases_.begin(), phases_.end(), seconds,
                       [](double t, const Phase& phase) { return t < phase.start_s; });
  const Phase& phase = after == phases_.begin() ? phases_.front() : *(after - 1);
  RobotState state = advance(phase, seconds - phase.start_s);
  state.pan_rad = normalize_angle(state.pan_rad + deg_to_rad(robot_.spin_deg_per_s) * seconds);
  return state;
}

}  // namespace marco::sim
