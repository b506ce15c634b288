#include "web/process/raw_channels.hpp"

#include <functional>
#include <optional>

#include "lcm_tools/schema/built_in_sources.hpp"
#include "lcm_tools/schema/json.hpp"
#include "lcm_tools/schema/wire.hpp"
#include "marco/grid_map_t.hpp"
#include "marco/mesh_t.hpp"
#include "marco/process_status_t.hpp"
#include "marco/sensor_info_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::web {
namespace {

constexpr lcm_schema::JsonOptions kJson = {true};
constexpr std::size_t kLargestKept = std::size_t{4} << 20;

using lcm_schema::is_a;

uint64_t hash_of(std::span<const uint8_t> bytes) {
  return std::hash<std::string_view>{}({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

/// The bytes of a text after the fingerprint and a stamp; all that is left where it is cut off.
std::span<const uint8_t> text_after_stamp(std::span<const uint8_t> bytes) {
  constexpr std::size_t kAt = 16;
  if (bytes.size() < kAt + 4) return {};
  const auto rest = bytes.subspan(kAt + 4);
  const auto length = lcm_schema::load<int32_t>(bytes.data() + kAt);
  return rest.first(std::min<std::size_t>(rest.size(), static_cast<uint32_t>(length)));
}

bool is_tiled(uint64_t fingerprint) {
  return is_a<grid_map_t>(fingerprint) || is_a<mesh_t>(fingerprint);
}

}  // namespace

RawChannels::RawChannels(Hub& hub) : hub_(hub), schema_(built_in_sources()), decoder_(schema_) {}

RawChannels::Channel* RawChannels::channel_of(const process::RawMessage& message) {
  const auto fingerprint = lcm_schema::fingerprint_of(message.bytes);
  if (!fingerprint) return nullptr;
  auto at = channels_.find(message.channel);
  if (at != channels_.end() && at->second.fingerprint == *fingerprint) return &at->second;
  const auto types = schema_.with_fingerprint(*fingerprint);
  if (types.empty()) return nullptr;
  if (at == channels_.end()) {
    if (channels_.size() >= kMostChannels) return nullptr;
    at = channels_.emplace(std::string(message.channel), Channel{}).first;
  }
  Channel& channel = at->second;
  if (channel.id != 0) {  // it carries another type now
    by_id_.erase(channel.id);
    hub_.remove_channel(channel.id);
    forget(channel);
  }
  channel.fingerprint = *fingerprint;
  channel.structure = types[0];
  channel.id =
      hub_.add_channel(at->first, schema_.structures()[static_cast<std::size_t>(types[0])].name,
                       lcm_schema::json_schema(schema_, types[0], kJson));
  by_id_[channel.id] = &channel;
  return &channel;
}

void RawChannels::take(const process::RawMessage& message) {
  Channel* channel = channel_of(message);
  if (channel == nullptr) return;
  uint64_t slot = 0;
  const auto& bytes = message.bytes;
  if (is_a<grid_map_t>(channel->fingerprint) && bytes.size() >= 40) {
    slot = hash_of(bytes.subspan(24, 16));  // the tile's origin
  } else if (is_a<mesh_t>(channel->fingerprint) && bytes.size() >= 28) {
    slot = lcm_schema::load<uint32_t>(bytes.data() + 24);
  } else if (is_a<process_status_t>(channel->fingerprint) ||
             is_a<sensor_info_t>(channel->fingerprint)) {
    slot = hash_of(text_after_stamp(bytes));
  } else if (is_a<procman_lcm::output_t>(channel->fingerprint)) {
    slot = ++next_line_;  // each one counts
  }
  if (is_tiled(channel->fingerprint) && bytes.size() >= 24) {
    const auto revision = lcm_schema::load<int64_t>(bytes.data() + 16);
    if (revision != channel->revision) forget(*channel);
    channel->revision = revision;
  }
  if (!is_a<procman_lcm::output_t>(channel->fingerprint)) keep(*channel, message, slot);
  if (!hub_.wanted(channel->id)) return;
  std::string json = json_of(*channel, bytes);
  if (!json.empty()) {
    hub_.publish(channel->id, message.event_time.us * 1000, std::move(json), slot);
  }
}

void RawChannels::keep(Channel& channel, const process::RawMessage& message, uint64_t slot) {
  constexpr std::size_t kMostSlots = 4096;
  if (message.bytes.size() > kLargestKept) return;
  if (channel.kept.size() >= kMostSlots && !channel.kept.contains(slot)) return;
  Kept& kept = channel.kept[slot];
  if (kept_bytes_ - kept.bytes.size() + message.bytes.size() > kMostKeptBytes) return;
  kept_bytes_ += message.bytes.size() - kept.bytes.size();
  kept.bytes.assign(message.bytes.begin(), message.bytes.end());
  kept.time_ns = message.event_time.us * 1000;
}

void RawChannels::forget(Channel& channel) {
  for (const auto& [slot, kept] : channel.kept) kept_bytes_ -= kept.bytes.size();
  channel.kept.clear();
}

std::string RawChannels::json_of(const Channel& channel, std::span<const uint8_t> bytes) {
  if (decoder_.decode(channel.structure, bytes, tree_) != lcm_schema::DecodeStatus::ok) return "";
  std::string json;
  lcm_schema::append_json(tree_, json, kJson);
  return json;
}

uint64_t RawChannels::send_part(Hub::ClientId client, uint32_t id, uint64_t from) {
  const auto at = by_id_.find(id);
  if (at == by_id_.end()) return 0;
  auto next = at->second->kept.lower_bound(from);
  if (next == at->second->kept.end()) return 0;
  const auto& [slot, kept] = *next;
  std::string json = json_of(*at->second, kept.bytes);
  if (!json.empty()) hub_.publish_to(client, id, kept.time_ns, std::move(json), slot);
  return ++next == at->second->kept.end() ? 0 : next->first;
}

}  // namespace marco::web
