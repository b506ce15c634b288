#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// Foxglove's WebSocket protocol, `foxglove.websocket.v1` and `foxglove.sdk.v1`, from a client's
/// side: messages from and to a robot's foxglove_bridge. Pure.
namespace marco::foxglove {

/// Both are offered, since each server knows but one of them.
inline constexpr const char* kSubprotocols = "foxglove.sdk.v1, foxglove.websocket.v1";

struct ServerInfo {
  std::string name, session_id;
  std::set<std::string> capabilities;
  std::set<std::string> encodings;  ///< that a client may publish in
};
struct ServerChannel {
  uint32_t id = 0;
  std::string topic, encoding, schema_name, schema, schema_encoding;
};
struct Advertised {
  std::vector<ServerChannel> channels;
};
struct Unadvertised {
  std::vector<uint32_t> channels;  ///< ids
};
struct ServerStatus {
  int level = 0;  ///< 0 info, 1 warning, 2 error
  std::string message;
};
/// Nothing: an operation that is not used here.
using ServerText = std::variant<std::monostate, ServerInfo, Advertised, Unadvertised, ServerStatus>;

/// @throws std::invalid_argument for what is no JSON object with an `op`, or lacks its fields.
/// Channels that lack theirs are left out.
ServerText parse_text(std::string_view json);

struct ServerData {
  uint32_t subscription = 0;
  int64_t received_ns = 0;           ///< by the server
  std::span<const uint8_t> payload;  ///< within the message
};
/// Nothing: another operation, or a message that is cut off.
std::optional<ServerData> parse_binary(std::span<const uint8_t> message);

/// @param subscriptions  pairs of our id and the server's channel
std::string subscribe_text(const std::vector<std::pair<uint32_t, uint32_t>>& subscriptions);

struct ClientChannel {
  uint32_t id = 0;
  std::string topic, encoding, schema_name;
};
std::string advertise_text(const std::vector<ClientChannel>& channels);
/// A message on one of our channels.
std::vector<uint8_t> data_message(uint32_t channel, std::span<const uint8_t> payload);

}  // namespace marco::foxglove
