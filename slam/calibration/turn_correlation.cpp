#include "slam/calibration/turn_correlation.hpp"

#include <algorithm>
#include <array>
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

}  // namespace

TurnCorrelation correlate_turns(const std::vector<LaserMotion>& motions,
                                const OdometryTravel& travel) {
  constexpr double kTurnDeg = 3.0;  // as laser_moves in input_check.cpp
  TurnCorrelation result;
  if (motions.size() < 3) return result;
  for (const LaserMotion& motion : motions) {
    if (std::abs(motion.moved.theta_rad) > deg_to_rad(kTurnDeg)) ++result.turns;
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

}  // namespace marco::slam
