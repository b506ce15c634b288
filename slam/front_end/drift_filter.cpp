#include "slam/front_end/drift_filter.hpp"

#include <Eigen/LU>
#include <cmath>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

// An error of odometry, as the prediction holds it, and a reading's jitter; and a match of both.
struct Innovation {
  Eigen::Matrix3d drift, jitter;
  Eigen::Matrix3d prior;        // (drift + jitter)^-1
  Eigen::Matrix3d information;  // (drift + jitter + covariance of the match)^-1

  /// What a scan contradicts are wheels that slipped, and not stamps: it is drift.
  Innovation(const Eigen::Matrix3d& covariance,
             const CarriedPose& carried,
             const ScanCorrection& scan)
      : drift((covariance + carried.jitter) / scan.prior_weight - carried.jitter),
        jitter(carried.jitter),
        prior((drift + jitter).inverse()),
        // The match may leave directions open.
        information(prior - prior * (prior + scan.information).inverse() * prior) {}
};

// What is left of a covariance after a measurement of the sum that it is a part of.
ErrorEstimate estimated(const Eigen::Matrix3d& covariance,
                        const Eigen::Vector3d& weighted_error,
                        const Eigen::Matrix3d& innovation_information) {
  const Eigen::Matrix3d left = covariance - covariance * innovation_information * covariance;
  return {covariance * weighted_error, 0.5 * (left + left.transpose())};
}

Pose2 moved_by(const Pose2& pose, const Eigen::Vector3d& step) {
  return {pose.x_m + step.x(), pose.y_m + step.y(), normalize_angle(pose.theta_rad + step.z())};
}

}  // namespace

CarriedPose DriftFilter::carried(const MotionGuess& guess) const {
  const Pose2& before = state_.drifted.world_from_robot;
  const double theta_rad = before.theta_rad;
  CarriedPose carried = state_;
  Pose2 step = guess.before_from_now;
  Eigen::Matrix3d by = Eigen::Matrix3d::Zero();
  if (guess.source == MotionGuess::Source::odometry) {
    by = OdometryBias::derivative(step, theta_rad, guess.turn_by_gyro);
    step = state_.bias.corrected(step, guess.turn_by_gyro);
  }
  carried.drifted = dead_reckoned(state_.drifted, step, guess.drift);
  carried.since_keyframe =
      dead_reckoned({before, state_.since_keyframe}, step, guess.drift).covariance;
  const Eigen::Vector2d way_m =
      carried.drifted.world_from_robot.translation_m() - before.translation_m();
  Eigen::Matrix3d turned = state_.pose_with_bias;  // an error of the heading moves the pose aside
  turned.topRows<2>() += Eigen::Vector2d(-way_m.y(), way_m.x()) * state_.pose_with_bias.row(2);
  const Eigen::Matrix3d both = turned * by.transpose();
  carried.drifted.covariance +=
      both + both.transpose() + by * state_.bias.covariance * by.transpose();
  carried.pose_with_bias = turned + by * state_.bias.covariance;
  if (guess.source == MotionGuess::Source::odometry) carried.bias.forget(motion_m(step));
  carried.jitter = rotated(guess.jitter, theta_rad);
  carried.way_m += motion_m(guess.before_from_now);
  carried.by_odometry = guess.source == MotionGuess::Source::odometry;
  carried.turned_by_odometry =
      state_.turned_by_odometry && carried.by_odometry && !guess.turn_by_gyro;
  return carried;
}

void DriftFilter::correct(const CarriedPose& carried,
                          const ScanCorrection& scan,
                          OdometryNoise& noise) {
  const Innovation innovation(carried.drifted.covariance, carried, scan);
  const Innovation since_keyframe(carried.since_keyframe, carried, scan);
  const Eigen::Vector3d error =
      innovation.prior * difference(scan.world_from_robot, carried.drifted.world_from_robot);
  const ErrorEstimate drifted = estimated(innovation.drift, error, innovation.information);
  state_ = carried;
  state_.since_keyframe =
      estimated(since_keyframe.drift, error, since_keyframe.information).covariance;
  state_.drifted = {moved_by(carried.drifted.world_from_robot, drifted.mean), drifted.covariance};
  state_.corrected += drifted.mean;
  const Eigen::Matrix3d& with_bias = carried.pose_with_bias;
  state_.bias.add(with_bias.transpose() * error);
  state_.bias.covariance -= with_bias.transpose() * innovation.information * with_bias;
  state_.pose_with_bias -= innovation.drift * innovation.information * with_bias;
  if (carried.by_odometry && scan.judges_jitter) {
    noise.learn_jitter(estimated(innovation.jitter, error, innovation.information),
                       carried.turned_by_odometry);
  }
}

void DriftFilter::begin_at_keyframe(double of_before, OdometryNoise& noise) {
  state_.drifted.covariance *= of_before;
  state_.pose_with_bias *= std::sqrt(of_before);
  if (state_.by_odometry) {
    const double theta_rad = state_.drifted.world_from_robot.theta_rad;
    const Eigen::Rotation2Dd robot_from_world(-theta_rad);
    ErrorEstimate error{state_.corrected, rotated(state_.since_keyframe, -theta_rad)};
    error.mean.head<2>() = robot_from_world * state_.corrected.head<2>();
    noise.learn_drift(error, state_.way_m, state_.turned_by_odometry);
    state_.since_keyframe.setZero();
  }
  state_.corrected.setZero();
  state_.way_m = 0.0;
  state_.turned_by_odometry = true;
}

void DriftFilter::move_with_map(const Pose2& before, const Pose2& now) {
  const Pose2 moved = now * before.inverse();
  state_.drifted.world_from_robot = moved * state_.drifted.world_from_robot;
  state_.drifted.covariance = rotated(state_.drifted.covariance, moved.theta_rad);
  state_.pose_with_bias.topRows<2>() = moved.rotation() * state_.pose_with_bias.topRows<2>();
  state_.since_keyframe = rotated(state_.since_keyframe, moved.theta_rad);
  state_.corrected.head<2>() = moved.rotation() * state_.corrected.head<2>();
}

}  // namespace marco::slam
