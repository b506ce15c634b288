#pragma once

#include <functional>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "lcm_tools/log/channel_choice.hpp"
#include "lcm_tools/log/moment.hpp"

namespace marco::logs {

/// New names for channels.
class ChannelRenames {
 public:
  /// @param rules "OLD=NEW": OLD a name or a POSIX extended regular expression over the whole name,
  /// NEW may use $1..$9. The first that fits holds.
  /// @throws std::invalid_argument quoting a rule that cannot be understood.
  explicit ChannelRenames(const std::vector<std::string>& rules);

  /// @returns `channel` itself when no rule fits.
  std::string operator()(const std::string& channel) const;

 private:
  std::vector<std::pair<std::regex, std::string>> rules_;
};

struct PlayerOptions {
  TimeRange range;     ///< what is played, and looped over
  double speed = 1.0;  ///< > 0; 0 = as fast as possible
  bool loop = false;
  bool paused = false;
  Duration longest_wait = Duration::from_us(INT64_MAX);  ///< longer silences are shortened
};

/// Plays a log against a clock that the caller passes in. Knows neither LCM nor terminal:
/// `now_us` is any monotonic clock in microseconds.
///
/// Events are played in the order of the file. An event more than a second earlier than its
/// predecessor, or due more than half a second ago, resets the mapping from log time to clock:
/// after a pause of the machine the log resumes without a burst. Seeking is a binary search over
/// event times: about 30 reads, whatever the length of the file.
class Player {
 public:
  /// @returns whether the event was published and counts in published()
  using Publish = std::function<bool(
      const std::string& channel, std::span<const uint8_t> bytes, Utime event_time)>;

  /// @throws std::invalid_argument as EventLogReader, and when speed is negative.
  Player(const std::string& path,
         ChannelChoice channels,
         const PlayerOptions& options,
         Publish publish);

  /// Publishes what is due, at most 256 events a call.
  /// @returns when to call again; nothing while paused or finished.
  std::optional<int64_t> advance(int64_t now_us);

  void set_paused(bool paused, int64_t now_us);
  void set_speed(double speed, int64_t now_us);
  void set_loop(bool loop) { options_.loop = loop; }

  /// Publishes the next event at once and pauses.
  void step(int64_t now_us);

  /// Continues at the first event at or after `time`.
  void seek(Utime time, int64_t now_us);

  /// Continues at the start of the range; without a range, at the first event of the file.
  void rewind(int64_t now_us);

  /// Bounds playing, with and without a loop.
  void set_range(const TimeRange& range) { options_.range = range; }

  bool paused() const { return options_.paused; }
  bool finished() const { return finished_; }
  bool looping() const { return options_.loop; }
  double speed() const { return options_.speed; }
  const TimeRange& range() const { return options_.range; }
  const LogSpan& span() const { return span_; }
  /// Event time of the last published event, or of the last seek.
  Utime position() const { return position_; }
  /// Event time of the next event.
  std::optional<Utime> next_time() const;
  int64_t published() const { return published_; }
  const files::LogDamage& damage() const { return reader_.damage(); }

 private:
  bool load_next();
  void stand_at(Utime time, int64_t now_us);
  void publish_next();
  void start_count_at(Utime event_time, int64_t now_us);
  int64_t due_us(Utime event_time) const;

  files::EventLogReader reader_;
  ChannelChoice channels_;
  PlayerOptions options_;
  Publish publish_;
  LogSpan span_;
  std::optional<files::LogEventHead> next_;
  Utime position_;
  Utime count_event_;         // the moment of the log that belongs to
  int64_t count_now_us_ = 0;  // this moment of the clock
  bool count_started_ = false;
  bool finished_ = false;
  int64_t published_ = 0;
};

}  // namespace marco::logs
