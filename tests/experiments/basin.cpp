// How far off a match may start: basin [matches a cell]. In the room of table 5.1 a scan 50 cm from
// one keyframe is matched from a start that is off by so much in any direction, with and without
// the correlative search before it. Printed: percent of the matches that end within 5 cm and 1 deg.
#include <array>
#include <cstdio>
#include <cstdlib>

#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"
#include "tests/support/matching_table.hpp"

namespace marco::slam {
namespace {

constexpr std::array<double, 6> kShiftsM = {0.1, 0.2, 0.5, 1.0, 1.5, 2.0};
constexpr std::array<double, 6> kTurnsDeg = {5, 10, 20, 30, 60, 90};

struct Case {
  Points2 key, scan;
  Pose2 truth, start;
};

Case draw(const testing::MatchingWorld& world,
          double shift_m,
          double turn_deg,
          std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  testing::MatchingLaser laser;
  laser.outlier_part = 0.05;
  const Pose2 here{4.0 + 0.9 * uniform(random), 3.4 + 0.6 * uniform(random),
                   std::numbers::pi * uniform(random)};
  const Pose2 move{0.5 * uniform(random), 0.0, deg_to_rad(25.0) * uniform(random)};
  const double way = std::numbers::pi * uniform(random);
  const double sign = uniform(random) > 0.0 ? 1.0 : -1.0;
  Pose2 start = move;
  start.x_m += shift_m * std::cos(way);
  start.y_m += shift_m * std::sin(way);
  start.theta_rad = normalize_angle(start.theta_rad + sign * deg_to_rad(turn_deg));
  Case result{testing::take_scan(world, here, laser, random).points_in_robot,
              testing::take_scan(world, here * move, laser, random).points_in_robot, move, start};
  return result;
}

bool found(const Pose2& pose, const Pose2& truth) {
  const Pose2 off = between(truth, pose);
  return off.translation_m().norm() < 0.05 && std::abs(off.theta_rad) < deg_to_rad(1.0);
}

// The window is twice as wide as the error of the start, which one does not know.
Pose2 searched(const CorrelativeMatcher& coarse, const Case& c, double shift_m, double turn_deg) {
  SearchWindow window;
  window.map_from_robot_centre = c.start;
  window.half_width_m = 2.0 * shift_m;
  window.half_turn_rad = std::min(std::numbers::pi, deg_to_rad(2.0 * turn_deg));
  const LikelihoodPyramid likelihood(c.key, coarse.options());
  const CorrelativeMatch match = coarse.search(likelihood, c.scan, window, 0.2);
  return match.score > 0.0 ? match.map_from_robot : c.start;
}

void print_table(int count) {
  const testing::MatchingWorld world = testing::matching_room();
  const SurfelMatcher fine;
  const CorrelativeMatcher coarse;
  std::printf("percent found, fine match alone / after the correlative search; %d a cell\n", count);
  std::printf("  off by");
  for (const double turn_deg : kTurnsDeg) std::printf("  %7.0f deg", turn_deg);
  std::puts("");
  for (const double shift_m : kShiftsM) {
    std::printf("%6.1f m", shift_m);
    for (const double turn_deg : kTurnsDeg) {
      std::mt19937 random(17);
      int alone = 0, after = 0;
      for (int i = 0; i < count; ++i) {
        const Case c = draw(world, shift_m, turn_deg, random);
        SurfelPyramid map({}, {0, 0});
        map.add(orient(c.key, {0, 0}, {}), Pose2{});
        const OrientedPoints scan = orient(c.scan, {0, 0}, {});
        const Pose2 start = searched(coarse, c, shift_m, turn_deg);
        alone += found(fine.match(map, scan, c.start, nullptr).map_from_robot, c.truth) ? 1 : 0;
        after += found(fine.match(map, scan, start, nullptr).map_from_robot, c.truth) ? 1 : 0;
      }
      std::printf("   %3d / %3d", 100 * alone / count, 100 * after / count);
      std::fflush(stdout);
    }
    std::puts("");
  }
}

}  // namespace
}  // namespace marco::slam

int main(int argc, char** argv) {
  marco::slam::print_table(argc > 1 ? std::max(1, std::atoi(argv[1])) : 100);
  return 0;
}
