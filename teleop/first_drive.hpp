#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/input/synchronized_scan.hpp"

/// What `marco first-drive` makes of keys and of a robot's messages, and its report. Pure.
namespace marco::teleop {

/// A motion that lasts while the space bar is held. A terminal reports presses and their
/// repetitions, but no release: the motion ends when no repetition comes.
class HeldMotion {
 public:
  static constexpr double kMostS = 0.9;         ///< however long the key is held
  static constexpr double kUntilRepeatS = 0.6;  ///< a held key repeats after about half a second
  static constexpr double kRepeatS = 0.25;      ///< and then at least so often

  explicit HeldMotion(Utime pressed)
      : most_(pressed + Duration::from_seconds(kMostS)),
        until_(pressed + Duration::from_seconds(kUntilRepeatS)) {}
  /// Any key but the space bar ends it.
  void on_key(char key, Utime now) {
    if (key != ' ') until_ = std::min(until_, now);
    if (goes(now)) until_ = std::min(most_, now + Duration::from_seconds(kRepeatS));
  }
  bool goes(Utime now) const { return now < until_; }

 private:
  Utime most_, until_;
};

/// How odometry shows a motion that was ordered.
struct SeenMotion {
  Pose2 start_from_end;
  std::optional<double> begins_s;  ///< from the first order; nothing: it never moved
  double stands_s = 0.0;           ///< from the order to stop until it rests
};
/// @param track  from before the order until the robot rests
SeenMotion seen_motion(const std::vector<OdometrySample>& track, Utime ordered, Utime stopped);

struct NearestReturn {
  double range_m = 0.0;      ///< from its laser
  double bearing_rad = 0.0;  ///< as the laser sees it, from the robot's x axis; left > 0
};
/// Of all lasers, by channel. Scans older than a second are ignored.
std::optional<NearestReturn> nearest_return(const std::map<std::string, SynchronizedScan>& newest,
                                            Utime now);

/// One step of the drive.
struct Check {
  explicit Check(std::string of) : name(std::move(of)) {}

  std::string name;
  std::string answer = "skipped";  ///< of the person: "yes", "no", "skipped"
  std::string fault;               ///< what the messages show instead; "" = nothing
  std::vector<std::pair<std::string, double>> figures;  ///< named with their unit, moved_m

  /// "ok", "WRONG" or "skipped".
  const char* result() const;

  /// These set figures and fault. @param ahead, left  1 or -1 as it was ordered, one of them 0
  void judge_motion(const SeenMotion& seen, double ahead, double left);
  void judge_hand(const std::optional<NearestReturn>& nearest, double bearing_deg);
  /// Of a metre ahead.
  void judge_push(const Pose2& start_from_end);
};

struct DriveReport {
  std::string version, robot, base;  ///< of Marco; as the person and BASE_STATUS call it
  std::vector<Check> checks;         ///< so far
  std::string ended_early;           ///< why; "" = it did not

  bool is_good() const;  ///< it came to its end, and nothing is wrong
  /// A line for each check.
  std::string to_text() const;
  /// TOML, with the same lines as its first comment.
  std::string to_toml() const;
};

}  // namespace marco::teleop
