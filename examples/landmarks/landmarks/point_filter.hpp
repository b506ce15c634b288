#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.hpp"
#include "landmarks/landmark_slam_options.hpp"
#include "landmarks/sighting.hpp"
#include "landmarks/wheel_integral.hpp"

namespace marco::slam {

/// A sighting and the landmark it is of.
struct SightingOf {
  Sighting sighting;
  int landmark = 0;  ///< index in the filter
};

/// Sensor coordinates of a sighting [m].
Eigen::Vector2d point_of(const Sighting& sighting);
/// d (range, bearing) / d (x, y) in the sensor's frame.
Eigen::Matrix2d polar_jacobian(const Eigen::Vector2d& in_sensor_m);

/// What a landmark would look like, against how it was seen.
struct PointInnovation {
  /// Columns: robot's position (2), sensor (3: x y yaw), landmark (2); rows range and bearing.
  Eigen::Matrix<double, 2, 7> jacobian;
  Eigen::Vector2d innovation;  ///< measured minus predicted (range [m], bearing [rad])
};

/// Robot, set-up and point landmarks in one Kalman filter, whose errors are those of the group
/// SE_n(2) on the left of the estimate (right-invariant EKF-SLAM; Zhang, Wu, Song, Huang and
/// Dissanayake, IEEE RA-L 2017, eq. 9-16): a true position is the estimated one, turned by the
/// heading's error about the origin, plus its own error. Turning the whole map then is one fixed
/// direction of the state, so that no Jacobian makes it look observable: the filter stays
/// consistent without holding Jacobians at old estimates. What differs: the set-up's constants are
/// in the state (imperfect invariance: their columns depend on estimates).
///
/// State: heading, position (2), set-up (6), landmarks (2 each). World frame; the robot starts at
/// its origin, exactly known. Landmarks are named by index; removing one gives its index to the
/// last. Cost O(n^2) a step. Not thread-safe.
class PointFilter {
 public:
  explicit PointFilter(const SetUpOptions& options);

  Pose2 world_from_robot() const { return world_from_robot_; }
  /// Of (x, y, theta) as estimate minus truth, world frame.
  Eigen::Matrix3d robot_covariance() const;
  const SetUpVector& set_up() const { return set_up_; }
  /// Standard deviations of the set-up.
  SetUpVector set_up_sigma() const;
  int size() const { return static_cast<int>(landmarks_.size()); }
  const Eigen::Vector2d& landmark(int index) const { return landmarks_[index]; }
  Eigen::Matrix2d landmark_covariance(int index) const;
  /// Covariance of where landmark b lies as seen from landmark a, up to the map's turn.
  Eigen::Matrix2d relative_covariance(int a, int b) const;

  /// Also forgets the wheels' constants slowly: what they are known to be wrong by at first comes
  /// again in kForgetS seconds.
  void move(const WheelMotion& motion);

  /// Where a landmark is seen from the sensor [m].
  Eigen::Vector2d in_sensor(int index) const;
  /// Where a sighting lies in the world.
  Eigen::Vector2d in_world(const Sighting& sighting) const;
  /// Covariance of in_world() about the robot as it is estimated.
  Eigen::Matrix2d sighting_covariance(const Sighting& sighting, const SightingNoise& noise) const;

  PointInnovation innovation(const SightingOf& seen) const;
  /// H_a P H_b^T of two landmarks' innovations, without noise.
  Eigen::Matrix2d innovation_covariance(const PointInnovation& a,
                                        int landmark_a,
                                        const PointInnovation& b,
                                        int landmark_b) const;

  /// Corrects by all sightings at once.
  void correct(const std::vector<SightingOf>& seen, const SightingNoise& noise);

  /// @returns the new landmark's index: the last.
  int add(const Sighting& sighting, const SightingNoise& noise);
  void remove(int index);
  /// Measures two landmarks to be one, at a's index, and removes b.
  void join(int a, int b);

 private:
  Eigen::Index row(int landmark) const { return kFirstLandmark + 2 * Eigen::Index{landmark}; }
  Eigen::Vector2d sensor_in_robot() const { return set_up_.segment<2>(sensor_x); }
  Pose2 robot_from_sensor() const {
    return {set_up_[sensor_x], set_up_[sensor_y], set_up_[sensor_yaw]};
  }
  void subtract(const Eigen::MatrixXd& u);
  void shift(const Eigen::VectorXd& error);
  Eigen::Matrix<double, 7, 7> block(int landmark_a, int landmark_b) const;

  static constexpr double kForgetS =  // [s] in which the set-up may drift by its first sigma
      1000.0;  // [s]: of the wheels' and the turn rate's errors, which drift in minutes
  static constexpr Eigen::Index kPosition = 1;
  static constexpr Eigen::Index kSetUp = 3;
  static constexpr Eigen::Index kSensor = kSetUp + sensor_x;
  static constexpr Eigen::Index kFirstLandmark = kSetUp + kSetUpSize;

  Pose2 world_from_robot_;
  SetUpVector set_up_;
  Eigen::Vector3d walk_per_s_;  ///< variances, of the wheels' constants
  std::vector<Eigen::Vector2d> landmarks_;
  Eigen::MatrixXd p_;
};

}  // namespace marco::slam
