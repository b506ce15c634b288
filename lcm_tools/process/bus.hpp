#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "lcm_tools/base/utime.hpp"
#include "lcm_tools/process/drop_counter.hpp"

namespace marco::process {

/// The bytes of a message and its time on this bus: arrival (live) or the log's event time (batch).
struct RawMessage {
  std::string_view channel;
  std::span<const uint8_t> bytes;
  Utime event_time;
};

/// Messages in and out: the LCM network (LcmBus) or a log being read (BatchBus), so that one
/// adapter serves live use, tests and batch (as Drake's interface / network / log trio). Handlers
/// run on the thread that runs the bus, one at a time, in the order of subscription.
class Bus {
 public:
  using RawHandler = std::function<void(const RawMessage&)>;

  virtual ~Bus() = default;

  /// @param channel_regex POSIX extended, matched against the whole channel name.
  virtual void subscribe_raw(const std::string& channel_regex, RawHandler handler) = 0;

  /// @param utime the message's own stamp: a recorded batch run is ordered and stamped by it.
  virtual void publish_raw(const std::string& channel,
                           std::span<const uint8_t> bytes,
                           Utime utime) = 0;

  /// Messages dropped for each channel, oldest first, because they came faster than they were
  /// handled. Always empty in batch.
  virtual std::map<std::string, int64_t> lost() const { return {}; }

  /// Datagrams, pieces of large messages or several small ones, that the system has dropped because
  /// the receive buffer was full.
  virtual int64_t lost_datagrams() const { return 0; }

  /// Messages that do not decode to the last byte are counted in `drops` as "undecodable". If
  /// `handler` throws std::invalid_argument, the message is counted under that text.
  template <class Message>
  void subscribe(const std::string& channel_regex,
                 DropCounter& drops,
                 std::function<void(const Message&, const RawMessage&)> handler) {
    subscribe_raw(channel_regex, [&drops, handler = std::move(handler)](const RawMessage& raw) {
      Message message;
      const int size = static_cast<int>(raw.bytes.size());
      drops.count_received();
      if (message.decode(raw.bytes.data(), 0, size) != size) {
        drops.count("undecodable");
        return;
      }
      try {
        handler(message, raw);
      } catch (const std::invalid_argument& bad_message) {
        drops.count(bad_message.what());
      }
    });
  }

  /// Messages carry `utime` first in every type of ours.
  template <class Message>
  void publish(const std::string& channel, const Message& message) {
    buffer_.resize(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(buffer_.data(), 0, static_cast<int>(buffer_.size()));
    publish_raw(channel, buffer_, Utime::from_us(message.utime));
  }

 private:
  std::vector<uint8_t> buffer_;
};

}  // namespace marco::process
