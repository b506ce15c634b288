#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::files {

/// What a reader found in its input: for report.json and the summary of `marco map`.
struct InputReport {
  std::string format;  ///< "CARMEN log", "LCM log", ...
  std::vector<std::string> paths;
  std::map<std::string, int64_t> given;       ///< samples by kind
  std::map<std::string, int64_t> dropped;     ///< by cause
  std::map<std::string, std::string> places;  ///< first place of each cause: "line 12", "byte 4711"
  std::vector<std::string> notes;             ///< assumptions and oddities
  int64_t pictures = 0;                       ///< of cameras, which are not samples

  void drop(const std::string& cause, const std::string& place) {
    if (++dropped[cause] == 1) places[cause] = place;
  }
};

/// A recording as a stream of values, in the order of its file.
class SampleReader {
 public:
  virtual ~SampleReader() = default;

  /// The next sample; nothing at the end.
  virtual std::optional<Sample> next() = 0;

  /// Complete when next() has returned nothing.
  virtual const InputReport& report() const = 0;

  /// Part of the input that was read, 0..1.
  virtual double progress() const = 0;
};

/// Base of all our readers. A subclass reads one piece of its recording at a time (a line, an
/// event, a file) and queues the samples in it.
class QueuedReader : public SampleReader {
 public:
  std::optional<Sample> next() final;
  const InputReport& report() const final { return report_; }

 protected:
  /// Reads one piece, which may hold no sample. @returns false at the end of the recording.
  virtual bool read_piece() = 0;
  /// Called once, at the end.
  virtual void finish_report() {}

  void queue(Sample sample);
  void queue_odometry(Utime utime, const Pose2& odom_from_robot);
  /// Adds a note in the style of printf.
  [[gnu::format(printf, 2, 3)]] void note(const char* format, ...);

  InputReport report_;

 private:
  void watch_stamps(const LaserScan& scan);
  void note_stamps();

  std::deque<Sample> queue_;
  bool ended_ = false;
  std::map<std::string, Utime> last_stamp_;  ///< of each laser's scans
  int64_t scans_ = 0, equal_stamps_ = 0, far_stamps_ = 0;
};

}  // namespace marco::files
