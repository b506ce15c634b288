#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/relay/channel_rule.hpp"
#include "lcm_tools/relay/tcp_link.hpp"

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

struct RelayOptions {
  std::optional<Endpoint> listen;  ///< where others may connect
  std::vector<Endpoint> connect;   ///< to whom to connect, again and again
  std::string channels;            ///< see ChannelRule
  std::vector<std::string> order_channels;
  ChannelRule::Orders orders = ChannelRule::Orders::held_back;
};

/// Joins an LCM bus and connections of TCP: a message from any of them goes to all others, by the
/// rule, once. A connection that ends is made again each second; nothing waits for it meanwhile.
///
///     udpm://  <->  LcmBus  <->  rule, echo filter  <->  Outbox  <->  TCP (tcpq)
///
/// Of one thread.
class Relay {
 public:
  /// Of what waits for one connection: a second or two of scans, poses and maps on a slow link.
  static constexpr std::size_t kMostWaitingBytes = std::size_t{8} << 20U;

  /// @param bus, drops  outlive it. @throws std::runtime_error when it cannot listen.
  Relay(process::LcmBus& bus, process::DropCounter& drops, RelayOptions options);

  /// Waits up to `timeout_ms` for something to do, and does it.
  void run_once(int timeout_ms);
  /// "2 connections, 120 in, 3000 out, 0 lost, 7 datagrams lost in the receive buffer".
  std::string state() const;

 private:
  struct Peer {
    int side;          // for the echo filter
    std::string name;  // for the user
    TcpLink link;
    bool is_over = false;
  };
  struct Outgoing {
    Endpoint endpoint;
    int side = 0;  // of its peer while it is connected; 0 = not
    std::chrono::steady_clock::time_point next_try;
    std::string last_failure;
  };

  void connect_again();
  void accept();
  void serve(Peer& peer, bool is_readable);
  void end(Peer& peer, const std::string& why);
  void take(int from_side, const std::string& channel, std::span<const uint8_t> data);
  void count_lost(const std::map<std::string, int64_t>& lost);

  process::LcmBus& bus_;
  process::DropCounter& drops_;
  RelayOptions options_;
  ChannelRule rule_;
  std::string asked_for_ = ".*";  // of the servers
  EchoFilter echoes_;
  TcpSocket listener_;
  std::vector<Outgoing> outgoing_;
  std::list<Peer> peers_;
  int last_side_ = 0;  // 0 is the bus
  int64_t in_ = 0, out_ = 0;
};

}  // namespace marco::relay
