#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "lcm_tools/diagnosis/datagram.hpp"
#include "lcm_tools/schema/decoder.hpp"
#include "lcm_tools/spy/statistics.hpp"

namespace marco::spy {

using diagnosis::Address;

/// A message kept for sparklines and plots.
struct Sample {
  int64_t time_us = 0;
  std::vector<uint8_t> bytes;
};

struct Channel {
  std::string name;
  RateMeter rate;
  uint64_t fingerprint = 0;         ///< of the last message long enough to have one
  std::span<const int> candidates;  ///< types with it (indices into the schema)
  std::size_t choice = 0;           ///< which of them is shown
  int64_t untyped = 0;              ///< shorter than a fingerprint
  int64_t unknown = 0;              ///< no type with this fingerprint
  int64_t damaged = 0;              ///< the type is known, the bytes do not fit it
  int64_t type_changes = 0;         ///< fingerprint other than the message's before
  Sample last;
  bool tiled = false;  ///< its type has a field `revision`: a map comes in several messages
  /// At least 25 ms apart, at most 1200 and 2 MB; when tiled, all of the last 24 MB. Empty when
  /// only the newest message is kept.
  std::deque<Sample> history;
  std::size_t history_bytes = 0;

  int64_t undecodable() const { return untyped + unknown + damaged; }
  /// The type it is shown as; -1 when there is none.
  int type() const { return candidates.empty() ? -1 : candidates[choice % candidates.size()]; }
};

/// A socket that publishes.
struct Sender {
  struct Use {
    int channel = 0;
    int64_t count = 0;
    int64_t incomplete = 0;  ///< fragments were lost
  };
  Address address;
  diagnosis::SequenceTracker sequence;
  diagnosis::Reassembler fragments;
  std::vector<Use> uses;
  int64_t messages = 0;
  int64_t bytes = 0;
  int64_t incomplete = 0;          ///< messages of which fragments were lost, of any channel
  int64_t incomplete_unknown = 0;  ///< of those, of a channel not known
  int64_t last_us = 0;

  int64_t lost() const { return sequence.lost() + incomplete; }
};

/// Losses of one sender's channel. A number that never came names no channel: a sender of one
/// channel lost that one's; of several, each is given its share by messages received.
struct Loss {
  int64_t count = 0;
  bool estimated = false;
};

/// What a model keeps of a channel's messages.
enum class Keep { history, newest };

/// All a spy knows. Fed with datagrams (live) or messages (a log). Not thread-safe; a copy is a
/// frozen picture of the moment. Cost per small message below a microsecond.
class Model {
 public:
  /// @param decoder must outlive the model and its copies.
  explicit Model(const lcm_schema::Decoder& decoder, Keep keep = Keep::history)
      : decoder_(&decoder), keep_(keep) {}

  void add_datagram(int64_t time_us, const Address& sender, std::span<const uint8_t> bytes);
  void add_message(int64_t time_us, std::string_view channel, std::span<const uint8_t> bytes);

  /// Counts messages as incomplete whose fragments stopped coming half a second before `now_us`.
  void settle(int64_t now_us);

  const lcm_schema::Decoder& decoder() const { return *decoder_; }
  const std::vector<Channel>& channels() const { return channels_; }
  const std::vector<Sender>& senders() const { return senders_; }
  int find(std::string_view channel) const;  ///< -1: not heard

  /// Of `use` of `sender`, and of a channel over all senders.
  Loss loss(const Sender& sender, const Sender::Use& use) const;
  Loss loss(int channel) const;
  int64_t lost() const;  ///< messages, over all senders
  int64_t messages() const { return messages_; }
  int64_t foreign() const { return foreign_; }  ///< datagrams that are not LCM's
  int64_t ignored() const { return ignored_; }  ///< beyond 4000 channels or senders
  int64_t first_us() const { return first_us_; }
  int64_t last_us() const { return last_us_; }

  /// Shows `channel` as the next of its candidate types.
  void choose_next_type(int channel);
  /// Forgets all messages. Sequence numbers of the senders are kept.
  void clear();
  /// Decodes the last message of a channel. @returns false when it cannot be.
  bool decode_last(int channel, lcm_schema::Tree& tree) const;

 private:
  int channel_index(std::string_view name);
  int sender_index(const Address& address);
  void add_to_channel(int64_t time_us, int channel, std::span<const uint8_t> bytes);
  void count_kind(Channel& channel, std::span<const uint8_t> bytes);
  void remember(Channel& channel, int64_t time_us, std::span<const uint8_t> bytes);
  void count_incomplete(Sender& sender, const std::vector<std::string>& channels);
  static Sender::Use& use_of(Sender& sender, int channel);

  struct NameHash {
    using is_transparent = void;  // NOLINT(readability-identifier-naming): the standard's name
    std::size_t operator()(std::string_view name) const {
      return std::hash<std::string_view>{}(name);
    }
  };

  const lcm_schema::Decoder* decoder_;
  Keep keep_;
  std::vector<Channel> channels_;
  std::unordered_map<std::string, int, NameHash, std::equal_to<>> channel_of_name_;
  std::vector<Sender> senders_;
  std::map<Address, int> sender_of_address_;
  int64_t messages_ = 0;
  int64_t foreign_ = 0;
  int64_t ignored_ = 0;
  int64_t first_us_ = 0;
  int64_t last_us_ = 0;
};

}  // namespace marco::spy
