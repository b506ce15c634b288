#include "lcm_tools/log/log_info.hpp"

#include <cmath>
#include <unordered_map>

#include "lcm_tools/schema/wire.hpp"

namespace marco::logs {
namespace {

using files::LogEventHead;

bool is_text(std::span<const uint8_t> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](uint8_t byte) {
    return (byte >= 32 && byte < 127) || byte == '\n' || byte == '\t';
  });
}

uint64_t fingerprint_of(const LogEventHead& head) {
  if (is_text(head.first_bytes)) return 0;
  return lcm_schema::fingerprint_of(head.first_bytes).value_or(0);
}

struct Stamp {
  int64_t event_us;
  int64_t utime_us;
};

// One channel while the log is being read.
class ChannelSurvey {
 public:
  void add(const LogEventHead& head) {
    const Utime now = bounded(head.event_time);
    const int64_t now_us = now.us;
    const uint64_t fingerprint = fingerprint_of(head);
    if (last_type_ == nullptr || fingerprint != last_fingerprint_) {
      last_type_ = &info_.types[fingerprint];
      last_fingerprint_ = fingerprint;
    }
    ++*last_type_;
    if (info_.events++ == 0) {
      info_.first = now;
    } else {
      add_interval(now_us);
    }
    previous_us_ = now_us;
    info_.last = now;
    info_.data_bytes += head.data_bytes;
    if (head.first_bytes.size() == LogEventHead::kFirstBytes) add_stamp(head);
  }
  ChannelInfo finish(const std::string& name);

 private:
  void add_interval(int64_t now_us) {
    const int64_t interval_us = now_us - previous_us_;
    intervals_us_.add(interval_us);
    if (interval_us <= shortest_kept_us_) return;
    longest_.push_back({Utime::from_us(previous_us_), Duration::from_us(interval_us)});
    std::sort(longest_.begin(), longest_.end(),
              [](const Silence& a, const Silence& b) { return a.length > b.length; });
    constexpr std::size_t kKept = 5;
    if (longest_.size() > kKept) longest_.pop_back();
    if (longest_.size() == kKept) shortest_kept_us_ = longest_.back().length.us;
  }
  void add_stamp(const LogEventHead& head) {
    const Stamp stamp{head.event_time.us, lcm_schema::load<int64_t>(head.first_bytes.data() + 8)};
    if (stamps_seen_++ > 0 && stamp.utime_us < last_utime_us_) ++info_.utime_steps_back;
    last_utime_us_ = stamp.utime_us;
    stamps_.add(stamp);
  }
  std::optional<ClockReading> read_clock() const;

  ChannelInfo info_;
  uint64_t last_fingerprint_ = 0;
  int64_t* last_type_ = nullptr;
  int64_t previous_us_ = 0;
  int64_t shortest_kept_us_ = 0;
  int64_t stamps_seen_ = 0;
  int64_t last_utime_us_ = 0;
  std::vector<Silence> longest_;
  Decimated<int64_t> intervals_us_;
  Decimated<Stamp> stamps_;
};

std::optional<ClockReading> ChannelSurvey::read_clock() const {
  const std::vector<Stamp>& stamps = stamps_.values();
  constexpr std::size_t kEnough = 8;
  if (stamps.size() < kEnough || 10 * info_.utime_steps_back > info_.events) return std::nullopt;
  constexpr int64_t kLargestTimeUs = int64_t{1} << 53;  // the year 2255; exact in a double
  std::vector<int64_t> offsets_us, early_us, late_us;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const Stamp& stamp = stamps[i];
    if (std::abs(stamp.utime_us) > kLargestTimeUs || std::abs(stamp.event_us) > kLargestTimeUs) {
      continue;
    }
    const int64_t offset_us = stamp.event_us - stamp.utime_us;
    offsets_us.push_back(offset_us);
    if (4 * i < stamps.size()) early_us.push_back(offset_us);
    if (4 * (i + 1) > 3 * stamps.size()) late_us.push_back(offset_us);
  }
  if (2 * offsets_us.size() < stamps.size() || early_us.empty() || late_us.empty()) {
    return std::nullopt;
  }
  const auto quarter = static_cast<std::ptrdiff_t>(stamps.size() / 8);
  const Stamp& start = stamps[static_cast<std::size_t>(quarter)];
  const Stamp& end = stamps[stamps.size() - 1 - static_cast<std::size_t>(quarter)];
  const double event_s = static_cast<double>(end.event_us - start.event_us) * 1e-6;
  const double utime_s = static_cast<double>(end.utime_us - start.utime_us) * 1e-6;
  // Something that counts, but no time.
  if (!(event_s > 0.0) || utime_s < 0.5 * event_s || utime_s > 2.0 * event_s) return std::nullopt;
  ClockReading clock;
  clock.offset = Duration::from_us(quantile(offsets_us, 0.5));
  const double change_us =
      static_cast<double>(quantile(late_us, 0.5)) - static_cast<double>(quantile(early_us, 0.5));
  clock.drift_us_per_s = change_us / event_s;
  clock.drifted = Duration::from_us(static_cast<int64_t>(change_us));
  return clock;
}

