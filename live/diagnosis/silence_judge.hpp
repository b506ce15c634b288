#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcm_tools/files/channel_pattern.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"

namespace marco::diagnosis {

/// A message that a live program waits for.
struct Expectation {
  std::string what = {};                ///< "scans"
  std::string channels = {};            ///< as printed: "LIDAR or LIDAR_RAW"
  std::string pattern = {};             ///< of the channels' names: POSIX extended, the whole name
  std::vector<std::string> types = {};  ///< of their messages: "bot_core.planar_lidar_t"
  std::string meaning = {};             ///< in ForeignTable: "lidar"; "" = none
  std::string remedy = {};              ///< a sentence: which program sends it, how to start it
  std::string without = {};             ///< what the program does without it; "" = nothing
  /// Whether a message counts; empty: all of these types do.
  std::function<bool(const process::RawMessage&)> counts = {};
};

/// What one expectation lacks now.
struct Lack {
  enum class Kind {
    never,       ///< nothing was received
    ended,       ///< nothing is received any more
    wrong_type,  ///< the channel carries another type
    unused,      ///< of the first expectation: all messages are dropped
    clock,       ///< its stamps differ from those of the first expectation
    two_poses    ///< SENSOR_INFO alternates between two poses
  };
  Kind kind = Kind::never;
  Expectation expected;
  double silent_s = 0.0;     ///< never, ended
  double hz = 0.0;           ///< ended: before; else: now
  std::string channel;       ///< of the last message
  uint64_t fingerprint = 0;  ///< wrong_type
  std::string cause;         ///< unused
  int64_t dropped = 0;       ///< unused: in a row
  double ahead_s = 0.0;      ///< clock: of the first expectation's stamps
};

/// Compares the messages that come with those that are expected. Has neither clock nor network: the
/// caller passes messages and time. Time in which the program was busy does not count as silence.
///
/// Expectations with `without` are optional: they are missed only while the required ones, which
/// come first in the list, arrive. Not thread-safe.
class SilenceJudge {
 public:
  static constexpr double kNeverS = 3.0;   ///< of silence from the start
  static constexpr double kEndedS = 10.0;  ///< after messages, and at least kEndedPeriods of theirs
  static constexpr double kEndedPeriods = 5.0;
  static constexpr double kWithoutS = 10.0;  ///< for what can be done without
  static constexpr double kClockS = 2.0;     ///< stamps that differ by less agree

  /// @param drops  the program's, to know the result of a message; may be null. Outlives the judge.
  SilenceJudge(std::vector<Expectation> expectations, const process::DropCounter* drops);

  /// A message is about to be handled.
  void heard(const process::RawMessage& raw);
  /// @param now_s  any clock that never steps back.
  void advance(double now_s);

  /// What is missing now, or would be `ahead_s` from now if nothing came.
  std::vector<Lack> lacks(double ahead_s = 0.0) const;
  /// "LIDAR 10 Hz, ODOMETRY 20 Hz" of what is expected and comes.
  std::string what_comes() const;

 private:
  /// Messages of the right type, since the last pause.
  struct Coming {
    int64_t count = 0;
    double first_s = 0.0, last_s = 0.0;
    std::string channel;
    std::optional<int64_t> stamp_us;

    double hz() const {
      return count < 2 ? 0.0 : static_cast<double>(count - 1) / std::max(1e-3, last_s - first_s);
    }
    double period_s() const { return count < 2 ? 0.0 : 1.0 / std::max(1e-3, hz()); }
  };
  /// Messages of another type, since the last of the right one.
  struct WrongType {
    int64_t count = 0;
    double first_s = 0.0, last_s = 0.0;
    std::string channel;
    uint64_t fingerprint = 0;
  };
  /// Messages that the program dropped, in a row.
  struct Dropped {
    int64_t count = 0;
    double first_s = 0.0;
    std::string cause;
  };
  /// Its stamps against those of the first expectation.
  struct Clock {
    double ahead_s = 0.0;
    double agreed_s = 0.0;  ///< when they last agreed
    int disagreements = 0;  ///< since
  };
  struct Track {
    Expectation expected;
    ChannelPattern pattern;
    Coming coming;
    WrongType wrong;
    Dropped dropped;
    Clock clock;
  };
  struct Place {
    std::string pose, before;
    int returns = 0;  ///< to the pose before
  };
  void settle();
  const std::vector<std::size_t>& expecting_tracks(const std::string& channel);
  void count(Track& track, const process::RawMessage& raw, const std::string& type);
  void watch_pose(const process::RawMessage& raw);
  void compare_clocks();
  std::optional<Lack> lack_of(const Track& track, double ahead_s) const;
  bool comes(const Track& track) const;

  std::vector<Track> tracks_;
  std::map<std::string, std::vector<std::size_t>> tracks_of_channel_;
  const process::DropCounter* drops_;
  std::map<std::string, int64_t> drops_before_;
  int64_t dropped_before_ = 0;
  Track* handled_ = nullptr;             ///< track of the last message
  std::map<std::string, Place> places_;  ///< by sensor
  std::optional<double> clock_s_;
  double time_s_ = 0.0;
};

}  // namespace marco::diagnosis
