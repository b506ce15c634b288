#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// LCM over TCP, the wire of liblcm's `tcpq://HOST:PORT` (1.3.1). Each side begins with a magic and
/// the version 0x0100. A client then sends subscriptions (regular expressions) and messages, the
/// server messages. All numbers are of 32 bits, big endian:
///
///     publish      1, bytes of the channel, channel, bytes of the data, data
///     subscribe    2, bytes of the expression, expression
///     unsubscribe  3, likewise
namespace marco::relay {

enum class Role { server, client };

struct Frame {
  enum class Kind : uint8_t { publish = 1, subscribe = 2, unsubscribe = 3 };
  Kind kind = Kind::publish;
  std::string channel;  ///< or the expression
  std::vector<uint8_t> data;
};

/// What a side sends first.
std::string greeting_of(Role role);
void append_publish(std::string& to, std::string_view channel, std::span<const uint8_t> data);
void append_subscribe(std::string& to, std::string_view expression);

/// Takes a stream of bytes apart, however it is cut.
class FrameReader {
 public:
  /// No message is larger, nor an expression longer.
  static constexpr uint32_t kMostData = 64U << 20U;
  static constexpr uint32_t kMostName = 1024;

  /// @param sender  whose bytes they are
  explicit FrameReader(Role sender) : sender_(sender) {}

  void add(std::span<const uint8_t> bytes);
  /// The next whole frame. @throws std::invalid_argument where the bytes are not this protocol, or
  /// a length is beyond the limits: the connection is of no use any more.
  std::optional<Frame> next();
  bool is_greeted() const { return is_greeted_; }

 private:
  bool read_greeting();
  std::optional<uint32_t> number_at(std::size_t at) const;

  Role sender_;
  bool is_greeted_ = false;
  std::vector<uint8_t> bytes_;
  std::size_t used_ = 0;  // of bytes_
};

}  // namespace marco::relay
