#include "landmarks/point_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace marco::slam {
namespace {

using Eigen::Index;

constexpr double kJoinSigmaM = 1e-3;  // two landmarks that are one: equal, and still invertible

Eigen::Matrix2d noise_of(const SightingNoise& noise) {
  return Eigen::Vector2d(noise.range_sigma_m * noise.range_sigma_m,
                         noise.bearing_sigma_rad * noise.bearing_sigma_rad)
      .asDiagonal();
}

}  // namespace

Eigen::Vector2d point_of(const Sighting& sighting) {
  return sighting.range_m *
         Eigen::Vector2d(std::cos(sighting.bearing_rad), std::sin(sighting.bearing_rad));
}

Eigen::Matrix2d polar_jacobian(const Eigen::Vector2d& in_sensor_m) {
  const double range_m = std::max(in_sensor_m.norm(), 1e-3);
  Eigen::Matrix2d jacobian;
  jacobian.row(0) = in_sensor_m.transpose() / range_m;
  jacobian.row(1) = turned_left(in_sensor_m).transpose() / (range_m * range_m);
  return jacobian;
}

PointFilter::PointFilter(const SetUpOptions& options) {
  validate(options, "set_up");
  set_up_ << 0.0, 0.0, 0.0, options.sensor_ahead_m, options.sensor_left_m, options.sensor_yaw_rad;
  SetUpVector sigma;
  sigma << options.speed_scale_sigma, options.turn_scale_sigma, options.turn_bias_sigma_rad_per_s,
      options.sensor_sigma_m, options.sensor_sigma_m, options.sensor_yaw_sigma_rad;
  p_.setZero(kFirstLandmark, kFirstLandmark);
  p_.diagonal().segment<kSetUpSize>(kSetUp) = sigma.cwiseAbs2();
  walk_per_s_ = sigma.head<3>().cwiseAbs2() / kForgetS;
}

Eigen::Matrix3d PointFilter::robot_covariance() const {
  // x~ = xi_p + theta~ J p
  Eigen::Matrix3d by = Eigen::Matrix3d::Zero();
  by(2, 0) = 1.0;
  by.topRightCorner<2, 2>().setIdentity();
  by.topLeftCorner<2, 1>() = turned_left(world_from_robot_.translation_m());
  return by * p_.topLeftCorner<3, 3>() * by.transpose();
}

SetUpVector PointFilter::set_up_sigma() const {
  return p_.diagonal().segment<kSetUpSize>(kSetUp).cwiseMax(0.0).cwiseSqrt();
}

Eigen::Matrix2d PointFilter::landmark_covariance(int index) const {
  const Index at = row(index);
  const Eigen::Vector2d turn = turned_left(landmarks_[index]);
  const Eigen::Vector2d cross = p_.block<2, 1>(at, 0);
  return p_.block<2, 2>(at, at) + cross * turn.transpose() + turn * cross.transpose() +
         p_(0, 0) * turn * turn.transpose();
}

Eigen::Matrix2d PointFilter::relative_covariance(int a, int b) const {
  const Index i = row(a), j = row(b);
  return p_.block<2, 2>(i, i) + p_.block<2, 2>(j, j) - p_.block<2, 2>(i, j) - p_.block<2, 2>(j, i);
}

void PointFilter::move(const WheelMotion& motion) {
  const Eigen::Matrix2d rotation = world_from_robot_.rotation();
  world_from_robot_ = world_from_robot_ * motion.start_from_end;
  // Errors of the motion turn everything about the robot's new place.
  Eigen::MatrixXd by_motion = Eigen::MatrixXd::Zero(p_.rows(), 3);
  by_motion(0, 2) = 1.0;
  by_motion.block<2, 2>(kPosition, 0) = rotation;
  by_motion.block<2, 1>(kPosition, 2) = -turned_left(world_from_robot_.translation_m());
  for (int i = 0; i < size(); ++i) {
    by_motion.block<2, 1>(row(i), 2) = -turned_left(landmarks_[i]);
  }
  const Eigen::Matrix3Xd by_state = motion.by_set_up * p_.middleRows<kSetUpSize>(kSetUp);
  const Eigen::Matrix3d own = motion.noise + motion.by_set_up *
                                                 p_.block<kSetUpSize, kSetUpSize>(kSetUp, kSetUp) *
                                                 motion.by_set_up.transpose();
  const Eigen::MatrixXd half = by_motion * (by_state + 0.5 * own * by_motion.transpose());
  p_ += half;
  p_ += half.transpose();
  p_.diagonal().segment<3>(kSetUp) += motion.seconds * walk_per_s_;
}

