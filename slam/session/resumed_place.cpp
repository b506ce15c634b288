#include "slam/session/resumed_place.hpp"

#include "slam/localization/place_gates.hpp"

namespace marco::slam {

ResumedPlace::ResumedPlace(const SlamState& map, const MotionOptions& options)
    : motion_(options), map_from_robot_(map.estimate.world_from_robot) {
  motion_.restore(map.motion);
  if (map.motion.before) stopped_ = map.motion.before->utime;
}

std::optional<FoundPlace> ResumedPlace::look(SessionFinder& finder,
                                             const Keyframe& newest,
                                             const MotionInput& now) {
  if (guesses_.empty()) {
    // After a crash of SLAM alone the robot drives on, into what the map does not know yet; after
    // a longer time, or a clock that was set, it may be anywhere: there the map has to know all.
    constexpr double kAwhileS = 30.0;
    const double since_s = stopped_ ? (now.utime - *stopped_).seconds() : -1.0;
    const bool is_recent = since_s >= 0.0 && since_s < kAwhileS;
    const double all = PlaceFinderOptions{}.sure_explained;
    const Pose2 moved = motion_.guess(now, false).before_from_now;
    const Pose2 session_from_then = newest.world_from_robot.inverse();
    guesses_ = {{map_from_robot_ * moved * session_from_then, is_recent,
                 is_recent ? place_gates::kExplained : all},
                {map_from_robot_ * session_from_then, false, all}};
  }
  for (const Guess& guess : guesses_) {
    const Pose2 map_from_robot = guess.map_from_session * newest.world_from_robot;
    if (auto place = finder.look_at(newest, map_from_robot, guess.explained)) {
      is_continued_ = guess.is_continued;
      return place;
    }
  }
  return std::nullopt;
}

}  // namespace marco::slam
