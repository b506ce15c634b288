#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lcm_tools/log/select.hpp"

namespace marco::logs {

/// Keeps an even pick of a stream of values in constant memory: every 2^k-th, k growing as the
/// stream does. The same stream gives the same pick.
template <class Value>
class Decimated {
 public:
  void add(const Value& value) {
    if ((count_++ & mask_) != 0) return;
    if (values_.size() == kCapacity) {
      for (std::size_t i = 0; 2 * i < values_.size(); ++i) values_[i] = values_[2 * i];
      values_.resize(kCapacity / 2);
      const bool dropped = ((count_ - 1) & (2 * mask_ + 1)) != 0;
      mask_ = 2 * mask_ + 1;
      if (dropped) return;
    }
    values_.push_back(value);
  }
  const std::vector<Value>& values() const { return values_; }

 private:
  static constexpr std::size_t kCapacity = 1024;
  std::vector<Value> values_;
  uint64_t count_ = 0;
  uint64_t mask_ = 0;
};

/// The value of which `part` (0..1) of the others are smaller. @param values not empty
template <class Value>
Value quantile(std::vector<Value> values, double part) {
  const auto place = values.begin() + std::lround(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// A time without a message, longer than the channel's rhythm explains.
struct Silence {
  Utime from;
  Duration length;
};

/// How the stamps inside a channel's messages run against the log's event times.
struct ClockReading {
  Duration offset;            ///< event time - utime, the median
  double drift_us_per_s = 0;  ///< change of the offset: > 0 = its clock is slow
  Duration drifted;           ///< over the whole log
  int group = -1;             ///< index of LogInfo::clock_groups
};

struct ChannelInfo {
  std::string name;
  std::map<uint64_t, int64_t> types;  ///< fingerprint -> events; 0 = no fingerprint (text, short)
  int64_t events = 0;
  int64_t data_bytes = 0;
  Utime first;
  Utime last;
  double rate_hz = 0.0;     ///< events - 1 over the time between first and last
  Duration usual_interval;  ///< median
  Duration longest_interval;
  std::vector<Silence> silences;  ///< at most 5, the longest first
  int64_t utime_steps_back = 0;
  std::optional<ClockReading> clock;  ///< when the messages begin with a running utime
};

/// Channels whose clocks agree within half a second.
struct ClockGroup {
  Duration offset;  ///< event time - utime of one of them
  std::vector<std::string> channels;
};

struct DamagedStretch {
  int64_t offset = 0;  ///< [byte]
  int64_t bytes = 0;
};

struct LogInfo {
  int64_t size_bytes = 0;
  int64_t events = 0;
  Utime first;  ///< of the first event in the file (a damaged time elsewhere does not matter)
  Utime last;   ///< of the last
  int64_t event_time_steps_back = 0;
  std::vector<ChannelInfo> channels;      ///< by name
  std::vector<ClockGroup> clock_groups;   ///< more than one: clocks disagree
  std::vector<DamagedStretch> stretches;  ///< the first 100
  files::LogDamage damage;
};

/// Looks through a log once, at headers, fingerprints and stamps only.
/// Memory does not depend on the log's length: medians come from at most 1024 evenly picked values
/// a channel.
/// A channel has a clock when the 8 bytes behind the fingerprint grow as the event times do.
/// @throws std::invalid_argument as EventLogReader.
LogInfo inspect_log(const std::filesystem::path& path, const OnProgress& on_progress);

/// Whether a channel's stamps drift by more than 200 ppm and 20 ms.
bool drifts(const ClockReading& clock);

/// Name of a message type by its fingerprint, or "" when it is not known.
using TypeNames = std::function<std::string(uint64_t fingerprint)>;

/// For the user: a table, and remarks below it.
std::string to_text(const LogInfo& info, const std::string& name, const TypeNames& type_names);

/// The same as JSON.
std::string to_json(const LogInfo& info, const std::string& name, const TypeNames& type_names);

}  // namespace marco::logs
