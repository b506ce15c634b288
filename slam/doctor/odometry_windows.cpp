#include "slam/doctor/odometry_windows.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "common/median.hpp"
#include "slam/doctor/doctor_gates.hpp"

namespace marco::slam {
namespace {

// One step of the comparison: nearer poses are left out, so that a standing robot drives no way.
constexpr double kStepM = 0.30, kStepRad = 10.0 * std::numbers::pi / 180.0;
constexpr double kWindowsM[] = {1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0};
// With fewer, the median and the spread around it mean nothing.
constexpr std::size_t kFewestWindows = 12, kFewestSteps = 20;
// No log teaches less noise than this.
constexpr double kFloorM = 0.03, kFloorPerM = 0.01, kFloorRad = 0.02, kFloorRadPerM = 0.005;
constexpr double kFloorRadPerRad = 0.02;
// A laser that does not sit where the log says moves by so much more while the robot turns: that is
// no break.
constexpr double kLeverM = 0.5;
constexpr double kBreakM = 0.25, kBreakPerM = 0.05, kBreakRad = 0.2;
// A longer window says nothing where the odometry's heading is lost on the way.
constexpr double kLostRad = 0.3;

struct Step {
  Utime utime;
  Pose2 map;
  Pose2 odometry;
  double path_m;    ///< along the map's path
  double turn_rad;  ///< the same of turns to either side, by the odometry
};

std::vector<Step> steps_of(const Trajectory& path, const Trajectory& odometry) {
  std::vector<Step> steps;
  auto other = odometry.begin();
  for (const StampedPose2& pose : path) {
    const auto found = std::find_if(other, std::min(other + 50, odometry.end()),
                                    [&](const StampedPose2& o) { return o.utime == pose.utime; });
    if (found == std::min(other + 50, odometry.end())) continue;
    other = found + 1;
    const Pose2& now = pose.world_from_robot;
    if (steps.empty()) {
      steps.push_back({pose.utime, now, found->world_from_robot, 0.0, 0.0});
      continue;
    }
    const Pose2 moved = between(steps.back().map, now);
    const double way_m = moved.translation_m().norm();
    if (way_m < kStepM && std::abs(moved.theta_rad) < kStepRad) continue;
    const double turn_rad = between(steps.back().odometry, found->world_from_robot).theta_rad;
    steps.push_back({pose.utime, now, found->world_from_robot, steps.back().path_m + way_m,
                     steps.back().turn_rad + std::abs(turn_rad)});
  }
  return steps;
}

// The way by the map for a metre by the odometry, from windows that go nearly straight on.
double scale_of(const std::vector<OdometryBreak>& windows) {
  constexpr double kStraightRad = 0.2;  // the chord is 0.2 % shorter than the arc
  constexpr double kMost = 2.0;         // a larger ratio is no scale, but a wrong map
  std::vector<double> ratios;
  for (const OdometryBreak& window : windows) {
    const double odometry_m = window.odometry.translation_m().norm();
    if (std::abs(window.map.theta_rad) > kStraightRad || odometry_m < 0.5 * window.length_m)
      continue;
    ratios.push_back(window.map.translation_m().norm() / odometry_m);
  }
  return ratios.size() < kFewestWindows ? 1.0 : std::clamp(median(ratios), 1.0 / kMost, kMost);
}

// By how far each window's two paths differ, and by how much they may at least.
struct Differences {
  std::vector<double> values;
  std::vector<double> floors;

  void add(double value, double floor) {
    values.push_back(value);
    floors.push_back(floor);
  }
  /// In units of its floor, or of what the others differ by where that is more.
  double unit() const {
    std::vector<double> off;
    for (std::size_t i = 0; i < values.size(); ++i) off.push_back(std::abs(values[i]) / floors[i]);
    return std::max(1.0, kSigmaOfMedian * median(off));
  }
};

double correlation(const std::vector<Eigen::Vector2d>& pairs) {
  if (pairs.size() < kFewestSteps) return 0.0;
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (const Eigen::Vector2d& pair : pairs) {
    xx += pair.x() * pair.x();
    yy += pair.y() * pair.y();
    xy += pair.x() * pair.y();
  }
  return xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
}

// The same of ways, whichever way the laser looks.
struct Ways {
  void add(const Eigen::Vector2d& map, const Eigen::Vector2d& odometry) {
    const std::complex<double> by_map(map.x(), map.y()), counted(odometry.x(), odometry.y());
    both += std::conj(counted) * by_map;
    map2 += std::norm(by_map);
    odometry2 += std::norm(counted);
    ++count;
  }
  double correlation() const {
    if (count < kFewestSteps || !(map2 * odometry2 > 0.0)) return 0.0;
    return std::copysign(std::abs(both) / std::sqrt(map2 * odometry2), both.real());
  }

