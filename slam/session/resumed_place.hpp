#pragma once

#include <optional>
#include <vector>

#include "slam/localization/session_finder.hpp"

namespace marco::slam {

/// Where a robot stands when mapping resumes after a stop: where it stood, or where odometry says
/// that it has gone since. Scans must confirm it. Not thread-safe.
class ResumedPlace {
 public:
  /// @param map  as it was at the stop
  ResumedPlace(const SlamState& map, const MotionOptions& options);

  /// Call for each new keyframe of the session that resumes, from the first one on.
  /// @param now  of its scan
  std::optional<FoundPlace> look(SessionFinder& finder,
                                 const Keyframe& newest,
                                 const MotionInput& now);
  /// The place is where the robot's own motion led since a stop of some seconds: Slam may continue
  /// as if it had never stopped.
  bool is_continued() const { return is_continued_; }
  /// As it was at the stop.
  const MotionModel& motion() const { return motion_; }

 private:
  struct Guess {
    Pose2 map_from_session;
    bool is_continued;
    double explained;  ///< part of a scan that the map has to know
  };

  MotionModel motion_;
  std::optional<Utime> stopped_;
  Pose2 map_from_robot_;
  std::vector<Guess> guesses_;  ///< the likeliest first
  bool is_continued_ = false;
};

}  // namespace marco::slam
