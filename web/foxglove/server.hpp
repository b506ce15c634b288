#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// Foxglove's WebSocket protocol, `foxglove.sdk.v1` and `foxglove.websocket.v1`, from a server's
/// side: what it says, and what clients ask. Both differ in fields that the other one's clients
/// pass over, so that one text serves both. Pure.
namespace marco::foxglove {

struct Identity {
  std::string name, session_id;
  std::vector<std::string> capabilities;
  std::map<std::string, std::string> metadata;
  /// Of a recording: its first and last moment.
  std::optional<std::pair<int64_t, int64_t>> span_ns = {};
};
/// A channel of JSON messages. `schema` is a JSON schema.
struct OfferedChannel {
  uint32_t id = 0;
  std::string topic, schema_name, schema;
};
/// A service of JSON requests and answers.
struct OfferedService {
  uint32_t id = 0;
  std::string name;
  std::string request_schema, response_schema;
};
/// A read-only parameter, as JSON.
struct Parameter {
  std::string name, value_json;
};
enum class Level { info, warning, error };

std::string server_info_text(const Identity& server);
std::string offer_text(std::span<const OfferedChannel> channels);
std::string withdraw_text(const std::vector<uint32_t>& channels);
std::string services_text(std::span<const OfferedService> services);
std::string status_text(Level level, const std::string& message);
/// @param request  the client's id of its question; "" = nobody asked
std::string parameters_text(const std::vector<Parameter>& parameters, const std::string& request);
std::string service_failure_text(uint32_t service, uint32_t call, const std::string& message);

/// The bytes before the payload of a message on a channel.
std::string data_head(uint32_t subscription, int64_t time_ns);
/// A service's answer.
std::string service_message(uint32_t service, uint32_t call, std::string_view json);
std::string asset_failure(uint32_t request, std::string_view why);

/// What a client asks for.
struct Subscribe {
  std::vector<std::pair<uint32_t, uint32_t>> subscriptions;  ///< the client's id, our channel
};
struct Unsubscribe {
  std::vector<uint32_t> subscriptions;
};
struct PublishedChannel {
  uint32_t id = 0;  ///< the client's
  std::string topic, encoding, schema_name;
};
struct Publish {
  std::vector<PublishedChannel> channels;
};
struct Unpublish {
  std::vector<uint32_t> channels;
};
struct GetParameters {
  std::set<std::string> names;  ///< empty: all
  std::string id;
};
struct FetchAsset {
  uint32_t request = 0;
};
/// Of our page, not of the protocol: it is still there.
struct Alive {};
/// Nothing: an operation that is not served here, setParameters among them.
using ClientText = std::variant<std::monostate,
                                Subscribe,
                                Unsubscribe,
                                Publish,
                                Unpublish,
                                GetParameters,
                                FetchAsset,
                                Alive>;

/// @throws std::invalid_argument for what is no JSON object with an `op`. List entries that lack
/// their fields are left out.
ClientText parse_client_text(std::string_view json);

struct PublishedData {
  uint32_t channel = 0;              ///< the client's id
  std::span<const uint8_t> payload;  ///< within the message
};
struct ServiceCall {
  uint32_t service = 0, call = 0;
  std::string_view encoding;
  std::span<const uint8_t> payload;
};
/// Of a client that looks at a recording.
struct PlaybackControl {
  bool play = true;
  double speed = 1.0;
  std::optional<int64_t> seek_ns;
  std::string_view request;
};
using ClientBinary = std::variant<std::monostate, PublishedData, ServiceCall, PlaybackControl>;

/// Nothing: another operation. @throws std::invalid_argument for one that is cut off.
ClientBinary parse_client_binary(std::span<const uint8_t> message);

/// What a player is doing, in answer to PlaybackControl or by itself.
struct PlaybackState {
  bool is_playing = true, has_ended = false, did_seek = false;
  int64_t time_ns = 0;
  double speed = 1.0;
  std::string request;  ///< "" = nobody asked
};
std::string playback_state(const PlaybackState& state);

/// Of those that a client offers, in its header's form, the first one that we speak.
std::optional<std::string> choose_subprotocol(std::string_view offered);

}  // namespace marco::foxglove