  std::complex<double> both;
  double map2 = 0.0, odometry2 = 0.0;
  std::size_t count = 0;
};

std::vector<OdometryBreak> windows_of(const std::vector<Step>& steps, double window_m) {
  std::vector<OdometryBreak> windows;
  for (std::size_t first = 0, last = 0; first < steps.size(); ++first) {
    while (last < steps.size() && steps[last].path_m - steps[first].path_m < window_m) ++last;
    if (last == steps.size()) break;
    const Step &from = steps[first], &to = steps[last];
    windows.push_back({from.utime, to.utime, window_m, between(from.map, to.map),
                       between(from.odometry, to.odometry), to.map, to.turn_rad - from.turn_rad,
                       0.0, false, 0.0});
  }
  return windows;
}

std::vector<OdometryBreak> breaks_of(const std::vector<Step>& steps, double window_m) {
  std::vector<OdometryBreak> windows = windows_of(steps, window_m);
  if (windows.size() < kFewestWindows) return {};
  const double scale = scale_of(windows);
  Differences longer_m, turned_rad;
  for (const OdometryBreak& window : windows) {
    const double off_m =
        window.map.translation_m().norm() - scale * window.odometry.translation_m().norm();
    const double lever_m = 2.0 * kLeverM * std::abs(std::sin(0.5 * window.map.theta_rad));
    longer_m.add(std::copysign(std::max(0.0, std::abs(off_m) - lever_m), off_m),
                 kFloorM + kFloorPerM * window_m);
    turned_rad.add(normalize_angle(window.map.theta_rad - window.odometry.theta_rad),
                   kFloorRad + kFloorRadPerM * window_m + kFloorRadPerRad * window.turned_rad);
  }
  const double unit_m = longer_m.unit(), unit_rad = turned_rad.unit();
  if (unit_rad * median(turned_rad.floors) > kLostRad) return {};
  std::vector<OdometryBreak> breaks;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const double off_m = std::abs(longer_m.values[i]), off_rad = std::abs(turned_rad.values[i]);
    double& sigmas = windows[i].sigmas;
    windows[i].longer_m = longer_m.values[i];
    if (off_m > kBreakM + kBreakPerM * window_m) sigmas = off_m / (unit_m * longer_m.floors[i]);
    const double turn_sigmas =
        off_rad > kBreakRad ? off_rad / (unit_rad * turned_rad.floors[i]) : 0.0;
    windows[i].is_turn = turn_sigmas > sigmas;
    sigmas = std::max(sigmas, turn_sigmas);
    if (sigmas > doctor_gates::kBreakSigmas) breaks.push_back(windows[i]);
  }
  return breaks;
}

}  // namespace

std::optional<Pose2> way_by_odometry(const Trajectory& odometry, Utime from, Utime to) {
  const auto at = [&odometry](Utime utime) {
    return std::find_if(odometry.begin(), odometry.end(),
                        [utime](const StampedPose2& pose) { return pose.utime == utime; });
  };
  const auto first = at(from), last = at(to);
  if (first == odometry.end() || last == odometry.end()) return std::nullopt;
  return between(first->world_from_robot, last->world_from_robot);
}

OdometryAgreement compare_with_odometry(const Trajectory& path, const Trajectory& odometry) {
  OdometryAgreement result;
  const std::vector<Step> steps = steps_of(path, odometry);
  std::vector<Eigen::Vector2d> turns;
  Ways ways;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const Pose2 map = between(steps[i - 1].map, steps[i].map);
    const Pose2 odometry_step = between(steps[i - 1].odometry, steps[i].odometry);
    turns.emplace_back(map.theta_rad, odometry_step.theta_rad);
    ways.add(map.translation_m(), odometry_step.translation_m());
    result.present |= odometry_step.translation_m().norm() > 0.1 * kStepM;
  }
  result.turn_correlation = correlation(turns);
  result.way_correlation = ways.correlation();
  if (!result.present) return result;
  std::vector<OdometryBreak> all;
  for (const double window_m : kWindowsM) {
    const std::vector<OdometryBreak> some = breaks_of(steps, window_m);
    all.insert(all.end(), some.begin(), some.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const OdometryBreak& a, const OdometryBreak& b) {
    return a.sigmas > b.sigmas;
  });
  for (const OdometryBreak& one : all) {
    const bool apart = std::all_of(
        result.breaks.begin(), result.breaks.end(),
        [&](const OdometryBreak& other) { return one.to < other.from || other.to < one.from; });
    if (apart) result.breaks.push_back(one);
  }
  return result;
}

}  // namespace marco::slam
