#pragma once

#include <atomic>
#include <future>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/diagnosis/process/silence_text.hpp"

namespace marco::process {
class LcmBus;
}

namespace marco::diagnosis {

/// A message for a person.
struct Note {
  bool trouble = true;  ///< false: all is well again
  std::string text;     ///< lines without an LF at the end
};

/// Explains why a live program receives nothing: what it waits for, what is on the bus instead, and
/// the remedy. Costs next to nothing while messages arrive; while some are missing, a thread
/// listens to the whole bus.
///
/// Reports three seconds after the start, or ten after the last message; again when the situation
/// changes, and after one minute, two, four...
class SilenceWatch {
 public:
  struct Options {
    std::string program;  ///< "marco-slam"
    std::string url;      ///< as given on the command line
    std::vector<Expectation> expectations;
    const process::DropCounter* drops = nullptr;
  };

  /// @param bus  subscribes to the expected channels. Outlives the watch, as the drops do.
  SilenceWatch(process::LcmBus& bus, Options options);
  ~SilenceWatch();
  SilenceWatch(const SilenceWatch&) = delete;
  SilenceWatch& operator=(const SilenceWatch&) = delete;

  /// Call after each message or timeout, on the bus's thread.
  std::optional<Note> step();

  /// For a program that gives up: what it missed, unless reported. Takes up to three seconds.
  std::optional<Note> last_word();

  /// One line for PROCESS_STATUS: what is missing, else `otherwise`.
  std::string state(const std::string& otherwise) const;

 private:
  void look(double now_s);
  std::optional<Note> tell(double now_s);

  Options options_;
  SilenceJudge judge_;
  std::optional<UdpUrl> url_;  ///< nothing: a transport that cannot be surveyed
  std::atomic<bool> stop_ = false;
  std::future<BusSurvey> looking_;
  std::optional<BusSurvey> survey_;
  double surveyed_s_ = 0.0;
  std::vector<Lack> lacks_;
  std::set<std::string> told_;  ///< situations reported of this silence
  double told_s_ = 0.0;
  double tell_again_s_ = 0.0;
};

/// Logs a note: trouble as a warning.
void log_note(const std::optional<Note>& note);

// The expectations of Marco's programs.
Expectation expect_scans(const std::string& pattern, const std::string& channels);
Expectation expect_odometry();
Expectation expect_slam_poses();
Expectation expect_pantilt();
Expectation expect_laser_on_pantilt();
Expectation expect_map();
Expectation expect_base();

}  // namespace marco::diagnosis
