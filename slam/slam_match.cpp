#include "slam/slam.hpp"

#include <cmath>

#include "common/covariance.hpp"
#include "common/input/beam_times.hpp"
#include "common/input/deskew.hpp"
#include "slam/front_end/straightening.hpp"

// How a scan is matched: as it was deskewed, bent otherwise, and at the constant-velocity
// prediction.
namespace marco::slam {

SlamInput slam_input(const SynchronizedScan& scan, const ScanVelocity& velocity) {
  SlamInput input;
  input.scan = deskew_and_project(scan.scan, scan.info, scan.robot_from_sensor, velocity.velocity);
  input.deskewed_by_odometry = velocity.by_odometry;
  input.motion = scan.motion;
  input.level = scan.level;
  for (const BeamOrder order : scan.beam_order.rivals) {
    input.rival_times_s.push_back(
        reordered_times_s(scan.scan, scan.motion.scan_period_s, *scan.beam_order.order, order));
  }
  return input;
}

MatchedScan Slam::matched_as_is(DeskewedScan scan,
                                const PosePrior& prior,
                                MotionGuess::Source source,
                                ScanMatcher::Search search) {
  MatchedScan matched{std::move(scan), {}, {prior.map_from_robot}, {}};
  matched.points = orient(matched.scan.hits_in_robot, matched.scan.sensor_in_robot,
                          options_.normals, noise_.sigma_m());
  if (!local_map_.empty()) {
    matched.match = matcher_.match(matched.points, prior, source, keyframes_, local_map_, search);
  }
  return matched;
}

MatchedScan Slam::matched_scan(const SlamInput& input,
                               const PosePrior& prior,
                               MotionGuess::Source source) {
  noise_.add(input.scan.hits_in_robot, input.scan.sensor_in_robot);
  MatchedScan best = matched_as_is(input.scan, prior, source);
  const bool refines = input.scan.hits_in_robot.cols() < options_.gates.min_points;
  if (local_map_.empty() || refines) return best;
  const Straightening straightening(
      {matcher_, options_.normals, local_map_, motion_, estimate_.world_from_robot},
      input.motion.utime, prior, first_from_middle(input.scan));
  if (!input.deskewed_by_odometry) best = straightening.straightened(std::move(best));
  // Odometry that stands still is believed until it has missed a turn.
  const double sure =
      input.deskewed_by_odometry ? options_.gates.good_overlap : options_.gates.sure_overlap;
  if (best.match.overlap < sure) {
    best = best_bent(std::move(best), input.scan, straightening, prior, source);
  }
  if (source == MotionGuess::Source::odometry && best.match.overlap < options_.gates.sure_overlap) {
    try_where_velocity_says(input.motion, best);
  }
  best.misfits_m2 = straightening.misfits_m2(best, input.rival_times_s);
  return best;
}

void Slam::try_where_velocity_says(const MotionInput& input, MatchedScan& best) {
  MotionInput motion = input;
  motion.first_from_middle = first_from_middle(best.scan);
  const MotionGuess guess = motion_.guess_by_velocity(motion);
  if (guess.source != MotionGuess::Source::velocity) return;
  const PosePrior prior = prior_of(dead_reckoned(estimate_, guess.before_from_now, guess.drift));
  const Pose2 off = between(prior.map_from_robot, best.match.world_from_robot);
  if (off.translation_m().norm() <= match_gates::kSameStartM &&
      std::abs(off.theta_rad) <= deg_to_rad(match_gates::kSameStartDeg)) {
    return;
  }
  const ScanMatch there = matcher_.match(best.points, prior, guess.source, keyframes_, local_map_);
  const auto points = static_cast<double>(best.points.points.cols());
  if (there.usable && proves_lie(there.overlap, best.match.overlap, points)) {
    best.match = there;
  }
}

// The robot may have begun or ceased to turn, or turn the other way.
MatchedScan Slam::best_bent(MatchedScan best,
                            const DeskewedScan& predicted,
                            const Straightening& straightening,
                            const PosePrior& prior,
                            MotionGuess::Source source) {
  const double limit_rad_per_s = deg_to_rad(options_.motion.max_turn_rate_deg_per_s);
  for (DeskewedScan& bent : Straightening::bent(predicted, limit_rad_per_s)) {
    // A scan that fits is where it fits, whatever its shape. One that does not was searched
    // everywhere as it was predicted.
    const bool fits = best.match.usable && best.match.overlap >= options_.gates.good_overlap;
    MatchedScan other = straightening.straightened(
        fits ? straightening.again(best, bent.velocity)
             : matched_as_is(std::move(bent), prior, source, ScanMatcher::Search::prior_window));
    const double gained = other.match.overlap - best.match.overlap;
    if (other.match.usable && gained > match_gates::kClearlyBetter) best = std::move(other);
    if (best.match.overlap >= options_.gates.sure_overlap) break;
  }
  return best;
}

}  // namespace marco::slam
