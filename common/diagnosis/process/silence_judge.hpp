#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"

namespace marco::diagnosis {

/// An input that a live program waits for.
struct Expectation {
  std::string what = {};                ///< "scans"
  std::string channels = {};            ///< for a person: "LIDAR or LIDAR_RAW"
  std::string pattern = {};             ///< of the channels' names: POSIX extended, the whole name
  std::vector<std::string> types = {};  ///< of their messages: "bot_core.planar_lidar_t"
  std::string meaning = {};             ///< in ForeignTable: "lidar"; "" = none
  std::string remedy = {};              ///< a sentence: which program sends it, how to start it
  std::string elsewhere = {};           ///< advice when another channel carries it; "" = rename it
  std::string without = {};             ///< what the program does without it; "" = it needs it
  /// Whether a message counts; empty: all of these types do.
  std::function<bool(const process::RawMessage&)> counts = {};
};

/// How one expectation is not met.
struct Lack {
  enum class Kind {
    never,       ///< nothing has come
    ended,       ///< nothing comes any more
    wrong_type,  ///< the channel carries another type
    unused,      ///< of the first expectation: all that comes is dropped
    clock,       ///< its stamps are not of the time of the first expectation's
    two_poses    ///< SENSOR_INFO tells two poses in turn
  };
  Kind kind = Kind::never;
  Expectation expected;
  double silent_s = 0.0;     ///< never, ended
  double hz = 0.0;           ///< ended: before; else: of what comes
  std::string channel;       ///< what came last
  uint64_t fingerprint = 0;  ///< wrong_type
  std::string cause;         ///< unused
  int64_t dropped = 0;       ///< unused: in a row
  double ahead_s = 0.0;      ///< clock: of the first expectation's stamps
};

/// Tracks the expected messages. Knows neither clock nor network: messages and time are passed in.
/// Time in which the program was busy and did not poll does not count as silence.
///
/// Expectations with `without` are reported only while the needed ones are met. Not thread-safe.
class SilenceJudge {
 public:
  static constexpr double kNeverS = 3.0;   ///< of silence from the start
  static constexpr double kEndedS = 10.0;  ///< after messages, and at least kEndedPeriods of theirs
  static constexpr double kEndedPeriods = 5.0;
  static constexpr double kWithoutS = 10.0;  ///< for what can be done without
  static constexpr double kClockS = 2.0;     ///< stamps that differ by less agree

  /// @param drops  the program's, to know what became of a message; may be null. Outlives the
  /// judge.
  SilenceJudge(std::vector<Expectation> expectations, const process::DropCounter* drops);

  /// A message is about to be handled.
  void heard(const process::RawMessage& raw);
  /// @param now_s  any clock that never steps back.
  void advance(double now_s);

  /// What is missed now, or would be `ahead_s` from now if nothing came.
  std::vector<Lack> lacks(double ahead_s = 0.0) const;
  /// "LIDAR 10 Hz, ODOMETRY 20 Hz" of what is expected and comes.
  std::string what_comes() const;

 private:
  struct Track {
    Expectation expected;
    std::regex pattern;
    int64_t fitting = 0;  ///< of the right type
    double first_s = 0.0, last_s = 0.0;
    double since_s = 0.0;  ///< when waiting for the first began
    std::string channel;
    std::optional<int64_t> stamp_us;
    int64_t wrong = 0;  ///< since the last that fitted
    double wrong_first_s = 0.0, wrong_last_s = 0.0;
    std::string wrong_channel;
    uint64_t wrong_fingerprint = 0;
    int64_t dropped = 0;  ///< in a row
    double dropped_first_s = 0.0;
    std::string cause;
    double clock_ahead_s = 0.0;
    double clock_agreed_s = 0.0;  ///< when it last did
    int disagreements = 0;        ///< since

    double hz() const {
      return fitting < 2 ? 0.0
                         : static_cast<double>(fitting - 1) / std::max(1e-3, last_s - first_s);
    }
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
  Track* handled_ = nullptr;             ///< the message that was told of last
  std::map<std::string, Place> places_;  ///< by sensor
  std::optional<double> clock_s_;
  double time_s_ = 0.0;
};

}  // namespace marco::diagnosis
