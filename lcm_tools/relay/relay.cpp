#include "lcm_tools/relay/relay.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>

#include "lcm_tools/lcmtypes/channels.hpp"

namespace marco::relay {
namespace {

constexpr int64_t kMemoryUs = 1'000'000;

constexpr int kBus = 0;  // its side
constexpr std::chrono::seconds kBetweenTries(1);

bool is_channel_name(const std::string& name) {
  constexpr std::size_t kLongest = 63;
  return !name.empty() && name.size() <= kLongest && name.find('\0') == std::string::npos;
}

int64_t steady_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

uint64_t EchoFilter::key(int side, std::string_view channel, std::span<const uint8_t> data) {
  const std::hash<std::string_view> hash;
  const std::string_view bytes(reinterpret_cast<const char*>(data.data()), data.size());
  constexpr uint64_t kPrime = 0x9E3779B97F4A7C15;  // the golden ratio, as in Fibonacci hashing
  return (hash(bytes) * kPrime + hash(channel)) * kPrime + static_cast<uint64_t>(side);
}

void EchoFilter::forget_before(int64_t time_us) {
  while (!sent_.empty() && sent_.front().time_us < time_us) {
    const auto count = counts_.find(sent_.front().key);
    if (--count->second == 0) counts_.erase(count);
    sent_.pop_front();
  }
}

void EchoFilter::note_sent(int side,
                           std::string_view channel,
                           std::span<const uint8_t> data,
                           int64_t now_us) {
  forget_before(now_us - kMemoryUs);
  sent_.push_back({now_us, key(side, channel, data)});
  ++counts_[sent_.back().key];
}

bool EchoFilter::is_echo(int side,
                         std::string_view channel,
                         std::span<const uint8_t> data,
                         int64_t now_us) {
  forget_before(now_us - kMemoryUs);
  return counts_.contains(key(side, channel, data));
}

Relay::Relay(process::LcmBus& bus, process::DropCounter& drops, RelayOptions options)
    : bus_(bus),
      drops_(drops),
      options_(std::move(options)),
      rule_(options_.channels, options_.order_channels, options_.orders) {
  if (!options_.channels.empty()) {
    asked_for_ = "(" + options_.channels + ")|" + channels::kEmergencyStop;
  }
  if (options_.listen) listener_ = TcpSocket::listen(*options_.listen);
  for (const Endpoint& endpoint : options_.connect) outgoing_.push_back({endpoint, 0, {}, ""});
  bus_.subscribe_raw(".*", [this](const process::RawMessage& message) {
    take(kBus, std::string(message.channel), message.bytes);
  });
}

void Relay::connect_again() {
  const auto now = std::chrono::steady_clock::now();
  for (Outgoing& outgoing : outgoing_) {
    if (outgoing.side != 0 || now < outgoing.next_try) continue;
    outgoing.next_try = now + kBetweenTries;
    try {
      TcpSocket socket = TcpSocket::connect(outgoing.endpoint);
      outgoing.side = ++last_side_;
      peers_.push_back({outgoing.side, to_string(outgoing.endpoint),
                        TcpLink(std::move(socket), Role::client, asked_for_, kMostWaitingBytes)});
    } catch (const std::runtime_error& failure) {
      if (std::exchange(outgoing.last_failure, failure.what()) != failure.what()) {
        spdlog::warn("{}; trying again each second", failure.what());
      }
    }
  }
}

void Relay::accept() {
  constexpr std::size_t kMostPeers = 64;
  TcpSocket socket = listener_.accept();
  if (!socket.is_open() || peers_.size() >= kMostPeers) return;
  const int side = ++last_side_;
  peers_.push_back({side, "client " + std::to_string(side),
                    TcpLink(std::move(socket), Role::server, "", kMostWaitingBytes)});
}

void Relay::run_once(int timeout_ms) {
  connect_again();
  std::vector<pollfd> ready{{bus_.lcm().getFileno(), POLLIN, 0},
                            {listener_.descriptor(), POLLIN, 0}};
  for (const Peer& peer : peers_) {
    const int events = POLLIN | (peer.link.has_to_write() ? POLLOUT : 0);
    ready.push_back({peer.link.descriptor(), static_cast<short>(events), 0});
  }
  poll(ready.data(), ready.size(), bus_.waiting() ? 0 : timeout_ms);
  auto of_peer = ready.begin() + 2;
  for (Peer& peer : peers_) serve(peer, ((of_peer++)->revents & ~POLLOUT) != 0);
  if ((ready[1].revents & POLLIN) != 0) accept();
  constexpr int kMessagesInARow = 100;
  for (int i = 0; i < kMessagesInARow && bus_.handle_once(0); ++i) {
  }
  std::erase_if(peers_, [](const Peer& peer) { return peer.is_over; });
}

void Relay::serve(Peer& peer, bool is_readable) {
  const bool was_greeted = peer.link.is_greeted();
  try {
    if (is_readable) {
      peer.link.read([&](const Frame& frame) {
        ++in_;
        take(peer.side, frame.channel, frame.data);
      });
    }
    peer.link.write();
    if (!was_greeted && peer.link.is_greeted()) spdlog::info("connected: {}", peer.name);
  } catch (const std::exception& failure) {
    end(peer, failure.what());
  }
}

void Relay::end(Peer& peer, const std::string& why) {
  peer.is_over = true;
  count_lost(peer.link.drop_waiting());
  const auto outgoing = std::find_if(outgoing_.begin(), outgoing_.end(),
                                     [&](const Outgoing& one) { return one.side == peer.side; });
  const bool was_peer = peer.link.is_greeted();
  const bool is_new = outgoing == outgoing_.end() || was_peer || outgoing->last_failure != why;
  if (is_new) {
    spdlog::warn("{}: {}: {}{}", peer.name, was_peer ? "disconnected" : "no connection", why,
                 outgoing != outgoing_.end() ? "; trying again each second" : "");
  }
  if (outgoing == outgoing_.end()) return;
  outgoing->side = 0;
  outgoing->last_failure = was_peer ? "" : why;
  outgoing->next_try = std::chrono::steady_clock::now() + kBetweenTries;
}

void Relay::take(int from_side, const std::string& channel, std::span<const uint8_t> data) {
  const int64_t now_us = steady_us();
  if (from_side != kBus) drops_.count_received();
  if (!is_channel_name(channel)) return drops_.count("an invalid LCM channel name");
  if (echoes_.is_echo(from_side, channel, data, now_us)) return;
  if (!rule_.passes(channel, data)) {
    if (from_side != kBus) drops_.count("orders held back (--orders): " + channel);
    return;
  }
  std::map<std::string, int64_t> lost;
  for (Peer& peer : peers_) {
    if (peer.side == from_side || peer.is_over || !peer.link.send(channel, data, lost)) continue;
    echoes_.note_sent(peer.side, channel, data, now_us);
    ++out_;
  }
  count_lost(lost);
  if (from_side == kBus) return;
  echoes_.note_sent(kBus, channel, data, now_us);
  try {
    bus_.publish_raw(channel, data, {});
  } catch (const std::runtime_error&) {  // the network is down: it may come back
    drops_.count("LCM could not send: " + channel);
  }
}

void Relay::count_lost(const std::map<std::string, int64_t>& lost) {
  for (const auto& [channel, count] : lost) {
    for (int64_t i = 0; i < count; ++i) drops_.count("the connection is too slow: " + channel);
  }
}

std::string Relay::state() const {
  const auto connected = std::count_if(peers_.begin(), peers_.end(),
                                       [](const Peer& peer) { return peer.link.is_greeted(); });
  const int64_t datagrams = bus_.lost_datagrams();
  return std::to_string(connected) + " connections, " + std::to_string(in_) + " in, " +
         std::to_string(out_) + " out, " + std::to_string(drops_.dropped()) + " lost" +
         (datagrams > 0 ? ", " + std::to_string(datagrams) + " datagrams lost in the receive buffer"
                        : "");
}

}  // namespace marco::relay