Eigen::Vector2d PointFilter::in_sensor(int index) const {
  return (world_from_robot_ * robot_from_sensor()).inverse() * landmarks_[index];
}

Eigen::Vector2d PointFilter::in_world(const Sighting& sighting) const {
  return world_from_robot_ * (robot_from_sensor() * point_of(sighting));
}

Eigen::Matrix2d PointFilter::sighting_covariance(const Sighting& sighting,
                                                 const SightingNoise& noise) const {
  const Eigen::Matrix2d by = (world_from_robot_ * robot_from_sensor()).rotation() *
                             polar_jacobian(point_of(sighting)).inverse();
  return by * noise_of(noise) * by.transpose();
}

PointInnovation PointFilter::innovation(const SightingOf& seen) const {
  const Eigen::Vector2d at = in_sensor(seen.landmark);
  const Eigen::Matrix2d polar = polar_jacobian(at);
  const Eigen::Matrix2d sensor_from_robot = Pose2{0, 0, set_up_[sensor_yaw]}.rotation().transpose();
  const Eigen::Matrix2d by_landmark =
      polar * sensor_from_robot * world_from_robot_.rotation().transpose();
  PointInnovation result;
  result.jacobian.leftCols<2>() = -by_landmark;
  result.jacobian.middleCols<2>(2) = -polar * sensor_from_robot;
  result.jacobian.col(4) = -polar * turned_left(at);
  result.jacobian.rightCols<2>() = by_landmark;
  result.innovation << seen.sighting.range_m - at.norm(),
      normalize_angle(seen.sighting.bearing_rad - std::atan2(at.y(), at.x()));
  return result;
}

Eigen::Matrix<double, 7, 7> PointFilter::block(int landmark_a, int landmark_b) const {
  const auto rows_of = [this](int landmark) {
    return std::array<Index, 4>{kPosition, kSensor, kSensor + 2, row(landmark)};
  };
  constexpr std::array<Index, 4> kAt{0, 2, 4, 5}, kSize{2, 2, 1, 2};
  const auto a = rows_of(landmark_a), b = rows_of(landmark_b);
  Eigen::Matrix<double, 7, 7> part;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      part.block(kAt[i], kAt[j], kSize[i], kSize[j]) = p_.block(a[i], b[j], kSize[i], kSize[j]);
    }
  }
  return part;
}

Eigen::Matrix2d PointFilter::innovation_covariance(const PointInnovation& a,
                                                   int landmark_a,
                                                   const PointInnovation& b,
                                                   int landmark_b) const {
  return a.jacobian * block(landmark_a, landmark_b) * b.jacobian.transpose();
}

void PointFilter::correct(const std::vector<SightingOf>& seen, const SightingNoise& noise) {
  const Index count = 2 * static_cast<Index>(seen.size());
  if (count == 0) return;
  std::vector<PointInnovation> rows;
  Eigen::MatrixXd with(p_.rows(), count);  // P H^T
  Eigen::VectorXd innovations(count);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    rows.push_back(innovation(seen[k]));
    const Index at = 2 * static_cast<Index>(k);
    const auto& jacobian = rows.back().jacobian;
    with.middleCols<2>(at) =
        p_.middleCols<2>(kPosition) * jacobian.leftCols<2>().transpose() +
        p_.middleCols<3>(kSensor) * jacobian.middleCols<3>(2).transpose() +
        p_.middleCols<2>(row(seen[k].landmark)) * jacobian.rightCols<2>().transpose();
    innovations.segment<2>(at) = rows.back().innovation;
  }
  Eigen::MatrixXd s(count, count);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const Index at = 2 * static_cast<Index>(k);
    const auto& jacobian = rows[k].jacobian;
    s.middleRows<2>(at) = jacobian.leftCols<2>() * with.middleRows<2>(kPosition) +
                          jacobian.middleCols<3>(2) * with.middleRows<3>(kSensor) +
                          jacobian.rightCols<2>() * with.middleRows<2>(row(seen[k].landmark));
    s.block<2, 2>(at, at) += noise_of(noise);
  }
  const Eigen::LLT<Eigen::MatrixXd> root(s);
  if (root.info() != Eigen::Success) return;
  const Eigen::MatrixXd u = root.matrixL().solve(with.transpose()).transpose();
  shift(u * root.matrixL().solve(innovations));
  subtract(u);
}

