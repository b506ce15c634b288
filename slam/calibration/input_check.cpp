#include "slam/calibration/input_check.hpp"

#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

// Of the tested delays; a parabola through three of them gives the rest.
constexpr double kStepS = 0.05;
constexpr int kReach = static_cast<int>(kMostLateS / kStepS);

struct Sums {
  double laser2 = 0.0, other2 = 0.0, product = 0.0;

  double slope() const { return other2 > 0.0 ? product / other2 : 0.0; }
  double left_over() const { return laser2 - slope() * product; }
  double correlation() const {
    const double scale = std::sqrt(laser2 * other2);
    return scale > 0.0 ? product / scale : 0.0;
  }
};

Sums sums_at(const std::vector<LaserMotion>& motions, const OdometryTravel& travel, double late_s) {
  Sums sums;
  for (const LaserMotion& motion : motions) {
    const double laser = motion.moved.theta_rad;
    const double other =
        travel.between_moments(motion.begin_s + late_s, motion.end_s + late_s).turn_rad;
    sums.laser2 += laser * laser;
    sums.other2 += other * other;
    sums.product += laser * other;
  }
  return sums;
}

// The laser surely moved: errors of matched scans are smaller.
constexpr double kClearM = 0.05, kClearDeg = 3.0;

bool laser_moves(const LaserMotion& motion, InputKind kind) {
  return std::abs(motion.moved.theta_rad) > deg_to_rad(kClearDeg) ||
         (kind == InputKind::odometry && motion.moved.translation_m().norm() > kClearM);
}

// However late: nothing moved around the motion.
bool stands_still(const LaserMotion& motion, const OdometryTravel& travel) {
  constexpr double kAroundS = 0.5;                    // the latest input that is looked for
  constexpr double kStillM = 1e-3, kStillDeg = 0.05;  // a count or two of encoders
  const ArcMotion counted =
      travel.between_moments(motion.begin_s - kAroundS, motion.end_s + kAroundS);
  return std::hypot(counted.ahead_m, counted.left_m) < kStillM &&
         std::abs(counted.turn_rad) < deg_to_rad(kStillDeg);
}

InputState state_of(const InputCheck& check, int moved, int stalled) {
  // Of fewer nothing is concluded. A correlation of 50 turns with an input that has nothing to do
  // with them has a standard deviation of 0.14: 0.3 is two of them.
  constexpr int kFewestMotions = 10, kFewestTurns = 50;
  constexpr double kLeastCorrelation = 0.3;
  // Matching is wrong now and then, so neither is all or nothing.
  constexpr double kStalledShare = 0.05, kConstantShare = 0.95;
  if (moved < kFewestMotions) return InputState::none;
  if (stalled > kConstantShare * moved) return InputState::constant;
  if (check.turns.turns >= kFewestTurns && std::abs(check.turns.correlation) < kLeastCorrelation) {
    return InputState::foreign;
  }
  return stalled > kStalledShare * moved ? InputState::stalled : InputState::good;
}

}  // namespace

TurnCorrelation correlate_turns(const std::vector<LaserMotion>& motions,
                                const OdometryTravel& travel) {
  TurnCorrelation result;
  if (motions.size() < 3) return result;
  for (const LaserMotion& motion : motions) {
    if (std::abs(motion.moved.theta_rad) > deg_to_rad(kClearDeg)) ++result.turns;
  }
  std::array<Sums, 2 * kReach + 1> sums;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i] = sums_at(motions, travel, kStepS * (static_cast<int>(i) - kReach));
  }
  const auto best = std::min_element(sums.begin(), sums.end(), [](const Sums& a, const Sums& b) {
    return a.left_over() < b.left_over();
  });
  result.correlation = best->correlation();
  result.slope = best->slope();
  if (best == sums.begin() || best + 1 == sums.end()) return result;
  const double before = (best - 1)->left_over(), after = (best + 1)->left_over();
  const double bend = before - 2.0 * best->left_over() + after;
  if (!(bend > 0.0)) return result;
  result.is_late_found = true;
  result.late_s = kStepS * (static_cast<int>(best - sums.begin()) - kReach) +
                  0.5 * kStepS * (before - after) / bend;
  const double variance = best->left_over() / static_cast<double>(motions.size() - 2);
  result.sigma_late_s = std::sqrt(2.0 * variance * kStepS * kStepS / bend);
  return result;
}

const char* to_string(InputState state) {
  switch (state) {
    case InputState::good:
      return "moves as the laser does";
    case InputState::constant:
      return "never moves";
    case InputState::stalled:
      return "stands still at times";
    case InputState::foreign:
      return "turns unlike the laser";
    case InputState::none:
      break;
  }
  return "none";
}

InputCheck check_input(const std::vector<LaserMotion>& motions,
                       const OdometryTravel& travel,
                       InputKind kind) {
  InputCheck check;
  int moved = 0, stalled = 0;
  for (const LaserMotion& motion : motions) {
    const bool moves = laser_moves(motion, kind);
    const bool still = moves && stands_still(motion, travel);
    moved += moves;
    stalled += still;
    if (!still) check.moving.push_back(motion);
  }
  check.stalled_share = moved > 0 ? static_cast<double>(stalled) / moved : 0.0;
  check.turns = correlate_turns(check.moving, travel);
  check.state = state_of(check, moved, stalled);
  return check;
}

}  // namespace marco::slam
