#include "teleop/goal_drive.hpp"

namespace marco::teleop {

GoalDrive::Next GoalDrive::on_status(const BaseStatus& status, double distance_m) {
  if (status.command_id != id_) return is_taken_ ? Next::ended : Next::wait;
  is_taken_ = true;
  switch (status.command) {
    case BaseStatus::Command::shortened:
    case BaseStatus::Command::refused:
    case BaseStatus::Command::aborted:
      return Next::ended;
    case BaseStatus::Command::done:
      break;
    default:
      return Next::wait;
  }
  constexpr int kMostLegs = 5;
  constexpr double kNearer = 0.7;  // else the next leg would not help either
  if (distance_m <= kNearM || legs_ >= kMostLegs) return Next::there;
  if (legs_ > 1 && distance_m > kNearer * nearest_m_) return Next::there;
  nearest_m_ = distance_m;
  return Next::again;
}

}  // namespace marco::teleop
