#include "teleop/tour_runner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace marco::teleop {
namespace {

using Fate = BaseStatus::Command;

constexpr double kGazeToleranceRad = deg_to_rad(1.6);  // a unit of the pan is 1.45 deg
constexpr double kGazePatienceS = 120.0;
constexpr double kLegPatienceS = 120.0;
constexpr double kBlockedS = 2.0;

}  // namespace

TourRunner::TourRunner(const sim::Tour& tour, const TourOptions& options)
    : tour_(tour), options_(options), id_(1) {
  validate(options, "tour");
  for (const sim::TourStep& step : tour.steps) {
    require(step.kind == "go" || step.kind == "face" || step.kind == "sweep" || step.kind == "wait",
            "steps.kind '" + step.kind + "': expected go, face, sweep or wait");
    require(step.kind != "go" || step.to_m.size() == 2,
            "steps.to_m: expected two numbers, x and y");
    needs_head_ = needs_head_ || step.kind == "sweep";
  }
}

double TourRunner::progress() const {
  if (tour_.steps.empty()) return 1.0;
  double within = 0.0;
  if (step_ < tour_.steps.size() && current().kind == "sweep") {
    within = static_cast<double>(pan_) / static_cast<double>(current().pans_deg.size() + 1);
  }
  return (static_cast<double>(step_) + within) / static_cast<double>(tour_.steps.size());
}

std::string TourRunner::state() const {
  if (outcome_ == Outcome::done) return "the tour is done";
  if (outcome_ != Outcome::running) return why_;
  if (step_ >= tour_.steps.size()) return "nothing to do";
  const sim::TourStep& step = current();
  char text[160];
  std::string what = step.kind;
  if (step.kind == "go") {
    std::snprintf(text, sizeof(text), " %.1f %.1f", step.to_m[0], step.to_m[1]);
    what += text;
  } else if (step.kind == "sweep") {
    what += " " + std::to_string(std::min(pan_ + 1, step.pans_deg.size())) + " of " +
            std::to_string(step.pans_deg.size());
  }
  if (phase_ == Phase::blocked) what += ", an obstacle is in the way";
  return what + " (step " + std::to_string(step_ + 1) + " of " +
         std::to_string(tour_.steps.size()) + ")";
}

void TourRunner::fail(Outcome outcome, const std::string& why) {
  outcome_ = outcome;
  why_ = why;
}

void TourRunner::on_base_status(const BaseStatus& status, Utime now) {
  base_ = status;
  base_heard_ = now;
}

void TourRunner::on_pantilt(const PanTiltState& state, Utime now) {
  head_ = state;
  head_heard_ = now;
}

void TourRunner::on_scan(Utime now) {
  const double period_s = (now - last_scan_).seconds();
  last_scan_ = now;
  if (period_s > 0.005 && period_s < 2.0) {
    scan_period_s_ = scan_period_s_ == 0.0 ? period_s : 0.95 * scan_period_s_ + 0.05 * period_s;
  }
}

void TourRunner::enter(Phase phase, Utime now) {
  phase_ = phase;
  phase_since_ = now;
}

bool TourRunner::links_alive(Utime now) {
  if (began_ == Utime{}) began_ = now;
  const auto silent_s = [&](Utime heard) { return (now - std::max(heard, began_)).seconds(); };
  if (silent_s(base_heard_) > options_.link_patience_s) {
    fail(Outcome::lost, "nothing is heard from the base");
  } else if (needs_head_ && silent_s(head_heard_) > options_.link_patience_s) {
    fail(Outcome::lost, "nothing is heard from the pan-tilt");
  } else if (base_ && base_->link != BaseStatus::Link::up &&
             (now - began_).seconds() > options_.link_patience_s) {
    fail(Outcome::lost, "the base's link is lost: " + base_->note);
  }
  return outcome_ == Outcome::running && base_ && base_->link == BaseStatus::Link::up &&
         (!needs_head_ || head_);
}

void TourRunner::order_base(Orders& orders, BaseCommand command, Utime now) {
  command.utime = now;
  command.id = ++id_;
  orders.base.push_back(command);
}

std::optional<Fate> TourRunner::base_fate() const {
  if (!base_ || base_->command_id != id_ || base_->command == Fate::running) return std::nullopt;
  return base_->command;
}

void TourRunner::look(
    Orders& orders, double pan_deg, double tilt_deg, double rate_deg_per_s, Utime now) {
  gaze_ = {};
  gaze_.utime = now;
  gaze_.kind = PanTiltCommand::Kind::go_to;
  gaze_.pan_rad = normalize_angle(deg_to_rad(pan_deg));
  gaze_.tilt_rad = deg_to_rad(tilt_deg);
  gaze_.tilt_rate_rad_per_s = deg_to_rad(rate_deg_per_s);
  gaze_since_ = now;
  orders.pantilt.push_back(gaze_);
}

bool TourRunner::looked() const {
  return head_ && head_->utime > gaze_since_ && head_->pan_rate_rad_per_s == 0.0 &&
         head_->tilt_rate_rad_per_s == 0.0 &&
         std::abs(normalize_angle(head_->pan_rad - gaze_.pan_rad)) < kGazeToleranceRad &&
         std::abs(head_->tilt_rad - gaze_.tilt_rad) < kGazeToleranceRad;
}

