#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <unordered_map>

namespace marco::relay {

/// Recognises messages that come back from where they were sent: multicast returns our own ones,
/// and where two hosts are connected by multicast and by the relay, messages would go round for
/// ever. A message is an echo when the same one, of channel and bytes, was sent to that side within
/// a second. Messages carry a stamp, so that two senders' messages differ.
class EchoFilter {
 public:
  /// @param side  a number that the caller gives each side
  void note_sent(int side, std::string_view channel, std::span<const uint8_t> data, int64_t now_us);
  bool is_echo(int side, std::string_view channel, std::span<const uint8_t> data, int64_t now_us);

 private:
  static uint64_t key(int side, std::string_view channel, std::span<const uint8_t> data);
  void forget_before(int64_t time_us);

  struct Sent {
    int64_t time_us;
    uint64_t key;
  };
  std::deque<Sent> sent_;
  std::unordered_map<uint64_t, int> counts_;  // of keys in sent_
};

}  // namespace marco::relay
