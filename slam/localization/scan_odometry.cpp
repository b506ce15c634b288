#include "slam/localization/scan_odometry.hpp"

#include <cmath>

namespace marco::slam {
namespace {

// Of a motion from scans, besides its own length and turn.
constexpr double kSigmaPart = 0.02;
constexpr double kSigmaM = 5e-4;
constexpr double kSigmaDeg = 0.01;

// Keyframes before the session is restarted.
constexpr std::size_t kMostKeyframes = 150;

}  // namespace

ScanOdometry::ScanOdometry(const SlamOptions& options) : options_(options), session_(options) {}

void ScanOdometry::begin(const Pose2& session_from_robot) {
  // Loop work that nobody takes is not done: no loops, no jumps.
  session_.defer_loop_work();
  session_from_robot_ = session_from_robot;
}

void ScanOdometry::reset() { session_ = Slam(options_); }

ScanOdometry::Move ScanOdometry::move(const SlamInput& input, const MotionGuess& guess) {
  Move move{guess.before_from_now, guess.covariance};
  const bool is_first = session_.key_count() == 0;
  const Pose2 before = session_from_robot_;
  const SlamUpdate own = session_.process(input);
  session_from_robot_ = own.world_from_robot;
  if (is_first) return move;
  move.by_scans =
      own.status == SlamUpdate::Status::matched && own.overlap >= options_.gates.good_overlap;
  if (move.by_scans) {
    move.before_from_now = between(before, own.world_from_robot);
    const double sigma_m = kSigmaPart * move.before_from_now.translation_m().norm() + kSigmaM;
    const double sigma_rad =
        kSigmaPart * std::abs(move.before_from_now.theta_rad) + deg_to_rad(kSigmaDeg);
    move.covariance = diagonal_covariance(sigma_m, sigma_rad);
  }
  if (session_.key_count() > kMostKeyframes) {
    SlamState start;
    start.motion = session_.state().motion;
    session_ = Slam(options_);
    session_.restore(start);
    begin(session_.process(input).world_from_robot);
  }
  return move;
}

}  // namespace marco::slam