void TourRunner::begin_step(Utime now) {
  tries_ = 0;
  pan_ = 0;
  const std::string& kind = current().kind;
  if (kind == "wait") {
    enter(Phase::waiting, now);
  } else if (kind == "sweep") {
    enter(Phase::settled, now);
  } else {
    enter(Phase::measure, now);
  }
}

void TourRunner::end_step(Utime now) {
  ++step_;
  if (step_ >= tour_.steps.size()) outcome_ = Outcome::done;
  enter(Phase::next, now);
}

void TourRunner::aim(Orders& orders, Utime now) {
  // A pose measured before the last move ended tells nothing about now.
  if (!pose_ || pose_->utime < phase_since_) {
    if ((now - phase_since_).seconds() > options_.pose_patience_s) {
      fail(Outcome::lost, "no pose comes: is SLAM or the base's odometry running?");
    }
    return;
  }
  const Pose2& world_from_robot = pose_->world_from_robot;
  const bool faces = current().kind == "face";
  double turn_rad = 0.0, way_m = 0.0;
  if (faces) {
    turn_rad = normalize_angle(deg_to_rad(current().heading_deg) - world_from_robot.theta_rad);
  } else {
    const Eigen::Vector2d way =
        world_from_robot.inverse() * Eigen::Vector2d(current().to_m[0], current().to_m[1]);
    way_m = way.norm();
    turn_rad = std::atan2(way.y(), way.x());
    if (way_m < options_.arrive_m) return end_step(now);
  }
  BaseCommand command;
  if (std::abs(turn_rad) > deg_to_rad(options_.turn_first_deg)) {
    command.kind = BaseCommand::Kind::turn;
    command.angle_rad = turn_rad;
    enter(Phase::turning, now);
  } else if (faces) {
    return end_step(now);
  } else {
    command.kind = BaseCommand::Kind::move;
    command.distance_m = std::min(way_m, options_.longest_move_m);
    enter(Phase::moving, now);
  }
  order_base(orders, command, now);
}

void TourRunner::next_pan(Orders& orders, Utime now) {
  if (pan_ < current().pans_deg.size()) {
    look(orders, current().pans_deg[pan_], current().tilt_from_deg, 0.0, now);
    return enter(Phase::panning, now);
  }
  look(orders, 0.0, 0.0, 0.0, now);
  enter(Phase::homing, now);
}

TourRunner::Orders TourRunner::step(Utime now) {
  Orders orders;
  if (outcome_ != Outcome::running || !links_alive(now)) return orders;
  const double in_phase_s = (now - phase_since_).seconds();
  switch (phase_) {
    case Phase::next:
      if (tour_.steps.empty()) {
        outcome_ = Outcome::done;
      } else {
        begin_step(now);
      }
      break;
    case Phase::measure:
      aim(orders, now);
      break;
    case Phase::turning:
    case Phase::moving: {
      const auto fate = base_fate();
      if (!fate) {
        if (in_phase_s > kLegPatienceS) fail(Outcome::lost, "the base does not end its move");
      } else if (*fate == Fate::done) {
        tries_ = 0;
        enter(Phase::measure, now);
      } else if (++tries_ > options_.retries) {
        fail(Outcome::blocked, "gave up: " + base_->note);
      } else {
        enter(Phase::blocked, now);
      }
      break;
    }
    case Phase::blocked:
      if (in_phase_s > kBlockedS) enter(Phase::measure, now);
      break;
    case Phase::panning:
      if (looked()) enter(Phase::settling, now);
      break;
    case Phase::settling:
      if (in_phase_s >= options_.settle_s) {
        const double way_deg = std::abs(current().tilt_to_deg - current().tilt_from_deg);
        const double scans_per_s =
            scan_period_s_ > 0.0 ? 1.0 / scan_period_s_ : options_.scans_per_s;
        const double rate =
            std::min(way_deg * scans_per_s / current().rows, options_.sweep_max_deg_per_s);
        look(orders, current().pans_deg[pan_], current().tilt_to_deg, rate, now);
        enter(Phase::sweeping, now);
      }
      break;
    case Phase::sweeping:
      if (looked()) {
        ++pan_;
        enter(Phase::settled, now);
      }
      break;
    case Phase::settled:
      if (in_phase_s >= options_.settle_s) next_pan(orders, now);
      break;
    case Phase::homing:
      if (looked()) end_step(now);
      break;
    case Phase::waiting:
      if (in_phase_s >= current().seconds) end_step(now);
      break;
  }
  const bool gazes =
      phase_ == Phase::panning || phase_ == Phase::sweeping || phase_ == Phase::homing;
  if (gazes && (now - phase_since_).seconds() > kGazePatienceS) {
    fail(Outcome::lost, "the pan-tilt does not get where it is sent");
  }
  return orders;
}

TourRunner::Orders TourRunner::stop(Utime now) {
  Orders orders;
  order_base(orders, BaseCommand{}, now);
  PanTiltCommand halt;
  halt.utime = now;
  orders.pantilt.push_back(halt);
  return orders;
}

}  // namespace marco::teleop
