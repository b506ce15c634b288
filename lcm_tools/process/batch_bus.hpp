#pragma once

#include <deque>
#include <regex>
#include <string>
#include <unordered_map>
#include <vector>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/bus.hpp"

namespace marco::process {

/// A log being read as fast as the machine can: the same adapters, no network, no clock. What
/// handlers publish is delivered to the other adapters after the running handler returned, and
/// recorded, stamped with the message's own utime, so that two runs write identical bytes.
class BatchBus : public Bus {
 public:
  /// @param record receives every message, delivered or published; may be null. Outlives the bus.
  explicit BatchBus(files::EventLogWriter* record = nullptr) : record_(record) {}

  void subscribe_raw(const std::string& channel_regex, RawHandler handler) override;
  void publish_raw(const std::string& channel,
                   std::span<const uint8_t> bytes,
                   Utime utime) override;

  /// Hands one message of the log to its subscribers, then all they publish in turn.
  /// @throws what a handler throws.
  void deliver(const std::string& channel, std::span<const uint8_t> bytes, Utime event_time);

  /// Delivers what was published outside of any handler.
  void deliver_published();

 private:
  struct Subscription {
    std::regex channel;
    RawHandler handler;
  };
  struct Pending {
    std::string channel;
    std::vector<uint8_t> bytes;
    Utime utime;
  };
  const std::vector<std::size_t>& subscribers_of(const std::string& channel);
  void dispatch(const std::string& channel, std::span<const uint8_t> bytes, Utime utime);

  files::EventLogWriter* record_;
  std::vector<Subscription> subscriptions_;
  std::unordered_map<std::string, std::vector<std::size_t>> subscribers_;
  std::deque<Pending> pending_;
};

}  // namespace marco::process
