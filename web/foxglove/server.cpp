#include "web/foxglove/server.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "web/foxglove/fields.hpp"

namespace marco::foxglove {
namespace {

constexpr uint8_t kServiceAnswer = 3, kAsset = 4, kPlayback = 5;  // the server's opcodes
constexpr uint8_t kServiceCall = 2, kPlaybackControl = 3;         // the client's

// Texts may hold anybody's bytes: what is no UTF-8 is replaced.
std::string text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json schema_json(const std::string& name, const std::string& schema) {
  return {{"encoding", "json"},
          {"schemaName", name},
          {"schemaEncoding", "jsonschema"},
          {"schema", schema}};
}

Json time_json(int64_t ns) {
  constexpr int64_t kSecond = 1'000'000'000;
  return {{"sec", ns / kSecond}, {"nsec", ns % kSecond}};
}

std::vector<uint32_t> ids_of(const Json& list) {
  std::vector<uint32_t> ids;
  for (const Json& item : list) {
    if (const auto id = id_of(item)) ids.push_back(*id);
  }
  return ids;
}

Subscribe subscribe_of(const Json& object) {
  Subscribe wanted;
  for (const Json& item : list_of(object, "subscriptions")) {
    const auto id = id_at(item, "id"), channel = id_at(item, "channelId");
    if (id && channel) wanted.subscriptions.emplace_back(*id, *channel);
  }
  return wanted;
}

Publish publish_of(const Json& object) {
  Publish offered;
  for (const Json& item : list_of(object, "channels")) {
    const auto id = id_at(item, "id");
    if (!id) continue;
    offered.channels.push_back(
        {*id, text_of(item, "topic"), text_of(item, "encoding"), text_of(item, "schemaName")});
  }
  return offered;
}

void require_bytes(std::span<const uint8_t> message, std::size_t bytes) {
  if (message.size() < bytes) throw std::invalid_argument("a message that is cut off");
}

std::string_view text_at(std::span<const uint8_t> message, std::size_t at) {
  require_bytes(message, at + 4);
  const std::size_t length = number_at<uint32_t>(message, at);
  require_bytes(message.subspan(at + 4), length);
  return {reinterpret_cast<const char*>(message.data()) + at + 4, length};
}

ServiceCall service_call_of(std::span<const uint8_t> message) {
  constexpr std::size_t kHead = 9;
  const std::string_view encoding = text_at(message, kHead);
  return {number_at<uint32_t>(message, 1), number_at<uint32_t>(message, 5), encoding,
          message.subspan(kHead + 4 + encoding.size())};
}

PlaybackControl playback_control_of(std::span<const uint8_t> message) {
  constexpr std::size_t kHead = 15;
  PlaybackControl control;
  control.request = text_at(message, kHead);
  control.play = message[1] == 0;
  control.speed = static_cast<double>(std::bit_cast<float>(number_at<uint32_t>(message, 2)));
  if (!std::isfinite(control.speed) || control.speed <= 0.0) {
    throw std::invalid_argument("a speed that is not above 0");
  }
  if (message[6] != 0) {
    const auto seek_ns = number_at<uint64_t>(message, 7);
    control.seek_ns = static_cast<int64_t>(std::min<uint64_t>(seek_ns, INT64_MAX));
  }
  return control;
}

}  // namespace

std::string server_info_text(const Identity& server) {
  Json json = {{"op", "serverInfo"},
               {"name", server.name},
               {"capabilities", server.capabilities},
               {"supportedEncodings", {"json"}},
               {"metadata", server.metadata},
               {"sessionId", server.session_id}};
  if (server.span_ns) {
    json["dataStartTime"] = time_json(server.span_ns->first);
    json["dataEndTime"] = time_json(server.span_ns->second);
  }
  return text(json);
}

std::string offer_text(std::span<const OfferedChannel> channels) {
  Json list = Json::array();
  for (const OfferedChannel& channel : channels) {
    Json json = schema_json(channel.schema_name, channel.schema);
    json["id"] = channel.id;
    json["topic"] = channel.topic;
    list.push_back(std::move(json));
  }
  return text({{"op", "advertise"}, {"channels", list}});
}

std::string withdraw_text(const std::vector<uint32_t>& channels) {
  return text({{"op", "unadvertise"}, {"channelIds", channels}});
}

std::string services_text(std::span<const OfferedService> services) {
  Json list = Json::array();
  for (const OfferedService& service : services) {
    // The last two are what clients from before request and response look for.
    list.push_back({{"id", service.id},
                    {"name", service.name},
                    {"type", service.name},
                    {"request", schema_json(service.name + "_request", service.request_schema)},
                    {"response", schema_json(service.name + "_response", service.response_schema)},
                    {"requestSchema", service.request_schema},
                    {"responseSchema", service.response_schema}});
  }
  return text({{"op", "advertiseServices"}, {"services", list}});
}

std::string status_text(Level level, const std::string& message) {
  return text({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

std::string parameters_text(const std::vector<Parameter>& parameters, const std::string& request) {
  Json list = Json::array();
  for (const Parameter& parameter : parameters) {
    list.push_back(
        {{"name", parameter.name}, {"value", Json::parse(parameter.value_json, nullptr, false)}});
  }
  Json json = {{"op", "parameterValues"}, {"parameters", list}};
  if (!request.empty()) json["id"] = request;
  return text(json);
}

std::string service_failure_text(uint32_t service, uint32_t call, const std::string& message) {
  return text({{"op", "serviceCallFailure"},
               {"serviceId", service},
               {"callId", call},
               {"message", message}});
}

std::string data_head(uint32_t subscription, int64_t time_ns) {
  std::string head(1, static_cast<char>(kData));
  append_number(head, subscription);
  append_number(head, static_cast<uint64_t>(time_ns));
  return head;
}

std::string service_message(uint32_t service, uint32_t call, std::string_view json) {
  constexpr std::string_view kEncoding = "json";
  std::string message(1, static_cast<char>(kServiceAnswer));
  append_number(message, service);
  append_number(message, call);
  append_number(message, static_cast<uint32_t>(kEncoding.size()));
  return message.append(kEncoding).append(json);
}

std::string asset_failure(uint32_t request, std::string_view why) {
  std::string message(1, static_cast<char>(kAsset));
  append_number(message, request);
  message.push_back(1);
  append_number(message, static_cast<uint32_t>(why.size()));
  return message.append(why);
}

ClientText parse_client_text(std::string_view json) {
  const auto [op, object] = operation_of(json);
  if (op == "subscribe") return subscribe_of(object);
  if (op == "unsubscribe") return Unsubscribe{ids_of(list_of(object, "subscriptionIds"))};
  if (op == "advertise") return publish_of(object);
  if (op == "unadvertise") return Unpublish{ids_of(list_of(object, "channelIds"))};
  if (op == "getParameters") {
    return GetParameters{texts_of(list_of(object, "parameterNames")), text_of(object, "id")};
  }
  if (op == "alive") return Alive{};
  if (op == "fetchAsset") return FetchAsset{id_at(object, "requestId").value_or(0)};
  return {};
}

ClientBinary parse_client_binary(std::span<const uint8_t> message) {
  require_bytes(message, 1);
  switch (message[0]) {
    case kData:
      require_bytes(message, 5);
      return PublishedData{number_at<uint32_t>(message, 1), message.subspan(5)};
    case kServiceCall:
      return service_call_of(message);
    case kPlaybackControl:
      return playback_control_of(message);
    default:
      return {};
  }
}

std::string playback_state(const PlaybackState& state) {
  std::string message(1, static_cast<char>(kPlayback));
  message.push_back(static_cast<char>(state.has_ended ? 3 : state.is_playing ? 0 : 1));
  append_number(message, static_cast<uint64_t>(state.time_ns));
  append_number(message, std::bit_cast<uint32_t>(static_cast<float>(state.speed)));
  message.push_back(state.did_seek ? 1 : 0);
  append_number(message, static_cast<uint32_t>(state.request.size()));
  return message.append(state.request);
}

std::optional<std::string> choose_subprotocol(std::string_view offered) {
  while (!offered.empty()) {
    const std::size_t comma = std::min(offered.find(','), offered.size());
    std::string_view word = offered.substr(0, comma);
    offered.remove_prefix(std::min(comma + 1, offered.size()));
    const std::size_t first = word.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    word = word.substr(first, word.find_last_not_of(" \t") - first + 1);
    if (word == "foxglove.sdk.v1" || word == "foxglove.websocket.v1") return std::string(word);
  }
  return std::nullopt;
}

}  // namespace marco::foxglove
