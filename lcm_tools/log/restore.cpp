#include "lcm_tools/log/restore.hpp"

#include <algorithm>

#include "lcm_tools/schema/wire.hpp"

namespace marco::logs {
namespace {

using lcm_schema::load;

constexpr int64_t kEstablished = 5;
constexpr uint32_t kMaxChannelBytes = 63;

int differing_bytes(uint64_t a, uint64_t b) {
  int count = 0;
  for (uint64_t both = a ^ b; both != 0; both >>= 8U) count += (both & 0xFFU) != 0 ? 1 : 0;
  return count;
}

bool differ_in_one(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  int count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i] ? 1 : 0;
  return count == 1;
}

}  // namespace

void KnownChannels::add(std::string_view channel, uint64_t fingerprint, int64_t data_bytes) {
  constexpr std::size_t kLargest = 10000;
  auto entry = channels_.find(channel);
  if (entry == channels_.end()) {
    if (channels_.size() >= kLargest) return;
    entry = channels_.try_emplace(std::string(channel)).first;
  }
  Types& types = entry->second;
  ++types.events;
  if (types.majority_votes == 0) types.majority_bytes = data_bytes;
  types.majority_votes += types.majority_bytes == data_bytes ? 1 : -1;
  constexpr std::size_t kTypesKept = 1000;
  auto& counts = types.counts;
  if (counts.size() < kTypesKept || counts.contains(fingerprint)) ++counts[fingerprint];
}

int64_t KnownChannels::events(std::string_view channel) const {
  const auto entry = channels_.find(channel);
  return entry == channels_.end() ? 0 : entry->second.events;
}

std::optional<int64_t> KnownChannels::usual_data_bytes(std::string_view channel) const {
  const auto entry = channels_.find(channel);
  if (entry == channels_.end() || entry->second.events < kEstablished) return std::nullopt;
  // A vote left for half the events: at most a quarter were against.
  const Types& types = entry->second;
  if (2 * types.majority_votes < types.events) return std::nullopt;
  return types.majority_bytes;
}

std::optional<std::string> KnownChannels::nearest(std::string_view damaged,
                                                  uint64_t fingerprint) const {
  std::optional<std::string> found;
  for (const auto& [name, types] : channels_) {
    if (types.events < kEstablished || !types.counts.contains(fingerprint)) continue;
    if (!differ_in_one(name, damaged)) continue;
    if (found) return std::nullopt;
    found = name;
  }
  return found;
}

std::optional<uint64_t> KnownChannels::mend_fingerprint(std::string_view channel,
                                                        uint64_t damaged) const {
  const auto entry = channels_.find(channel);
  if (entry == channels_.end()) return std::nullopt;
  const auto& counts = entry->second.counts;
  const auto own = counts.find(damaged);
  const auto usual = std::max_element(counts.begin(), counts.end(),
                                      [](auto& a, auto& b) { return a.second < b.second; });
  const bool rare = own == counts.end() || own->second == 1;
  if (!rare || usual->second < kEstablished || differing_bytes(usual->first, damaged) != 1) {
    return std::nullopt;
  }
  return usual->first;
}

HeaderBytes::HeaderBytes(const uint8_t* bytes)
    : number(load<int64_t>(bytes + 4)),
      event_time(Utime::from_us(load<int64_t>(bytes + 12))),
      channel_bytes(load<uint32_t>(bytes + 20)),
      data_bytes(load<uint32_t>(bytes + 24)) {
  sync_like = differing_bytes(load<uint32_t>(bytes), 0xEDA1DA01) <= 1;
}

std::optional<Layout> lay_out(const HeaderBytes& header,
                              std::string_view following,
                              int64_t body_bytes,
                              const KnownChannels& known) {
  const auto layout = [&](int64_t channel_bytes, const char* mended) -> std::optional<Layout> {
    if (channel_bytes < 1 || channel_bytes > kMaxChannelBytes || channel_bytes > body_bytes ||
        static_cast<std::size_t>(channel_bytes) > following.size()) {
      return std::nullopt;
    }
    const auto size = static_cast<std::size_t>(channel_bytes);
    Layout result{static_cast<uint32_t>(size), static_cast<uint32_t>(body_bytes - channel_bytes),
                  std::string(following.substr(0, size)), mended};
    if (known.events(result.channel) > 0) return result;
    const auto name = known.nearest(result.channel, read_fingerprint(following.substr(size)));
    if (!name) return std::nullopt;
    result.channel = *name;
    result.mended = "channel";
    return result;
  };
  const int64_t announced = static_cast<int64_t>(header.channel_bytes) + header.data_bytes;
  if (announced == body_bytes) return layout(header.channel_bytes, "sync word");
  const auto by_channel = layout(header.channel_bytes, "data length");
  const auto by_data =
      layout(body_bytes - static_cast<int64_t>(header.data_bytes), "channel length");
  const auto weight = [&known](const std::optional<Layout>& one) {
    return one ? known.events(one->channel) : 0;
  };
  return weight(by_data) > weight(by_channel) ? by_data : by_channel;
}

uint64_t read_fingerprint(std::string_view data) {
  return data.size() < 8 ? 0 : load<uint64_t>(reinterpret_cast<const uint8_t*>(data.data()));
}

}  // namespace marco::logs
