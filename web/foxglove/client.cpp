#include "web/foxglove/client.hpp"

#include <stdexcept>

#include "web/foxglove/fields.hpp"

namespace marco::foxglove {
namespace {

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

}  // namespace

ServerText parse_text(std::string_view json) {
  const auto [op, object] = operation_of(json);
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
  append_number(message, channel);
  message.insert(message.end(), payload.begin(), payload.end());
  return message;
}

}  // namespace marco::foxglove
