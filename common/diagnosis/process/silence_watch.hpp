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

/// What is to be said to a person.
struct Note {
  bool trouble = true;  ///< false: it is over
  std::string text;     ///< lines without an LF at the end
};

/// Tells why a live program hears nothing: what it waits for, what is on the bus instead, and what
/// to do. Costs next to nothing while all is well; while something is missed, a thread listens to
/// the whole bus.
///
/// Said once three seconds after the start, or ten after the last message; again when the situation
/// changes, and after one minute, two, four...
class SilenceWatch {
 public:
  struct Options {
    std::string program;  ///< "marco-slam"
    std::string url;      ///< as given on the command line
    std::vector<Expectation> expectations;
    const process::DropCounter* drops = nullptr;
  };

  /// @param bus  hears the expected channels already, or will. Outlives the watch, as the drops do.
  SilenceWatch(process::LcmBus& bus, Options options);
  ~SilenceWatch();
  SilenceWatch(const SilenceWatch&) = delete;
  SilenceWatch& operator=(const SilenceWatch&) = delete;

  /// Call after each message or timeout, on the bus's thread.
  std::optional<Note> step();

  /// Before a program gives up: what it missed, unless that was told. Takes up to three seconds.
  std::optional<Note> last_word();

  /// One line for PROCESS_STATUS: what is missed, before `otherwise`.
  std::string state(const std::string& otherwise) const;

 private:
  void look(double now_s);
  std::optional<Note> tell(double now_s);

  Options options_;
  SilenceJudge judge_;
  std::optional<UdpUrl> url_;  ///< nothing: another transport, which nobody can listen to
  std::atomic<bool> stop_ = false;
  std::future<BusSurvey> looking_;
  std::optional<BusSurvey> survey_;
  double surveyed_s_ = 0.0;
  std::vector<Lack> lacks_;
  std::set<std::string> told_;  ///< situations of this silence
  double told_s_ = 0.0;
  double tell_again_s_ = 0.0;
};

/// Logs a note: trouble as a warning.
void log_note(const std::optional<Note>& note);

// What Marco's programs wait for.
Expectation expect_scans(const std::string& pattern, const std::string& channels);
Expectation expect_odometry();
Expectation expect_slam_poses();
Expectation expect_pantilt();
Expectation expect_laser_on_pantilt();
Expectation expect_map();
Expectation expect_base();

}  // namespace marco::diagnosis
