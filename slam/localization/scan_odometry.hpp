#pragma once

#include "slam/slam.hpp"

namespace marco::slam {

/// A robot's motion by its scans alone: a small SLAM of its own last metres, without loops. Not
/// thread-safe.
class ScanOdometry {
 public:
  explicit ScanOdometry(const SlamOptions& options);

  /// How the robot moved since the scan before.
  struct Move {
    Pose2 before_from_now;
    Eigen::Matrix3d covariance;
    bool by_scans = false;  ///< scans fit each other; else `guess`
  };
  /// @param guess  dead reckoning
  Move move(const SlamInput& input, const MotionGuess& guess);

  /// The SLAM itself, while a place is looked for.
  Slam& session() { return session_; }
  const Slam& session() const { return session_; }
  /// From here on only the motion is asked for. @param session_from_robot  at the last scan
  void begin(const Pose2& session_from_robot);
  void reset();

 private:
  SlamOptions options_;
  Slam session_;
  Pose2 session_from_robot_;
};

}  // namespace marco::slam
