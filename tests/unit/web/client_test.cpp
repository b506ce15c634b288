// Foxglove's WebSocket protocol: texts, and bytes of another program of the protocol.
#include "web/foxglove/client.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace marco::foxglove {
namespace {

using ::testing::ElementsAre;
using Json = nlohmann::json;

std::vector<uint8_t> bytes_of(const std::string& hex) {
  std::vector<uint8_t> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

TEST(FoxgloveText, TellsWhatTheServerIs) {
  const auto info = std::get<ServerInfo>(parse_text(
      R"({"op":"serverInfo","name":"bridge","capabilities":["clientPublish",3],)"
      R"("supportedEncodings":["cdr"],"metadata":{},"sessionId":"7","dataStartTime":{}})"));
  EXPECT_EQ(info.name, "bridge");
  EXPECT_THAT(info.capabilities, ElementsAre("clientPublish"));
  EXPECT_THAT(info.encodings, ElementsAre("cdr"));
  EXPECT_EQ(info.session_id, "7");
}

TEST(FoxgloveText, AdvertisesChannelsThatAreWhole) {
  const auto advertised = std::get<Advertised>(
      parse_text(R"({"op":"advertise","channels":[{"id":3,"topic":"/scan","encoding":"cdr",)"
                 R"("schemaName":"sensor_msgs/msg/LaserScan","schema":"x"},{"id":-1,"topic":"/a"},)"
                 R"({"topic":"/b"},{"id":4294967296,"topic":"/c"},7]})"));
  ASSERT_EQ(advertised.channels.size(), 1U);
  EXPECT_EQ(advertised.channels[0].id, 3U);
  EXPECT_EQ(advertised.channels[0].schema_name, "sensor_msgs/msg/LaserScan");
  const auto gone =
      std::get<Unadvertised>(parse_text(R"({"op":"unadvertise","channelIds":[3,"4"]})"));
  EXPECT_THAT(gone.channels, ElementsAre(3U));
}

TEST(FoxgloveText, OfUnknownKindIsPassedOverAndWhatIsNoneIsRefused) {
  EXPECT_TRUE(std::holds_alternative<std::monostate>(parse_text(R"({"op":"parameterValues"})")));
  EXPECT_EQ(std::get<ServerStatus>(parse_text(R"({"op":"status","level":9,"message":"m"})")).level,
            2);
  for (const char* text : {"", "[]", "{", "{}", R"({"op":1})", "\xff"}) {
    EXPECT_THROW(parse_text(text), std::invalid_argument) << text;
  }
}

TEST(FoxgloveBytes, AreThoseOfTheProtocol) {
  const auto bytes = bytes_of("0100000000d204000000000000aabb");
  const auto data = parse_binary(bytes);
  ASSERT_TRUE(data);
  EXPECT_EQ(data->subscription, 0U);
  EXPECT_EQ(data->received_ns, 1234);
  EXPECT_THAT(data->payload, ElementsAre(0xaa, 0xbb));
  EXPECT_EQ(data_message(1, bytes_of("010203")), bytes_of("0101000000010203"));
  EXPECT_FALSE(parse_binary(bytes_of("020500000000000000")));  // the time
  EXPECT_FALSE(parse_binary(bytes_of("0100000000d2040000000000")));
  EXPECT_FALSE(parse_binary({}));
}

TEST(FoxgloveText, SubscribesAndAdvertises) {
  const Json subscribe = Json::parse(subscribe_text({{1, 7}}));
  EXPECT_EQ(subscribe,
            Json::parse(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":7}]})"));
  const Json advertise = Json::parse(advertise_text({{2, "/map", "cdr", "nav_msgs/msg/Path"}}));
  EXPECT_EQ(advertise, Json::parse(R"({"op":"advertise","channels":[{"id":2,"topic":"/map",)"
                                   R"("encoding":"cdr","schemaName":"nav_msgs/msg/Path"}]})"));
}

}  // namespace
}  // namespace marco::foxglove
