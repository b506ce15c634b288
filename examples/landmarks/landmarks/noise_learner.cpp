#include "landmarks/noise_learner.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace marco::slam {
namespace {

constexpr double kStepLog = 0.25;  // of a standard deviation's logarithm, between filters
constexpr int kWindowSightings = 150;
constexpr double kMemoryWindows = 60.0;
constexpr double kFirstCurvature = 10.0;  // a little trust in the starting values
constexpr double kLargestStepLog = 0.4;
constexpr double kOutlier2 = 16.0;  // a sighting this far off teaches nothing
constexpr double kLostM = 0.5;      // a follower this far from the robot starts again

}  // namespace

NoiseLearner::NoiseLearner(const SightingNoise& start) : noise_(start) {
  validate(start, "noise");
  curvature_.fill(kFirstCurvature);
}

SightingNoise NoiseLearner::varied(int filter) const {
  SightingNoise noise = noise_;
  if (filter == 0) return noise;
  const double factor = std::exp(filter % 2 == 1 ? kStepLog : -kStepLog);
  switch ((filter - 1) / 2) {
    case 0:
      noise.range_sigma_m *= factor;
      break;
    case 1:
      noise.bearing_sigma_rad *= factor;
      break;
    case 2:
      noise.move_sigma_m *= factor;
      break;
    default:
      noise.turn_sigma_rad *= factor;
      break;
  }
  return noise;
}

void NoiseLearner::start_again(const PointFilter& filter) {
  // About what a follower of few landmarks knows; a few scans make it right.
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(noise_.range_sigma_m * noise_.range_sigma_m,
                      noise_.range_sigma_m * noise_.range_sigma_m,
                      noise_.bearing_sigma_rad * noise_.bearing_sigma_rad)
          .asDiagonal();
  followers_.fill({filter.world_from_robot(), covariance, 0.0});
  has_started_ = true;
  scans_ = 0;
  sightings_ = 0;
}

double NoiseLearner::follow(Follower& follower,
                            const SightingOf& seen,
                            const SightingNoise& noise,
                            const PointFilter& filter) const {
  const SetUpVector& set_up = filter.set_up();
  const Pose2 robot_from_sensor{set_up[sensor_x], set_up[sensor_y], set_up[sensor_yaw]};
  const Pose2& robot = follower.world_from_robot;
  const Eigen::Vector2d in_robot = robot.inverse() * filter.landmark(seen.landmark);
  const Eigen::Vector2d at = robot_from_sensor.inverse() * in_robot;
  const Eigen::Matrix2d polar =
      polar_jacobian(at) * Pose2{0, 0, set_up[sensor_yaw]}.rotation().transpose();
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << -polar * robot.rotation().transpose(), -polar * turned_left(in_robot);
  const Eigen::Vector2d innovation(
      seen.sighting.range_m - at.norm(),
      normalize_angle(seen.sighting.bearing_rad - std::atan2(at.y(), at.x())));
  const Eigen::Matrix<double, 3, 2> with = follower.covariance * jacobian.transpose();
  const Eigen::Matrix2d own =
      Eigen::Vector2d(noise.range_sigma_m, noise.bearing_sigma_rad).cwiseAbs2().asDiagonal();
  const Eigen::Matrix2d s = jacobian * with + own;
  const Eigen::Matrix<double, 3, 2> gain = with * s.inverse();
  const double distance2 = innovation.dot(s.inverse() * innovation);
  const Eigen::Vector3d step = gain * innovation;
  follower.world_from_robot = Pose2::from_vector(robot.vector() + step);
  follower.world_from_robot.theta_rad = normalize_angle(follower.world_from_robot.theta_rad);
  // Joseph form: it stays positive however often it is corrected.
  const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - gain * jacobian;
  follower.covariance =
      left * follower.covariance * left.transpose() + gain * own * gain.transpose();
  follower.log_likelihood -= 0.5 * (distance2 + std::log(s.determinant()));
  return distance2;
}

void NoiseLearner::add_scan(const WheelMotion& motion,
                            const std::vector<SightingOf>& seen,
                            const PointFilter& filter) {
  const Eigen::Vector2d off =
      filter.world_from_robot().translation_m() -
      (followers_[0].world_from_robot * motion.start_from_end).translation_m();
  const double lost_m = kLostM + 5.0 * motion.effort_m * noise_.move_sigma_m;
  if (!has_started_ || off.norm() > lost_m) {
    start_again(filter);
    return;
  }
  std::vector<bool> is_outlier(seen.size(), false);
  for (int i = 0; i < kFilters; ++i) {
    Follower& follower = followers_[static_cast<std::size_t>(i)];
    const SightingNoise noise = varied(i);
    // The motion's noise is of noise_: x, y by one number, the heading by the other.
    const double move = noise.move_sigma_m / noise_.move_sigma_m;
    const double turn = noise.turn_sigma_rad / noise_.turn_sigma_rad;
    Eigen::Matrix3d by = Eigen::Vector3d(move, move, turn).asDiagonal();
    by.topLeftCorner<2, 2>() = move * follower.world_from_robot.rotation();
    const Pose2 before = follower.world_from_robot;
    follower.world_from_robot = before * motion.start_from_end;
    Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
    carry.topRightCorner<2, 1>() =
        turned_left(follower.world_from_robot.translation_m() - before.translation_m());
    follower.covariance =
        carry * follower.covariance * carry.transpose() + by * motion.noise * by.transpose();
    for (std::size_t k = 0; k < seen.size(); ++k) {
      if (is_outlier[k]) continue;
      const Follower kept = follower;
      if (follow(follower, seen[k], noise, filter) > kOutlier2 && i == 0) {
        follower = kept;
        is_outlier[k] = true;
      }
    }
  }
  ++scans_;
  sightings_ += static_cast<int>(seen.size());
  if (sightings_ >= kWindowSightings && scans_ > 5) take_step();
}

void NoiseLearner::take_step() {
  ++steps_;
  std::array<double, kNumbers> step{};
  const double middle = followers_[0].log_likelihood;
  for (std::size_t i = 0; i < kNumbers; ++i) {
    const double more = followers_[2 * i + 1].log_likelihood;
    const double less = followers_[2 * i + 2].log_likelihood;
    const double slope = (more - less) / (2.0 * kStepLog);
    const double curvature = std::max(0.0, (2.0 * middle - more - less) / (kStepLog * kStepLog));
    double& memory = curvature_[i];
    memory = (1.0 - 1.0 / kMemoryWindows) * memory + curvature;
    step[i] = std::clamp(slope / memory, -kLargestStepLog, kLargestStepLog);
  }
  noise_.range_sigma_m *= std::exp(step[0]);
  noise_.bearing_sigma_rad *= std::exp(step[1]);
  noise_.move_sigma_m *= std::exp(step[2]);
  noise_.turn_sigma_rad *= std::exp(step[3]);
  for (Follower& follower : followers_) {
    follower.log_likelihood = 0.0;
    // Followers part slowly; what a window says is of its noise alone.
    follower.world_from_robot = followers_[0].world_from_robot;
  }
  scans_ = 0;
  sightings_ = 0;
}

}  // namespace marco::slam
