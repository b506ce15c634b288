#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>

#include "lcm_tools/process/bus.hpp"

namespace marco::procman {

/// Whether `bytes` (after the fingerprint) are exactly of this layout. lcm-gen's decoders believe
/// the lengths of strings and arrays: a hostile one throws, or asks for more memory than there is.
/// @param layout a letter a field: b byte or boolean, h int16, i int32, l int64, f float, s string;
///   H, I an int16 or int32 that counts the {...} groups after it, each repeated so often.
bool is_well_formed(std::span<const uint8_t> bytes, const char* layout);

namespace layouts {
inline constexpr const char* kInfo = "lsfllllI{sssbbfiiifll}";
inline constexpr const char* kOrders = "lssI{sssbbfib}";
inline constexpr const char* kOutput = "lsH{s}{s}";
inline constexpr const char* kOutputSpan = "lsH{s}{l}{l}{s}";
inline constexpr const char* kDiscover = "lsl";
}  // namespace layouts

/// Bus::subscribe for messages that anybody on the network may have made up.
template <class Message>
void subscribe_checked(process::Bus& bus,
                       const char* channel,
                       const char* layout,
                       process::DropCounter& drops,
                       std::function<void(const Message&)> handler) {
  bus.subscribe_raw(channel, [layout, &drops, handler = std::move(handler)](const auto& raw) {
    drops.count_received();
    Message message;
    const int size = static_cast<int>(raw.bytes.size());
    if (!is_well_formed(raw.bytes, layout) || message.decode(raw.bytes.data(), 0, size) != size) {
      drops.count("undecodable");
      return;
    }
    handler(message);
  });
}

}  // namespace marco::procman
