#include "lcm_tools/relay/outbox.hpp"

#include <algorithm>
#include <utility>

namespace marco::relay {

// Memory per message besides its bytes; otherwise millions of empty ones would be free.
std::size_t Outbox::cost(const Message& message) {
  constexpr std::size_t kBookkeeping = 128;
  return message.data.size() + kBookkeeping;
}

std::vector<std::string> Outbox::add(std::string channel, std::span<const uint8_t> data) {
  messages_.push_back({std::move(channel), {data.begin(), data.end()}});
  bytes_ += cost(messages_.back());
  bytes_by_channel_[messages_.back().channel] += cost(messages_.back());
  std::vector<std::string> dropped;
  while (bytes_ > most_bytes_) dropped.push_back(drop_one());
  return dropped;
}

std::string Outbox::drop_one() {
  const auto largest =
      std::max_element(bytes_by_channel_.begin(), bytes_by_channel_.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto oldest = std::find_if(messages_.begin(), messages_.end(), [&](const auto& message) {
    return message.channel == largest->first;
  });
  const Message message = std::move(*oldest);
  messages_.erase(oldest);
  forget(message);
  return message.channel;
}

void Outbox::forget(const Message& message) {
  bytes_ -= cost(message);
  const auto channel = bytes_by_channel_.find(message.channel);
  channel->second -= cost(message);
  if (channel->second == 0) bytes_by_channel_.erase(channel);
}

std::optional<Outbox::Message> Outbox::take() {
  if (messages_.empty()) return std::nullopt;
  Message first = std::move(messages_.front());
  messages_.pop_front();
  forget(first);
  return first;
}

std::map<std::string, int64_t> Outbox::clear() {
  std::map<std::string, int64_t> counts;
  for (const Message& message : messages_) ++counts[message.channel];
  messages_.clear();
  bytes_by_channel_.clear();
  bytes_ = 0;
  return counts;
}

}  // namespace marco::relay
