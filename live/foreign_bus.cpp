#include "live/foreign_bus.hpp"

#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace marco {
namespace {

constexpr Duration kAnnounceEvery = Duration::from_us(1'000'000);  // as drivers do
// A bus may carry channels without end.
constexpr std::size_t kMostChannels = 1000;

// Encoders are odometry, too.
std::string role_of(const ForeignChannel& entry) {
  return entry.meaning == "encoders" ? "odometry" : entry.meaning;
}

bool is_sensor(const ForeignChannel& entry) {
  return entry.meaning == "lidar" || role_of(entry) == "odometry";
}

// As our drivers fill our channels.
bool is_own(const std::string& channel, const std::string& type) {
  static const ChannelPattern kOwn(channels::kLidarPattern);
  if (!kOwn.matches(channel)) return false;
  return type == (channels::is_raw_lidar(channel) ? fingerprint_of<lidar_raw_t>()
                                                  : fingerprint_of<bot_core::planar_lidar_t>());
}

}  // namespace

ForeignBus::ForeignBus(process::LcmBus& bus,
                       ForeignTable table,
                       std::function<void(const std::string&)> say)
    : bus_(bus), table_(std::move(table)), say_(std::move(say)) {
  for (const ForeignChannel& entry : table_.channels) types_.insert(entry.fingerprint);
  // First, so that it decides before other handlers ask.
  bus_.subscribe_some(
      ".*", [this](const auto& raw) { return may_be_foreign(raw.bytes); },
      [this](const auto& raw) { take(raw); });
  bus_.subscribe<sensor_info_t>(channels::kSensorInfo, drops_, [this](const auto& info, auto&) {
    has_own_laser_ = has_own_laser_ || info.channel.starts_with(channels::kLidar);
  });
}

void ForeignBus::subscribe_raw(const std::string& channel_regex, RawHandler handler) {
  handlers_.emplace_back(ChannelPattern(channel_regex), handler);
  bus_.subscribe_raw(channel_regex,
                     [this, handler = std::move(handler)](const process::RawMessage& raw) {
                       if (!is_used(raw)) handler(raw);
                     });
}

bool ForeignBus::may_be_foreign(std::span<const uint8_t> bytes) const {
  return types_.contains(fingerprint_in(bytes));
}

bool ForeignBus::is_used(const process::RawMessage& raw) const {
  if (meanings_.empty()) return false;
  const auto channel = channels_.find({std::string(raw.channel), fingerprint_in(raw.bytes)});
  return channel != channels_.end() && channel->second.is_used;
}

std::vector<std::pair<std::string, std::string>> ForeignBus::used() const {
  std::vector<std::pair<std::string, std::string>> used;
  for (const auto& [key, channel] : channels_) {
    if (channel.is_used) used.push_back(key);
  }
  return used;
}

void ForeignBus::take(const process::RawMessage& raw) {
  const Key key{std::string(raw.channel), fingerprint_in(raw.bytes)};
  auto known = channels_.find(key);
  if (known == channels_.end()) {
    if (channels_.size() >= kMostChannels) return;
    known = channels_.try_emplace(key).first;
    if (!is_own(key.first, key.second)) {
      known->second.entry = entry_of(table_, key.first, key.second);
    }
  }
  Foreign& channel = known->second;
  if (channel.entry == nullptr || !may_be_used(channel)) {
    channel.is_used = false;
    return;
  }
  drops_.count_received();
  try {
    const Sample sample = messages_.decode(raw.bytes, *channel.entry);
    if (!channel.is_used) use(key, channel);
    if (const auto* scan = std::get_if<LaserScan>(&sample)) {
      announce(*scan, *channel.entry, raw.event_time);
    }
    deliver(sample, raw.event_time);
  } catch (const std::invalid_argument& fault) {
    drops_.count(key.first + ": " + fault.what());
  }
}

bool ForeignBus::may_be_used(const Foreign& channel) const {
  if (!is_sensor(*channel.entry)) return false;
  if (channel.entry->meaning == "lidar" && has_own_laser_) return false;
  return channel.is_used || !meanings_.contains(role_of(*channel.entry));
}

void ForeignBus::use(const Key& key, Foreign& channel) {
  channel.is_used = true;
  meanings_.insert(role_of(*channel.entry));
  if (!say_) return;
  const bool is_laser = channel.entry->meaning == "lidar";
  say_(key.first + " (" + key.second + ") is another system's " + channel.entry->meaning +
       (is_laser
            ? ": used, mounted at the turning centre, looking ahead (override with --calibration)"
            : ": used"));
}

void ForeignBus::announce(const LaserScan& scan, const ForeignChannel& entry, Utime now) {
  const bool is_early =
      announced_ && scan.utime >= *announced_ && scan.utime - *announced_ < kAnnounceEvery;
  if (is_early) return;
  announced_ = scan.utime;
  deliver(messages_.info_of(scan, entry), now);
}

void ForeignBus::deliver(const Sample& sample, Utime now) {
  const EncodedMessage message = encode_sample(sample);
  const process::RawMessage raw{message.channel, message.bytes, now};
  bus_.tell_tap(raw);
  for (const auto& [pattern, handler] : handlers_) {
    if (pattern.matches(message.channel)) handler(raw);
  }
}

}  // namespace marco
