#include "teleop/goal_drive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace marco::teleop {
namespace {

// As long as a base takes to obey, so that it comes to rest at the goal rather than behind it.
constexpr double kTurnWithinS = 0.7, kMoveWithinS = 1.0, kSettleS = 0.6;
constexpr double kSlowestM = 0.06, kSlowestRad = 0.15;  // per s: below, some wheels stand
constexpr double kAheadRad = 0.06, kAsideRad = 0.5;     // begins to move; turns again
constexpr double kTakenWithinS = 3.0;                   // a base says twice a second what it does
constexpr double kStuckS = 2.5, kStepM = 0.02, kStepRad = 0.03;

/// Slower as less is left, never so slow that nothing moves.
double speed(double left, double within_s, double slowest, double most) {
  const double size = std::min(std::max(std::abs(left) / within_s, slowest), most);
  return std::copysign(size, left);
}

}  // namespace

GoalDrive::GoalDrive(int64_t id, const Speeds& speeds, Utime now)
    : id_(id), speeds_(speeds), begun_(now), called_(now) {
  enter(Phase::turn, now);
}

void GoalDrive::enter(Phase phase, Utime now) {
  phase_ = phase;
  entered_ = now;
  progress_ = {std::numeric_limits<double>::infinity(), now};
}

void GoalDrive::end(const std::string& why) {
  if (std::exchange(is_over_, true)) return;
  why_ended_ = why;
}

void GoalDrive::on_status(const BaseStatus& status) {
  using Fate = BaseStatus::Command;
  if (status.command_id != id_) {
    // Another's order that was refused changes nothing; before ours is taken, it is of the past.
    if (!is_taken_ || is_over_ || status.command == Fate::refused) return;
    is_taken_over_ = true;
    return end("the base obeys another order");
  }
  is_taken_ = true;
  note_ = status.note;
  if (status.command != Fate::running && status.command != Fate::none) end(status.note);
}

void GoalDrive::watch(double left, Utime now) {
  const double step = phase_ == Phase::turn ? kStepRad : kStepM;
  if (left < progress_.least_left - step) {
    progress_ = {left, now};
  } else if ((now - progress_.at).seconds() > kStuckS) {
    end(note_.empty() ? "the robot comes no closer" : note_);
  }
}

bool GoalDrive::is_there(double distance_m) {
  constexpr int kMostApproaches = 5;
  constexpr double kNearer = 0.7;  // else the next approach would not help either
  ++approaches_;
  const bool helps = approaches_ == 1 || distance_m <= kNearer * nearest_m_;
  nearest_m_ = distance_m;
  return distance_m <= kNearM || approaches_ >= kMostApproaches || !helps;
}

BaseCommand GoalDrive::order(double velocity_m_per_s, double yaw_rate_rad_per_s, Utime now) const {
  BaseCommand command;
  command.kind = BaseCommand::Kind::velocity;
  command.utime = now;
  command.id = id_;
  command.velocity_m_per_s = velocity_m_per_s;
  command.yaw_rate_rad_per_s = yaw_rate_rad_per_s;
  return command;
}

/// A sender that stood still must not resume what it wanted then.
bool GoalDrive::keeps_up(Utime now) {
  if ((now - called_).seconds() > kOrderHoldsS || now < called_) end("its sender stalled");
  called_ = now;
  return !is_over_;
}

std::optional<BaseCommand> GoalDrive::hold(Utime now) {
  return keeps_up(now) ? std::optional(order(0.0, 0.0, now)) : std::nullopt;
}

std::optional<BaseCommand> GoalDrive::next(const Eigen::Vector2d& goal_m, Utime now) {
  const double distance_m = goal_m.norm(), bearing_rad = std::atan2(goal_m.y(), goal_m.x());
  if (!keeps_up(now)) return std::nullopt;
  if (!is_taken_ && (now - begun_).seconds() > kTakenWithinS) {
    end("no base accepted the order. Is its driver running, on this network?");
  }
  if (phase_ == Phase::settle) {
    if ((now - entered_).seconds() >= kSettleS) {
      if (is_there(distance_m)) end("");
      enter(Phase::turn, now);
    }
  } else {
    watch(phase_ == Phase::turn ? std::abs(bearing_rad) : goal_m.x(), now);
  }
  if (is_over_) return std::nullopt;
  if (phase_ == Phase::turn && distance_m < 0.6 * kNearM) enter(Phase::settle, now);
  if (phase_ == Phase::turn && std::abs(bearing_rad) < kAheadRad) enter(Phase::move, now);
  if (phase_ == Phase::move && goal_m.x() < 0.2 * kNearM) enter(Phase::settle, now);
  const bool is_far = distance_m > 3.0 * kNearM;  // nearer, it would turn for nothing
  if (phase_ == Phase::move && is_far && std::abs(bearing_rad) > kAsideRad) {
    enter(Phase::turn, now);
  }
  switch (phase_) {
    case Phase::turn:
      return order(0.0, speed(bearing_rad, kTurnWithinS, kSlowestRad, speeds_.most_rad_per_s), now);
    case Phase::move:
      return order(speed(goal_m.x(), kMoveWithinS, kSlowestM, speeds_.most_m_per_s),
                   is_far ? std::clamp(bearing_rad, -kAsideRad, kAsideRad) : 0.0, now);
    default:
      return order(0.0, 0.0, now);
  }
}

}  // namespace marco::teleop
