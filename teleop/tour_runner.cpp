#include "teleop/tour_runner.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/format.hpp"

namespace marco::teleop {
namespace {

using Fate = BaseStatus::Command;

constexpr double kGazeToleranceRad = deg_to_rad(1.6);  // a unit of the pan is 1.45 deg
constexpr double kGazePatienceS = 120.0;
constexpr double kLegPatienceS = 120.0;
constexpr double kBlockedS = 2.0;

}  // namespace

void TourLinks::on_base(const BaseStatus& status, Utime now) {
  base_ = status;
  base_heard_ = now;
}

void TourLinks::on_head(const PanTiltState& state, Utime now) {
  head_ = state;
  head_heard_ = now;
}

std::string TourLinks::trouble(double patience_s, Utime now) {
  if (began_ == Utime{}) began_ = now;
  const auto silent = [&](Utime heard) {
    return (now - std::max(heard, began_)).seconds() > patience_s;
  };
  if (silent(base_heard_)) return "no data from the base";
  if (needs_head_ && silent(head_heard_)) return "no data from the pan-tilt";
  const bool down = base_ && base_->link != BaseStatus::Link::up;
  if (down && (now - began_).seconds() > patience_s) {
    return "the base's link is lost: " + base_->note;
  }
  return "";
}

bool TourLinks::ready() const {
  return base_ && base_->link == BaseStatus::Link::up && (!needs_head_ || head_);
}

void ScanRate::on_scan(Utime now) {
  const double period_s = (now - last_scan_).seconds();
  last_scan_ = now;
  if (period_s <= 0.005 || period_s >= 2.0) return;
  period_s_ = period_s_ == 0.0 ? period_s : 0.95 * period_s_ + 0.05 * period_s;
}

double ScanRate::scans_per_s(double until_known) const {
  return period_s_ > 0.0 ? 1.0 / period_s_ : until_known;
}

TourRunner::TourRunner(const sim::Tour& tour, const TourOptions& options)
    : tour_(tour), options_(options), id_(1) {
  validate(options, "tour");
  for (const sim::TourStep& step : tour.steps) {
    require(step.kind == "go" || step.kind == "face" || step.kind == "sweep" || step.kind == "wait",
            "steps.kind '" + step.kind + "': expected go, face, sweep or wait");
    require(step.kind != "go" || step.to_m.size() == 2,
            "steps.to_m: expected two numbers, x and y");
    if (step.kind == "sweep") links_.need_head();
  }
}

double TourRunner::progress() const {
  if (tour_.steps.empty()) return 1.0;
  double within = 0.0;
  if (place_.step < tour_.steps.size() && current().kind == "sweep") {
    within = static_cast<double>(place_.pan) / static_cast<double>(current().pans_deg.size() + 1);
  }
  return (static_cast<double>(place_.step) + within) / static_cast<double>(tour_.steps.size());
}

std::string TourRunner::state() const {
  if (outcome_ == Outcome::done) return "the tour is done";
  if (outcome_ != Outcome::running) return why_;
  if (place_.step >= tour_.steps.size()) return "nothing to do";
  const sim::TourStep& step = current();
  std::string what = step.kind;
  if (step.kind == "go") {
    what += format(" %.1f %.1f", step.to_m[0], step.to_m[1]);
  } else if (step.kind == "sweep") {
    what += " " + std::to_string(std::min(place_.pan + 1, step.pans_deg.size())) + " of " +
            std::to_string(step.pans_deg.size());
  }
  if (phase_ == Phase::blocked) what += ", an obstacle is in the way";
  return what + " (step " + std::to_string(place_.step + 1) + " of " +
         std::to_string(tour_.steps.size()) + ")";
}

void TourRunner::fail(Outcome outcome, const std::string& why) {
  outcome_ = outcome;
  why_ = why;
}

void TourRunner::enter(Phase phase, Utime now) {
  phase_ = phase;
  phase_since_ = now;
}

void TourRunner::order_base(Orders& orders, BaseCommand command, Utime now) {
  command.utime = now;
  command.id = ++id_;
  orders.base.push_back(command);
}

std::optional<Fate> TourRunner::base_fate() const {
  const std::optional<BaseStatus>& base = links_.base();
  if (!base || base->command_id != id_ || base->command == Fate::running) return std::nullopt;
  return base->command;
}

void TourRunner::look(
    Orders& orders, double pan_deg, double tilt_deg, double rate_deg_per_s, Utime now) {
  gaze_ = {};
  gaze_.since = gaze_.command.utime = now;
  gaze_.command.kind = PanTiltCommand::Kind::go_to;
  gaze_.command.pan_rad = normalize_angle(deg_to_rad(pan_deg));
  gaze_.command.tilt_rad = deg_to_rad(tilt_deg);
  gaze_.command.tilt_rate_rad_per_s = deg_to_rad(rate_deg_per_s);
  orders.pantilt.push_back(gaze_.command);
}

bool TourRunner::looked() const {
  const std::optional<PanTiltState>& head = links_.head();
  return head && head->utime > gaze_.since && head->pan_rate_rad_per_s == 0.0 &&
         head->tilt_rate_rad_per_s == 0.0 &&
         std::abs(normalize_angle(head->pan_rad - gaze_.command.pan_rad)) < kGazeToleranceRad &&
         std::abs(head->tilt_rad - gaze_.command.tilt_rad) < kGazeToleranceRad;
}

void TourRunner::begin_step(Utime now) {
  place_.tries = 0;
  place_.pan = 0;
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
  ++place_.step;
  if (place_.step >= tour_.steps.size()) outcome_ = Outcome::done;
  enter(Phase::next, now);
}

void TourRunner::aim(Orders& orders, Utime now) {
  // A pose measured before the last move ended is out of date.
  if (!pose_ || pose_->utime < phase_since_) {
    if ((now - phase_since_).seconds() > options_.pose_patience_s) {
      fail(Outcome::lost, "no pose arrives: is SLAM or the base's odometry running?");
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
  if (place_.pan < current().pans_deg.size()) {
    look(orders, current().pans_deg[place_.pan], current().tilt_from_deg, 0.0, now);
    return enter(Phase::panning, now);
  }
  look(orders, 0.0, 0.0, 0.0, now);
  enter(Phase::homing, now);
}

void TourRunner::watch_leg(double since_s, Utime now) {
  const auto fate = base_fate();
  if (!fate) {
    if (since_s > kLegPatienceS) fail(Outcome::lost, "the base does not finish its move");
  } else if (*fate == Fate::done) {
    place_.tries = 0;
    enter(Phase::measure, now);
  } else if (++place_.tries > options_.retries) {
    fail(Outcome::blocked, "gave up: " + links_.base()->note);
  } else {
    enter(Phase::blocked, now);
  }
}

void TourRunner::sweep(Orders& orders, Utime now) {
  const sim::TourStep& step = current();
  const double way_deg = std::abs(step.tilt_to_deg - step.tilt_from_deg);
  const double rate = std::min(way_deg * scan_rate_.scans_per_s(options_.scans_per_s) / step.rows,
                               options_.sweep_max_deg_per_s);
  look(orders, step.pans_deg[place_.pan], step.tilt_to_deg, rate, now);
  enter(Phase::sweeping, now);
}

TourRunner::Orders TourRunner::step(Utime now) {
  Orders orders;
  if (outcome_ != Outcome::running) return orders;
  if (const std::string why = links_.trouble(options_.link_patience_s, now); !why.empty()) {
    fail(Outcome::lost, why);
  } else if (links_.ready()) {
    act(orders, now);
  }
  return orders;
}

void TourRunner::act(Orders& orders, Utime now) {
  const double since_s = (now - phase_since_).seconds();
  const bool settled = since_s >= options_.settle_s;
  switch (phase_) {
    case Phase::next:
      if (!tour_.steps.empty()) return begin_step(now);
      outcome_ = Outcome::done;
      return;
    case Phase::measure:
      return aim(orders, now);
    case Phase::turning:
    case Phase::moving:
      return watch_leg(since_s, now);
    case Phase::blocked:
      if (since_s > kBlockedS) enter(Phase::measure, now);
      return;
    case Phase::panning:
      if (looked()) return enter(Phase::settling, now);
      break;
    case Phase::settling:
      if (settled) sweep(orders, now);
      return;
    case Phase::sweeping:
      if (!looked()) break;
      ++place_.pan;
      return enter(Phase::settled, now);
    case Phase::settled:
      if (settled) next_pan(orders, now);
      return;
    case Phase::homing:
      if (looked()) return end_step(now);
      break;
    case Phase::waiting:
      if (since_s >= current().seconds) end_step(now);
      return;
  }
  if (since_s > kGazePatienceS) {
    fail(Outcome::lost, "the pan-tilt does not reach its goal");
  }
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
