#include "tools/bridge/foxglove_protocol.hpp"

#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace marco::bridge {
namespace {

using Json = nlohmann::json;

constexpr uint8_t kData = 1;  // both ways

std::string text_of(const Json& object, const char* key) {
  const auto field = object.find(key);
  return field != object.end() && field->is_string() ? field->get<std::string>() : std::string();
}

const Json& list_of(const Json& object, const char* key) {
  static const Json kNone = Json::array();
  const auto field = object.find(key);
  return field != object.end() && field->is_array() ? *field : kNone;
}

std::optional<uint32_t> id_of(const Json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto id = value.get<uint64_t>();
  if (id > std::numeric_limits<uint32_t>::max()) return std::nullopt;
  return static_cast<uint32_t>(id);
}

std::set<std::string> texts_of(const Json& list) {
  std::set<std::string> texts;
  for (const Json& item : list) {
    if (item.is_string()) texts.insert(item.get<std::string>());
  }
  return texts;
}

ServerInfo info_of(const Json& object) {
  return {text_of(object, "name"), text_of(object, "sessionId"),
          texts_of(list_of(object, "capabilities")),
          texts_of(list_of(object, "supportedEncodings"))};
}

Advertised advertised_of(const Json& object) {
  Advertised advertised;
  for (const Json& item : list_of(object, "channels")) {
    if (!item.is_object() || !item.contains("id")) continue;
    const auto id = id_of(item.at("id"));
    ServerChannel channel{0,
                          text_of(item, "topic"),
                          text_of(item, "encoding"),
                          text_of(item, "schemaName"),
                          text_of(item, "schema"),
                          text_of(item, "schemaEncoding")};
    if (!id || channel.topic.empty()) continue;
    channel.id = *id;
    advertised.channels.push_back(std::move(channel));
  }
  return advertised;
}

Unadvertised unadvertised_of(const Json& object) {
  Unadvertised gone;
  for (const Json& item : list_of(object, "channelIds")) {
    if (const auto id = id_of(item)) gone.channels.push_back(*id);
  }
  return gone;
}

template <class Number>
Number number_at(std::span<const uint8_t> bytes, std::size_t at) {
  Number value = 0;
  for (std::size_t i = sizeof value; i-- > 0;) value = (value << 8U) | bytes[at + i];
  return value;
}

}  // namespace

ServerText parse_text(std::string_view json) {
  const Json object = Json::parse(json, nullptr, false);
  if (!object.is_object()) throw std::invalid_argument("a text that is no JSON object");
  const std::string op = text_of(object, "op");
  if (op.empty()) throw std::invalid_argument("a text without an op");
  if (op == "serverInfo") return info_of(object);
  if (op == "advertise") return advertised_of(object);
  if (op == "unadvertise") return unadvertised_of(object);
  if (op == "status") {
    const auto level = object.find("level");
    const bool is_number = level != object.end() && level->is_number_unsigned();
    const auto number = is_number ? level->get<uint64_t>() : 0;
    return ServerStatus{static_cast<int>(std::min<uint64_t>(number, 2)),
                        text_of(object, "message")};
  }
  return {};
}

std::optional<ServerData> parse_binary(std::span<const uint8_t> message) {
  constexpr std::size_t kHead = 13;
  if (message.size() < kHead || message[0] != kData) return std::nullopt;
  return ServerData{number_at<uint32_t>(message, 1),
                    static_cast<int64_t>(number_at<uint64_t>(message, 5)), message.subspan(kHead)};
}

std::string subscribe_text(const std::vector<std::pair<uint32_t, uint32_t>>& subscriptions) {
  Json list = Json::array();
  for (const auto& [id, channel] : subscriptions) {
    list.push_back({{"id", id}, {"channelId", channel}});
  }
  return Json{{"op", "subscribe"}, {"subscriptions", list}}.dump();
}

std::string advertise_text(const std::vector<ClientChannel>& channels) {
  Json list = Json::array();
  for (const ClientChannel& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", channel.encoding},
                    {"schemaName", channel.schema_name}});
  }
  return Json{{"op", "advertise"}, {"channels", list}}.dump();
}

std::vector<uint8_t> data_message(uint32_t channel, std::span<const uint8_t> payload) {
  std::vector<uint8_t> message{kData};
  for (unsigned shift = 0; shift < 32; shift += 8) {
    message.push_back(static_cast<uint8_t>(channel >> shift));
  }
  message.insert(message.end(), payload.begin(), payload.end());
  return message;
}

}  // namespace marco::bridge
