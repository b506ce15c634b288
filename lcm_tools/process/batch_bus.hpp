#pragma once

#include <deque>
#include <string>
#include <unordered_map>
#include <vector>

#include "lcm_tools/files/channel_pattern.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/bus.hpp"

namespace marco::process {

/// Replays a log as fast as the machine can: the same adapters, no network, no clock. Messages that
/// handlers publish are delivered after the running handler returns, and recorded with the
/// message's own utime, so that two runs write identical bytes.
class BatchBus : public Bus {
 public:
  enum class Recorded { all, published };

  /// @param record  receives every message, delivered or published; may be null; outlives the bus
  /// @param recorded  `published`: what is delivered is left out of the record
  explicit BatchBus(files::EventLogWriter* record = nullptr, Recorded recorded = Recorded::all)
      : record_(record), recorded_(recorded) {}

  void subscribe_raw(const std::string& channel_regex, RawHandler handler) override;
  void publish_raw(const std::string& channel,
                   std::span<const uint8_t> bytes,
                   Utime utime) override;

  /// Delivers one message of the log, then everything its handlers published in turn.
  /// @throws what a handler throws.
  void deliver(const std::string& channel, std::span<const uint8_t> bytes, Utime event_time);

  /// Delivers messages that were published outside of handlers.
  void deliver_published();

 private:
  struct Subscription {
    ChannelPattern channel;
    RawHandler handler;
  };
  struct Pending {
    std::string channel;
    std::vector<uint8_t> bytes;
    Utime utime;
  };
  const std::vector<std::size_t>& subscribers_of(const std::string& channel);
  void record(const std::string& channel, std::span<const uint8_t> bytes, Utime utime);
  void dispatch(const std::string& channel, std::span<const uint8_t> bytes, Utime utime);

  files::EventLogWriter* record_;
  Recorded recorded_;
  std::vector<Subscription> subscriptions_;
  std::unordered_map<std::string, std::vector<std::size_t>> subscribers_;
  std::deque<Pending> pending_;
};

}  // namespace marco::process