void PointFilter::subtract(const Eigen::MatrixXd& u) {
  p_.selfadjointView<Eigen::Lower>().rankUpdate(u, -1.0);
  p_.triangularView<Eigen::StrictlyUpper>() = p_.transpose();
}

void PointFilter::shift(const Eigen::VectorXd& error) {
  // Exp of the group: all positions turn about the origin, then move.
  const double turn_rad = error[0];
  const Eigen::Matrix2d turn = Pose2{0, 0, turn_rad}.rotation();
  const bool small = std::abs(turn_rad) < 1e-6;
  const double along = small ? 1.0 : std::sin(turn_rad) / turn_rad;
  const double across = small ? 0.5 * turn_rad : (1.0 - std::cos(turn_rad)) / turn_rad;
  const auto moved = [&](const Eigen::Vector2d& point, Index at) -> Eigen::Vector2d {
    const Eigen::Vector2d by = error.segment<2>(at);
    return turn * point + along * by + across * turned_left(by);
  };
  const Eigen::Vector2d robot = moved(world_from_robot_.translation_m(), kPosition);
  world_from_robot_ = {robot.x(), robot.y(),
                       normalize_angle(world_from_robot_.theta_rad + turn_rad)};
  for (int i = 0; i < size(); ++i) landmarks_[i] = moved(landmarks_[i], row(i));
  set_up_ += error.segment<kSetUpSize>(kSetUp);
}

int PointFilter::add(const Sighting& sighting, const SightingNoise& noise) {
  const Eigen::Vector2d in_sensor_m = point_of(sighting);
  const Eigen::Matrix2d by_robot = world_from_robot_.rotation();
  const Eigen::Matrix2d by_sensor = (world_from_robot_ * robot_from_sensor()).rotation();
  // xi_l = xi_p + R (d~ + R_yaw (q~ + J q yaw~))
  Eigen::Matrix<double, 2, 3> by_set_up;
  by_set_up << by_robot, by_sensor * turned_left(in_sensor_m);
  const Index at = p_.rows();
  const Eigen::MatrixXd cross = p_.middleRows<2>(kPosition) + by_set_up * p_.middleRows<3>(kSensor);
  const Eigen::Matrix2d own = cross.middleCols<2>(kPosition) +
                              cross.middleCols<3>(kSensor) * by_set_up.transpose() +
                              sighting_covariance(sighting, noise);
  p_.conservativeResize(at + 2, at + 2);
  p_.bottomLeftCorner(2, at) = cross;
  p_.topRightCorner(at, 2) = cross.transpose();
  p_.bottomRightCorner<2, 2>() = 0.5 * (own + own.transpose());
  landmarks_.push_back(in_world(sighting));
  return size() - 1;
}

void PointFilter::remove(int index) {
  const Index hole = row(index), last = p_.rows() - 2;
  if (hole != last) {
    const Eigen::MatrixXd rows = p_.bottomRows<2>();
    const Eigen::Matrix2d own = p_.bottomRightCorner<2, 2>();
    p_.middleRows<2>(hole) = rows;
    p_.middleCols<2>(hole) = rows.transpose();
    p_.block<2, 2>(hole, hole) = own;
    landmarks_[index] = landmarks_.back();
  }
  landmarks_.pop_back();
  p_.conservativeResize(last, last);
}

void PointFilter::join(int a, int b) {
  const Eigen::MatrixXd with = p_.middleCols<2>(row(a)) - p_.middleCols<2>(row(b));
  const Eigen::Matrix2d s = with.middleRows<2>(row(a)) - with.middleRows<2>(row(b)) +
                            kJoinSigmaM * kJoinSigmaM * Eigen::Matrix2d::Identity();
  const Eigen::LLT<Eigen::Matrix2d> root(s);
  const Eigen::MatrixXd u = root.matrixL().solve(with.transpose()).transpose();
  const Eigen::Vector2d apart = landmarks_[b] - landmarks_[a];
  shift(u * root.matrixL().solve(apart));
  subtract(u);
  remove(b);
}

}  // namespace marco::slam
