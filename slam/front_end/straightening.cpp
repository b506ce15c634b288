#include "slam/front_end/straightening.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace marco::slam {
namespace {

// Each halves what the one before has left, and more.
constexpr int kMostTimes = 2;

// A change that moves no hit by more does not matter: it is less than the noise of a range.
constexpr double kMattersM = 0.005;

// By how much fewer of its points may fit: as many as change by chance.
constexpr double kAsManyFit = 0.02;

// A turn during the scan that moves the walls of a room by more than they are thick.
const double kTellsRad = deg_to_rad(4.0);

// A scan that is bent by half of this between its first beam and its last is straightened by its
// own match.
const double kStraightenedRad = deg_to_rad(16.0);

// Nothing bends a shorter one.
constexpr double kLongScanS = 0.05;

double span_s(const std::vector<float>& times_s) {
  if (times_s.empty()) return 0.0;
  const auto [first, last] = std::minmax_element(times_s.begin(), times_s.end());
  return static_cast<double>(*last) - static_cast<double>(*first);
}

std::vector<float> times_of_hits_s(const DeskewedScan& scan, const std::vector<float>& times_s) {
  std::vector<float> of_hits_s;
  of_hits_s.reserve(scan.beam_of_hit.size());
  for (const int32_t beam : scan.beam_of_hit) {
    of_hits_s.push_back(times_s.at(static_cast<std::size_t>(beam)));
  }
  return of_hits_s;
}

// The farthest that a hit moves, about the scan's middle.
double farthest_move_m(const DeskewedScan& scan, const Velocity2& velocity) {
  if (scan.time_of_hit_s.empty()) return 0.0;
  const double half_s = 0.5 * span_s(scan.time_of_hit_s);
  const double range_m = std::sqrt(scan.hits_in_robot.colwise().squaredNorm().maxCoeff());
  const double moves = std::hypot(velocity.ahead_m_per_s - scan.velocity.ahead_m_per_s,
                                  velocity.left_m_per_s - scan.velocity.left_m_per_s);
  const double turns = std::abs(velocity.yaw_rad_per_s - scan.velocity.yaw_rad_per_s);
  return half_s * (moves + turns * range_m);
}

}  // namespace

MatchedScan Straightening::again(const MatchedScan& scan,
                                 std::vector<float> time_of_hit_s,
                                 const Velocity2& velocity) const {
  const Pose2 world_from_middle = scan.match.world_from_robot * first_from_middle(scan.scan);
  MatchedScan result;
  result.scan = deskewed_again(scan.scan, std::move(time_of_hit_s), velocity);
  result.points = orient(result.scan.hits_in_robot, result.scan.sensor_in_robot, with_.normals,
                         scan.points.range_sigma_m);
  const Pose2 middle_from_first = first_from_middle(result.scan).inverse();
  PosePrior prior = prior_;
  prior.map_from_robot = predicted_middle_ * middle_from_first;
  result.match = with_.matcher.match_again(result.points, world_from_middle * middle_from_first,
                                           prior, with_.map);
  return result;
}

std::optional<Velocity2> Straightening::velocity_of(const MatchedScan& scan) const {
  const Pose2 world_from_middle = scan.match.world_from_robot * first_from_middle(scan.scan);
  return with_.motion.velocity_to(utime_, between(with_.world_from_before, world_from_middle));
}

MatchedScan Straightening::straightened(MatchedScan scan) const {
  for (int time = 0; time < kMostTimes && scan.match.usable; ++time) {
    const auto velocity = velocity_of(scan);
    if (!velocity || farthest_move_m(scan.scan, *velocity) < kMattersM) break;
    MatchedScan next = again(scan, scan.scan.time_of_hit_s, *velocity);
    if (!next.match.usable || next.match.overlap < scan.match.overlap - kAsManyFit) break;
    scan = std::move(next);
  }
  return scan;
}

std::vector<DeskewedScan> Straightening::bent(const DeskewedScan& scan,
                                              double max_turn_rate_rad_per_s) {
  const double long_s = span_s(scan.time_of_hit_s);
  std::vector<DeskewedScan> bent;
  if (long_s < kLongScanS) return bent;
  const double step_rad_per_s = kStraightenedRad / long_s;
  const double farthest = max_turn_rate_rad_per_s + std::abs(scan.velocity.yaw_rad_per_s);
  for (int step = 1; step * step_rad_per_s <= farthest; ++step) {
    for (const double sign : {-1.0, 1.0}) {
      Velocity2 velocity = scan.velocity;
      velocity.yaw_rad_per_s += sign * step * step_rad_per_s;
      if (std::abs(velocity.yaw_rad_per_s) > max_turn_rate_rad_per_s) continue;
      bent.push_back(deskewed_again(scan, scan.time_of_hit_s, velocity));
    }
  }
  return bent;
}

std::vector<double> Straightening::misfits_m2(
    const MatchedScan& scan, const std::vector<std::vector<float>>& rival_times_s) const {
  const auto velocity = velocity_of(scan);
  if (!scan.match.usable || !velocity) return {};
  double turn_rad = 0.0;
  for (const std::vector<float>& times_s : rival_times_s) {
    turn_rad = std::max(turn_rad, std::abs(velocity->yaw_rad_per_s) * span_s(times_s));
  }
  if (turn_rad < kTellsRad) return {};
  // All alike, the scan as it is included.
  std::vector<double> misfits_m2{again(scan, scan.scan.time_of_hit_s, *velocity).match.misfit_m2};
  for (const std::vector<float>& times_s : rival_times_s) {
    std::vector<float> of_hits_s = times_of_hits_s(scan.scan, times_s);
    const MatchedScan rival = again(scan, std::move(of_hits_s), *velocity);
    misfits_m2.push_back(rival.match.misfit_m2);
  }
  return misfits_m2;
}

}  // namespace marco::slam
