#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/wall.hpp"
#include "slam/line_slam/ekf/circle_map.hpp"
#include "slam/line_slam/ekf/data_association.hpp"
#include "slam/line_slam/ekf/wall_map.hpp"
#include "slam/line_slam/ekf/wall_plan.hpp"
#include "slam/line_slam/lines/observed_wall.hpp"
#include "slam/line_slam/lines/scan_in_robot.hpp"

namespace marco::slam {

/// Thesis A's filter: robot and walls in one extended Kalman filter, with first-estimates Jacobians
/// (a plain EKF grows overconfident in its heading). Steps of one scan, in this order: predict,
/// associate, correct, extend, add, join, judge. Not thread-safe.
class WallFilter {
 public:
  /// @throws std::invalid_argument naming an option outside its limits.
  WallFilter(const WallFilterOptions& options, const Pose2& world_from_robot)
      : map_(options, world_from_robot), circles_(options) {}

  Pose2 world_from_robot() const { return map_.world_from_robot(); }
  Eigen::Matrix3d robot_covariance() const { return map_.robot_covariance(); }
  std::size_t num_walls() const { return map_.size(); }
  const MapWall& wall(std::size_t index) const { return map_.wall(index); }
  /// x1 y1 x2 y2.
  Eigen::Vector4d wall_mean(std::size_t index) const { return map_.mean(index); }
  /// Of walls, then of circles.
  std::vector<int> blocks() const;
  EkfState& state() { return map_.state(); }
  const EkfState& state() const { return map_.state(); }

  /// (5.2-5.14) by odometry.
  void predict(const Pose2& robot_motion);
  /// By a motion from another source. @param noise  V_r, world frame.
  void predict(const Pose2& robot_motion, const Eigen::Matrix3d& noise);
  /// Forgets where the robot was: another source says where it is, independently of the map.
  void place(const Pose2& world_from_robot, const Eigen::Matrix3d& covariance);

  /// Data association (5.1).
  std::vector<WallMatch> associate(const std::vector<ObservedWall>& observed) const {
    return associate_walls(map_, observed);
  }
  /// See CircleMap::associate.
  std::vector<int> associate(const std::vector<ObservedCircle>& observed) const {
    return circles_.associate(state(), observed);
  }

  /// Innovation of a pairing's two offsets across the observed line.
  SparseRows line_innovation(const ObservedWall& observed, std::size_t index) const {
    return map_.measurement(observed, index, {});
  }

  /// (5.2.2-5.2.5) Corrects pose and map by all matched walls, one after the other.
  void correct(const std::vector<ObservedWall>& observed, const std::vector<WallMatch>& matches) {
    correct(observed, matches, {}, {});
  }
  /// As above, and by posts and curved walls.
  void correct(const std::vector<ObservedWall>& observed,
               const std::vector<WallMatch>& matches,
               const std::vector<ObservedCircle>& circles,
               const std::vector<int>& circle_matches);

  /// (5.3.1) Lengthens matched walls that are seen to continue.
  void extend(const std::vector<ObservedWall>& observed, const std::vector<WallMatch>& matches);

  /// @returns index of the new wall.
  std::size_t add(const ObservedWall& observed) { return map_.add(observed); }
  /// Adds walls that are new and clear enough, and names them in `matches`. @returns how many.
  int add_new(const std::vector<ObservedWall>& observed, std::vector<WallMatch>& matches);

  /// See join_walls and join_similar_walls.
  void join(std::size_t a, std::size_t b);
  int join_similar(const std::vector<WallMatch>& matches);

  /// Raises and lowers the walls' evidence by the rays of a scan; walls that fell below
  /// forget_probability are removed. @returns how many were.
  int judge(const ScanInRobot& scan);
  /// All evidence again, by these scans alone. @param world_from_robots  one a scan, known to
  /// centimetres
  void judge_again(const std::vector<ScanInRobot>& scans,
                   const std::vector<Pose2>& world_from_robots);

  /// See CircleMap. Walls that are nothing but chords of a circle are removed.
  void draw_circles(const std::vector<ObservedCircle>& observed,
                    const std::vector<int>& matches,
                    const ScanInRobot& scan);
  const CircleMap& circles() const { return circles_; }
  RoundWalls round_walls(int64_t min_times_seen) const {
    return circles_.plan(state(), min_times_seen);
  }

  /// See plan_of.
  Walls plan(int64_t min_times_seen, double min_length_m) const {
    return plan_of(map_, min_times_seen, min_length_m);
  }
  /// See corners_of.
  CornerPoints corners(const Walls& plan) const { return corners_of(map_, plan); }

  /// The whole state. A filter restored from it continues bit for bit as the stored one.
  struct Stored {
    /// Robot (3), walls and circles (4 each).
    Eigen::VectorXd mean, first_estimate;
    Eigen::MatrixXd covariance;
    std::vector<MapWall> walls;
    CircleMap::Stored circles;
    int64_t next_id = 0;

    template <class Visitor>
    void visit(Visitor& v) {
      v("next_id", next_id);
      v("walls", walls);
      v("mean", mean);
      v("first_estimate", first_estimate);
      v("covariance", covariance);
    }
  };
  Stored store() const;
  /// @throws std::invalid_argument when sizes do not agree.
  void restore(const Stored& stored);

 private:
  const WallFilterOptions& options() const { return map_.options(); }
  /// Whether rays from there judge the wall: it is never seen from behind, nor from far away.
  bool may_see(const Eigen::Vector2d& robot_m, const Eigen::Vector4d& wall) const;

  WallMap map_;
  CircleMap circles_;
};

}  // namespace marco::slam
