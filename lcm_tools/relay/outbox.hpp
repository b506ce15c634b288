#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace marco::relay {

/// Messages that wait for a slow connection, of a bounded size. When it is full, the oldest message
/// of the channel that holds most bytes goes: pictures, before poses suffer.
class Outbox {
 public:
  struct Message {
    std::string channel;
    std::vector<uint8_t> data;
  };

  explicit Outbox(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// @returns the channels of messages that were dropped for it, the new one perhaps among them
  std::vector<std::string> add(std::string channel, std::span<const uint8_t> data);
  /// The oldest.
  std::optional<Message> take();
  bool empty() const { return messages_.empty(); }
  std::size_t bytes() const { return bytes_; }
  /// Messages of each channel, which are dropped.
  std::map<std::string, int64_t> clear();

 private:
  static std::size_t cost(const Message& message);
  std::string drop_one();
  void forget(const Message& message);

  std::size_t most_bytes_;
  std::size_t bytes_ = 0;
  std::deque<Message> messages_;
  std::map<std::string, std::size_t> bytes_by_channel_;
};

}  // namespace marco::relay
