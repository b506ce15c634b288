#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/schema/decoder.hpp"
#include "lcm_tools/schema/schema.hpp"
#include "web/hub.hpp"

namespace marco::web {

/// Every active LCM channel as a channel of the hub: its name, a schema made from its type, and
/// messages as JSON, which are made only when somebody listens. Who subscribes gets the last
/// message; of maps and models, each tile; of what several programs say on one channel, each one's.
class RawChannels {
 public:
  static constexpr std::size_t kMostChannels = 1000;  ///< anybody may make some up
  static constexpr std::size_t kMostKeptBytes = std::size_t{64} << 20;

  /// @param hub  outlives it
  explicit RawChannels(Hub& hub);

  void take(const process::RawMessage& message);
  /// One message of what is known of a channel, to a new subscriber, as Hub::on_part. Nothing for
  /// channels that are not these.
  uint64_t send_part(Hub::ClientId client, uint32_t channel, uint64_t from);

  /// Of all types that are known.
  const lcm_schema::Decoder& decoder() const { return decoder_; }

 private:
  struct Kept {
    std::vector<uint8_t> bytes;
    int64_t time_ns = 0;
  };
  struct Channel {
    uint32_t id = 0;
    uint64_t fingerprint = 0;
    int structure = -1;
    int64_t revision = 0;
    std::map<uint64_t, Kept> kept;  // by slot
  };
  Channel* channel_of(const process::RawMessage& message);
  void keep(Channel& channel, const process::RawMessage& message, uint64_t slot);
  void forget(Channel& channel);
  std::string json_of(const Channel& channel, std::span<const uint8_t> bytes);

  Hub& hub_;
  lcm_schema::Schema schema_;
  lcm_schema::Decoder decoder_;
  lcm_schema::Tree tree_;
  std::map<std::string, Channel, std::less<>> channels_;
  std::map<uint32_t, Channel*> by_id_;
  std::size_t kept_bytes_ = 0;
  uint64_t next_line_ = 0;
};

}  // namespace marco::web
