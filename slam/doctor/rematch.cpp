#include "slam/doctor/rematch.hpp"

#include "slam/matching/correlative_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"

namespace marco::slam {
namespace {

// Of path, to the keyframes that are matched together with one.
constexpr double kAroundM = 1.5;
// A better match is told where it overlaps as a loop must, explains a tenth more of the points, and
// is elsewhere by more than a loop's own error.
constexpr SearchWindow kWindow{{}, 2.0, deg_to_rad(20.0), 0.0};
constexpr double kLeastScore = 0.5, kLeastOverlap = 0.6, kLeastGain = 0.1, kLeastShiftM = 0.15;

OrientedPoints points_around(const std::vector<Keyframe>& keys, int key) {
  const auto near = [&](int other) {
    return std::abs(keys[static_cast<std::size_t>(other)].path_m -
                    keys[static_cast<std::size_t>(key)].path_m) <= kAroundM;
  };
  int first = key, last = key;
  while (first > 0 && near(first - 1)) --first;
  while (last + 1 < static_cast<int>(keys.size()) && near(last + 1)) ++last;
  return join_points(keys, first, last,
                     keys[static_cast<std::size_t>(key)].world_from_robot.inverse());
}

double overlap_at(const SurfelMatcher& matcher,
                  const SurfelPyramid& walls,
                  const OrientedPoints& points,
                  const Pose2& pose) {
  // A prior that nothing moves: the match judges this pose.
  const PosePrior held{pose, 1e12 * Eigen::Matrix3d::Identity()};
  return matcher.match(walls, points, pose, &held).overlap;
}

}  // namespace

std::optional<Rematch> match_again(const std::vector<Keyframe>& keys, int older, int newer) {
  const OrientedPoints walls = points_around(keys, older);
  const OrientedPoints seen = points_around(keys, newer);
  const Pose2 believed = between(keys[static_cast<std::size_t>(older)].world_from_robot,
                                 keys[static_cast<std::size_t>(newer)].world_from_robot);
  const CorrelativeMatcher coarse;
  const LikelihoodPyramid likelihood(
      points_within(kSearchReachM, believed.translation_m(), walls.points), coarse.options());
  SearchWindow window = kWindow;
  window.map_from_robot_centre = believed;
  const CorrelativeMatch found = coarse.search(likelihood, seen.points, window, kLeastScore);
  if (found.score < kLeastScore) return std::nullopt;
  const SurfelMatcher fine;
  SurfelPyramid surfels(fine.options(), Eigen::Vector2d::Zero());
  surfels.add(walls, Pose2{});
  const SurfelMatch match = fine.match(surfels, seen, found.map_from_robot, nullptr);
  if (match.status == SurfelMatch::Status::no_overlap) return std::nullopt;
  const Pose2 moved = between(believed, match.map_from_robot);
  const Rematch result{match.map_from_robot, moved.translation_m().norm(), moved.theta_rad,
                       match.overlap, overlap_at(fine, surfels, seen, believed)};
  const bool better = result.overlap > kLeastOverlap &&
                      result.overlap > result.overlap_before + kLeastGain &&
                      result.shift_m > kLeastShiftM;
  return better ? std::optional(result) : std::nullopt;
}

}  // namespace marco::slam
