#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lcm_tools/files/channel_pattern.hpp"
#include "lcm_tools/relay/tcp_socket.hpp"
#include "lcm_tools/relay/tcpq.hpp"

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

/// One connection of tcpq. It never blocks; what the other side does not take waits in an Outbox.
class TcpLink {
 public:
  /// @param own_role   server for a connection that came in
  /// @param expression that a client asks the server for
  TcpLink(TcpSocket socket, Role own_role, const std::string& expression, std::size_t most_bytes);

  int descriptor() const { return socket_.descriptor(); }
  bool has_to_write() const { return !outgoing_.empty() || !outbox_.empty(); }
  /// Whether the other side has spoken: until then it is not known to be a peer.
  bool is_greeted() const { return reader_.is_greeted(); }

  /// Reads what there is. @param on_message  for each message. @throws std::runtime_error when the
  /// connection ended, std::invalid_argument where the other side speaks something else.
  void read(const std::function<void(const Frame&)>& on_message);
  /// Writes what can be written. @throws std::runtime_error as read.
  void write();

  /// Sends a message if the other side asked for its channel.
  /// @returns whether it did, and counts in `lost`, by channel, what was dropped for it
  bool send(const std::string& channel,
            std::span<const uint8_t> data,
            std::map<std::string, int64_t>& lost);
  /// What waits, by channel; it is dropped.
  std::map<std::string, int64_t> drop_waiting() { return outbox_.clear(); }

 private:
  void subscribe(const std::string& expression);
  bool is_wanted(const std::string& channel) const;

  TcpSocket socket_;
  Role own_role_;
  FrameReader reader_;
  Outbox outbox_;
  std::string outgoing_;                          // bytes that are being written
  std::size_t sent_ = 0;                          // of these
  std::map<std::string, ChannelPattern> wanted_;  // by their text; a client sends everything
};

}  // namespace marco::relay
