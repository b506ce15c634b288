#include "lcm_tools/process/batch_bus.hpp"

namespace marco::process {

void BatchBus::subscribe_raw(const std::string& channel_regex, RawHandler handler) {
  subscriptions_.push_back({ChannelPattern(channel_regex), std::move(handler)});
  subscribers_.clear();
}

void BatchBus::publish_raw(const std::string& channel,
                           std::span<const uint8_t> bytes,
                           Utime utime) {
  pending_.push_back({channel, {bytes.begin(), bytes.end()}, utime});
}

void BatchBus::deliver(const std::string& channel,
                       std::span<const uint8_t> bytes,
                       Utime event_time) {
  if (recorded_ == Recorded::all) record(channel, bytes, event_time);
  dispatch(channel, bytes, event_time);
  deliver_published();
}

void BatchBus::deliver_published() {
  while (!pending_.empty()) {
    const Pending next = std::move(pending_.front());
    pending_.pop_front();
    record(next.channel, next.bytes, next.utime);
    dispatch(next.channel, next.bytes, next.utime);
  }
}

void BatchBus::record(const std::string& channel, std::span<const uint8_t> bytes, Utime utime) {
  if (record_ != nullptr) record_->write(channel, bytes, utime);
}

void BatchBus::dispatch(const std::string& channel, std::span<const uint8_t> bytes, Utime utime) {
  for (const std::size_t index : subscribers_of(channel)) {
    subscriptions_[index].handler({channel, bytes, utime});
  }
}

const std::vector<std::size_t>& BatchBus::subscribers_of(const std::string& channel) {
  const auto [entry, is_new] = subscribers_.try_emplace(channel);
  if (is_new) {
    for (std::size_t i = 0; i < subscriptions_.size(); ++i) {
      if (subscriptions_[i].channel.matches(channel)) entry->second.push_back(i);
    }
  }
  return entry->second;
}

}  // namespace marco::process
