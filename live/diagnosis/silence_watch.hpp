#pragma once

#include <atomic>
#include <future>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "live/diagnosis/silence_text.hpp"

namespace marco::process {
class LcmBus;
}

namespace marco::diagnosis {

/// A message for the user.
struct Note {
  bool trouble = true;  ///< false: it is over
  std::string text;     ///< lines without an LF at the end
};

/// Explains why a live program receives nothing: what it waits for, what is on the bus instead, and
/// what to do. Costs next to nothing while all is well; while an input is missing, a thread listens
/// to the whole bus.
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

  /// @param bus  subscribes the expected channels, now or later. Outlives the watch, as the drops
  /// do.
  SilenceWatch(process::LcmBus& bus, Options options);
  ~SilenceWatch();
  SilenceWatch(const SilenceWatch&) = delete;
  SilenceWatch& operator=(const SilenceWatch&) = delete;

  /// Call after each message or timeout, on the bus's thread.
  std::optional<Note> step();

  /// Before a program gives up: what it missed, unless already reported. Takes up to 3 s.
  std::optional<Note> last_word();

  /// One line for PROCESS_STATUS: what is missing, then `otherwise`.
  std::string state(const std::string& otherwise) const;

  /// What is missing, as of the last step.
  const std::vector<Lack>& lacks() const { return lacks_; }
  /// What was found on the network meanwhile; empty while nothing is missing.
  std::vector<Finding> network() const;

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

/// What Marco's programs wait for.
enum class Awaited { odometry, slam_poses, pantilt, laser_on_pantilt, map, base };
Expectation expect(Awaited what);
/// Scans on the channels of `pattern`. @param channels  the same for the user
Expectation expect_scans(const std::string& pattern, const std::string& channels);

}  // namespace marco::diagnosis
