// Foxglove's protocol from the server's side, byte by byte.
#include "web/foxglove/server.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace marco::foxglove {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;
using Json = nlohmann::json;

std::vector<uint8_t> hex_bytes(const std::string& hex) {
  std::vector<uint8_t> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

std::string raw(const std::string& hex) {
  const auto bytes = hex_bytes(hex);
  return {bytes.begin(), bytes.end()};
}

TEST(ServerTexts, NameTheServerAndWhatItCan) {
  const Identity identity{"page", "s1", {"services"}, {{"mode", "live"}}};
  EXPECT_EQ(Json::parse(server_info_text(identity)),
            Json::parse(R"({"op":"serverInfo","name":"page","capabilities":["services"],)"
                        R"("supportedEncodings":["json"],"metadata":{"mode":"live"},)"
                        R"("sessionId":"s1"})"));
  const Identity recording{"page", "s1", {}, {}, std::pair{int64_t{1'500'000'000}, int64_t{2}}};
  const Json info = Json::parse(server_info_text(recording));
  EXPECT_EQ(info["dataStartTime"], (Json{{"sec", 1}, {"nsec", 500'000'000}}));
  EXPECT_EQ(info["dataEndTime"], (Json{{"sec", 0}, {"nsec", 2}}));
}

TEST(ServerTexts, OfferChannelsWithTheirSchemas) {
  const OfferedChannel channel{7, "/scan", "foxglove.LaserScan", R"({"type":"object"})"};
  const Json offered = Json::parse(offer_text({&channel, 1}));
  EXPECT_EQ(offered["op"], "advertise");
  EXPECT_EQ(offered["channels"],
            Json::parse(R"([{"id":7,"topic":"/scan","encoding":"json","schemaEncoding":)"
                        R"("jsonschema","schemaName":"foxglove.LaserScan",)"
                        R"("schema":"{\"type\":\"object\"}"}])"));
  EXPECT_EQ(Json::parse(withdraw_text({7, 9}))["channelIds"], (Json{7, 9}));
}

TEST(ServerTexts, OfferServicesInTheOldFormAndTheNew) {
  const OfferedService service{2, "go", "{}", R"({"type":"object"})"};
  const Json offered = Json::parse(services_text({&service, 1}))["services"][0];
  EXPECT_EQ(offered["requestSchema"], "{}");
  EXPECT_EQ(offered["response"]["schema"], R"({"type":"object"})");
  EXPECT_EQ(offered["request"]["encoding"], "json");
  EXPECT_EQ(offered["type"], "go");
}

TEST(ServerTexts, ReplaceWhatIsNoUtf8) {
  const Json status = Json::parse(status_text(Level::error, "a\xff<script>"));
  EXPECT_EQ(status["level"], 2);
  EXPECT_EQ(status["message"], "a\xEF\xBF\xBD<script>");
}

TEST(ServerTexts, AnswerQuestionsAboutParameters) {
  const Json answer = Json::parse(parameters_text({{"mode", R"("live")"}, {"n", "3"}}, "q7"));
  EXPECT_EQ(answer["parameters"], Json::parse(R"([{"name":"mode","value":"live"},)"
                                              R"({"name":"n","value":3}])"));
  EXPECT_EQ(answer["id"], "q7");
  EXPECT_FALSE(Json::parse(parameters_text({}, "")).contains("id"));
}

TEST(ServerBytes, AreLittleEndian) {
  EXPECT_EQ(data_head(0x01020304, 0x05), raw("01040302010500000000000000"));
  EXPECT_EQ(service_message(2, 3, "{}"), raw("030200000003000000040000006a736f6e7b7d"));
  EXPECT_EQ(asset_failure(5, "no"), raw("04050000000102000000") + "no");
  PlaybackState state;
  state.is_playing = false;
  state.time_ns = 1;
  state.speed = 2.0;
  state.did_seek = true;
  state.request = "r";
  EXPECT_EQ(playback_state(state), raw("050101000000000000000000004001") + raw("01000000") + "r");
}

TEST(ClientTexts, SubscribeAndUnsubscribe) {
  const auto wanted = std::get<Subscribe>(
      parse_client_text(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":5},)"
                        R"({"id":"x","channelId":5},7,{"id":2}]})"));
  EXPECT_THAT(wanted.subscriptions, ElementsAre(Pair(1U, 5U)));
  const auto gone = std::get<Unsubscribe>(
      parse_client_text(R"({"op":"unsubscribe","subscriptionIds":[1,-2,4294967296,3]})"));
  EXPECT_THAT(gone.subscriptions, ElementsAre(1U, 3U));
}

TEST(ClientTexts, PublishAndAsk) {
  const auto offered = std::get<Publish>(parse_client_text(
      R"({"op":"advertise","channels":[{"id":3,"topic":"/cmd_vel","encoding":"json",)"
      R"("schemaName":"geometry_msgs/Twist"},{"topic":"/x"}]})"));
  ASSERT_EQ(offered.channels.size(), 1U);
  EXPECT_EQ(offered.channels[0].topic, "/cmd_vel");
  const auto asked = std::get<GetParameters>(
      parse_client_text(R"({"op":"getParameters","parameterNames":["a"],"id":"q"})"));
  EXPECT_THAT(asked.names, ElementsAre("a"));
  EXPECT_EQ(asked.id, "q");
  EXPECT_TRUE(std::holds_alternative<FetchAsset>(
      parse_client_text(R"({"op":"fetchAsset","uri":"package://x","requestId":4})")));
}

TEST(ClientTexts, PassOverUnknownOperationsAndRefuseTheRest) {
  EXPECT_TRUE(std::holds_alternative<std::monostate>(
      parse_client_text(R"({"op":"subscribeConnectionGraph"})")));
  for (const char* text : {"", "[]", "{}", "{\"op\":3}", "x", "{\"op\":\"\"}"}) {
    EXPECT_THROW(parse_client_text(text), std::invalid_argument) << text;
  }
}

TEST(ClientBytes, AreMessagesCallsAndPlayback) {
  const auto message = hex_bytes("0103000000aabb");
  const auto data = std::get<PublishedData>(parse_client_binary(message));
  EXPECT_EQ(data.channel, 3U);
  EXPECT_THAT(data.payload, ElementsAre(0xaa, 0xbb));
  const auto called = hex_bytes("020100000009000000040000006a736f6e7b7d");
  const auto call = std::get<ServiceCall>(parse_client_binary(called));
  EXPECT_EQ(call.service, 1U);
  EXPECT_EQ(call.call, 9U);
  EXPECT_EQ(call.encoding, "json");
  EXPECT_THAT(call.payload, ElementsAre('{', '}'));
  const auto played = hex_bytes("030100000040010700000000000000010000006b");
  const auto control = std::get<PlaybackControl>(parse_client_binary(played));
  EXPECT_FALSE(control.play);
  EXPECT_EQ(control.speed, 2.0);
  EXPECT_EQ(control.seek_ns, 7);
  EXPECT_EQ(control.request, "k");
}

TEST(ClientBytes, RefuseWhatIsCutOff) {
  const auto whole = hex_bytes("020100000009000000040000006a736f6e");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<uint8_t> cut(whole.begin(), whole.begin() + static_cast<long>(size));
    EXPECT_THROW(parse_client_binary(cut), std::invalid_argument) << size;
  }
  EXPECT_THROW(parse_client_binary(hex_bytes("020100000009000000effffff7")), std::invalid_argument);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(parse_client_binary(hex_bytes("63"))));
}

TEST(Subprotocol, IsTheFirstThatWeSpeak) {
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(choose_subprotocol(" x , foxglove.sdk.v1,foxglove.websocket.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(choose_subprotocol(""), std::nullopt);
  EXPECT_EQ(choose_subprotocol("foxglove.sdk.v2,,"), std::nullopt);
}

TEST(ClientTexts, AreParsedEightDeepAndNoDeeper) {
  const auto nested = [](int depth) {
    return R"({"op":"advertise","channels":)" + std::string(depth - 1, '[') +
           std::string(depth - 1, ']') + "}";
  };
  EXPECT_NO_THROW(parse_client_text(nested(8)));
  EXPECT_THROW(parse_client_text(nested(9)), std::invalid_argument);
  EXPECT_THROW(parse_client_text(R"({"op":"x","a":)" + std::string(30'000, '[')),
               std::invalid_argument);
  // Brackets in a text are none.
  const std::string quoted = R"({"op":"getParameters","id":"\"[[[[[[[[[[{{{{{{{{{{\\"})";
  EXPECT_EQ(std::get<GetParameters>(parse_client_text(quoted)).id, R"("[[[[[[[[[[{{{{{{{{{{\)");
  EXPECT_TRUE(std::holds_alternative<Alive>(parse_client_text(R"({"op":"alive"})")));
}

}  // namespace
}  // namespace marco::foxglove