ChannelInfo ChannelSurvey::finish(const std::string& name) {
  info_.name = name;
  const double span_s = (info_.last - info_.first).seconds();
  if (info_.events > 1 && span_s > 0.0) {
    info_.rate_hz = static_cast<double>(info_.events - 1) / span_s;
    info_.usual_interval = Duration::from_us(quantile(intervals_us_.values(), 0.5));
  }
  if (!longest_.empty()) info_.longest_interval = longest_.front().length;
  constexpr std::size_t kRhythm = 8;
  if (intervals_us_.values().size() >= kRhythm) {
    const int64_t slow_us = quantile(intervals_us_.values(), 0.9);
    const int64_t limit_us = std::max<int64_t>(200000, 5 * slow_us);
    for (const Silence& silence : longest_) {
      if (silence.length.us > limit_us) info_.silences.push_back(silence);
    }
  }
  info_.clock = read_clock();
  if (!info_.clock) info_.utime_steps_back = 0;
  return info_;
}

// Sorts the clocks into groups, by offset.
std::vector<ClockGroup> group_clocks(std::vector<ChannelInfo>& channels) {
  constexpr int64_t kTogetherUs = 500000;
  std::vector<ChannelInfo*> by_offset;
  for (ChannelInfo& channel : channels) {
    if (channel.clock) by_offset.push_back(&channel);
  }
  std::stable_sort(by_offset.begin(), by_offset.end(), [](const auto* a, const auto* b) {
    return a->clock->offset < b->clock->offset;
  });
  std::vector<ClockGroup> groups;
  const ChannelInfo* previous = nullptr;
  for (ChannelInfo* channel : by_offset) {
    if (previous == nullptr ||
        channel->clock->offset.us - previous->clock->offset.us > kTogetherUs) {
      groups.push_back({channel->clock->offset, {}});
    }
    groups.back().channels.push_back(channel->name);
    channel->clock->group = static_cast<int>(groups.size()) - 1;
    previous = channel;
  }
  return groups;
}

struct NameHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view name) const {
    return std::hash<std::string_view>{}(name);
  }
};

}  // namespace

bool drifts(const ClockReading& clock) {
  return std::abs(clock.drift_us_per_s) > 200.0 && std::abs(clock.drifted.us) > 20000;
}

LogInfo inspect_log(const std::filesystem::path& path, const OnProgress& on_progress) {
  constexpr int64_t kEventsBetweenProgress = 16384;
  constexpr std::size_t kStretchesKept = 100;
  constexpr std::size_t kChannelsKept = 10000;
  LogInfo info;
  files::EventLogReader reader(path.string());
  info.size_bytes = reader.size_bytes();
  std::unordered_map<std::string, ChannelSurvey, NameHash, std::equal_to<>> surveys;
  while (const auto head = reader.next_head()) {
    if (head->skipped_bytes > 0 && info.stretches.size() < kStretchesKept) {
      info.stretches.push_back({head->offset - head->skipped_bytes, head->skipped_bytes});
    }
    const Utime now = bounded(head->event_time);
    if (info.events++ == 0) {
      info.first = now;
    } else if (now < info.last) {
      ++info.event_time_steps_back;
    }
    info.last = now;
    auto entry = surveys.find(head->channel);
    if (entry == surveys.end() && surveys.size() < kChannelsKept) {
      entry = surveys.try_emplace(std::string(head->channel)).first;
    }
    if (entry != surveys.end()) entry->second.add(*head);
    if (info.events % kEventsBetweenProgress == 0) {
      on_progress(static_cast<double>(head->offset) / static_cast<double>(info.size_bytes));
    }
  }
  info.damage = reader.damage();
  int64_t told = 0;
  for (const DamagedStretch& stretch : info.stretches) told += stretch.bytes;
  if (told < info.damage.bytes_skipped && info.stretches.size() < kStretchesKept) {
    const int64_t at_end = info.damage.bytes_skipped - told;
    info.stretches.push_back({info.size_bytes - at_end, at_end});
  }
  for (auto& [name, survey] : surveys) info.channels.push_back(survey.finish(name));
  std::sort(info.channels.begin(), info.channels.end(),
            [](const ChannelInfo& a, const ChannelInfo& b) { return a.name < b.name; });
  info.clock_groups = group_clocks(info.channels);
  return info;
}

}  // namespace marco::logs
