#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// LCM's udpm wire format: headers, sequence numbers, fragments. liblcm parses these too, but hides
/// who sent a message and which numbers are missing. Pure.
namespace marco::diagnosis {

/// A sender's socket, host byte order.
struct Address {
  uint32_t ip = 0;
  uint16_t port = 0;
  auto operator<=>(const Address&) const = default;
};
std::string to_string(const Address& address);  ///< "10.0.0.7:41712"

/// A datagram's header. Short: magic "LC02", sequence number, channel NUL, data. Fragment: magic
/// "LC03", sequence number, message size, offset, fragment number, fragments; the first one carries
/// channel NUL before its data, and offsets do not count those. Big endian.
struct Datagram {
  uint32_t sequence = 0;
  std::string_view channel;          ///< empty in fragments after the first
  std::span<const uint8_t> payload;  ///< the data in this datagram
  bool fragmented = false;
  uint32_t message_bytes = 0;  ///< of a fragment: the whole message's
  uint32_t offset = 0;
  uint16_t fragment = 0;
  uint16_t fragments = 1;
};

/// @returns nothing for bytes that are not an LCM datagram: wrong magic, channel longer than 63
/// characters, a fragment outside its message, a message above 256 MB.
std::optional<Datagram> parse_datagram(std::span<const uint8_t> bytes);

/// Counts a sender's missing sequence numbers. Late and duplicate datagrams within the last 1024
/// numbers are recognised. A jump backwards beyond them, or forwards beyond 2^24, is a restart of
/// the sender.
class SequenceTracker {
 public:
  /// @returns false for a number seen before.
  bool add(uint32_t sequence);
  /// For fragments, several of which share a number: a known number is not a duplicate.
  bool add_fragment(uint32_t sequence);
  /// Resets the counts, not the sequence numbers.
  void forget_losses();

  int64_t lost() const { return lost_; }
  int64_t duplicates() const { return duplicates_; }
  int64_t restarts() const { return restarts_; }

 private:
  static constexpr uint32_t kWindow = 1024;
  bool& seen(uint32_t sequence) { return seen_[sequence % kWindow]; }

  bool started_ = false;
  uint32_t next_ = 0;
  int64_t lost_ = 0;
  int64_t duplicates_ = 0;
  int64_t restarts_ = 0;
  std::array<bool, kWindow> seen_ = {};  ///< of the numbers next_ - kWindow .. next_ - 1
};

/// Reassembles one sender's fragments, in any order. Keeps at most 4 unfinished messages and 256
/// MB; evicted messages are reported as incomplete.
class Reassembler {
 public:
  struct Message {
    std::string channel;  ///< empty when the first fragment never came
    std::shared_ptr<uint8_t[]> data;
    std::size_t size = 0;
    std::span<const uint8_t> bytes() const { return {data.get(), size}; }
  };
  /// @returns the message that `datagram` (a fragment) completes. Channels of evicted messages are
  /// appended to `incomplete` (an empty name: unknown).
  std::optional<Message> add(const Datagram& datagram,
                             int64_t time_us,
                             std::vector<std::string>& incomplete);
  /// Evicts messages whose last fragment came before `before_us`.
  void give_up(int64_t before_us, std::vector<std::string>& incomplete);
  bool holds(uint32_t sequence) const;
  bool empty() const { return partials_.empty(); }

 private:
  struct Partial {
    int64_t time_us = 0;
    uint32_t sequence = 0;
    std::string channel;
    // Pages are touched only as fragments arrive: a forged length costs nothing.
    std::shared_ptr<uint8_t[]> data;
    std::size_t size = 0;
    std::vector<bool> have;
    std::size_t missing = 0;
  };
  Partial& partial_of(const Datagram& datagram, std::vector<std::string>& incomplete);

  std::deque<Partial> partials_;
};

}  // namespace marco::diagnosis
