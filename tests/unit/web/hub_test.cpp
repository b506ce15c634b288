// The protocol's server with clients that are values.
#include "web/hub.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "web/foxglove/fields.hpp"

namespace marco::web {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Json = nlohmann::json;

/// What a client got.
struct Got {
  std::vector<Json> texts;
  std::vector<std::string> data;  ///< "subscription:body"
  std::vector<std::string> other;
};

class HubWithClients : public ::testing::Test {
 protected:
  Hub::ClientId open(bool may_steer = true) {
    return hub_.open({[] {}, [this](const std::string& why) { let_go_.push_back(why); }},
                     may_steer);
  }
  Got take(Hub::ClientId client) {
    Got got;
    while (auto message = hub_.outbox(client)->take()) {
      const std::string whole = message->head + *message->body;
      const auto* bytes = reinterpret_cast<const uint8_t*>(whole.data());
      if (message->is_text) {
        got.texts.push_back(Json::parse(whole));
      } else if (whole[0] == 1) {
        got.data.push_back(std::to_string(foxglove::number_at<uint32_t>({bytes, whole.size()}, 1)) +
                           ":" + whole.substr(13));
      } else {
        got.other.push_back(whole);
      }
    }
    return got;
  }
  void subscribe(Hub::ClientId client, uint32_t subscription, uint32_t channel) {
    hub_.take_text(client, Json{{"op", "subscribe"},
                                {"subscriptions", {{{"id", subscription}, {"channelId", channel}}}}}
                               .dump());
  }
  void advertise(Hub::ClientId client, uint32_t id, const std::string& topic) {
    hub_.take_text(
        client, Json{{"op", "advertise"},
                     {"channels",
                      {{{"id", id}, {"topic", topic}, {"encoding", "json"}, {"schemaName", "x"}}}}}
                    .dump());
  }
  void send(Hub::ClientId client, std::string bytes) {
    hub_.take_binary(client, {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  }
  static std::string data(uint32_t channel, const std::string& payload) {
    std::string bytes(1, '\x01');
    foxglove::append_number(bytes, channel);
    return bytes + payload;
  }
  static std::string call(uint32_t service, uint32_t number) {
    std::string bytes(1, '\x02');
    foxglove::append_number(bytes, service);
    foxglove::append_number(bytes, number);
    foxglove::append_number(bytes, uint32_t{4});
    return bytes + "json{}";
  }

  double now_s_ = 100.0;
  process::DropCounter drops_;
  Hub hub_{{"page", "s", {}, {{"mode", "live"}}}, drops_, [this] { return now_s_; }};
  std::vector<std::string> let_go_;
};

TEST_F(HubWithClients, GreetsInTheProtocolsOrder) {
  for (int i = 0; i < 150; ++i) hub_.add_channel("c" + std::to_string(i), "s", "{}");
  hub_.add_service("go", "{}", "{}", {});
  const auto texts = take(open(false)).texts;
  ASSERT_THAT(texts, SizeIs(4));
  EXPECT_EQ(texts[0]["op"], "serverInfo");
  EXPECT_EQ(texts[0]["metadata"]["read_only"], "true");
  EXPECT_EQ(texts[0]["metadata"]["mode"], "live");
  EXPECT_THAT(texts[1]["channels"], SizeIs(100));
  EXPECT_THAT(texts[2]["channels"], SizeIs(50));
  EXPECT_EQ(texts[3]["op"], "advertiseServices");
}

TEST_F(HubWithClients, TellsChannelsThatComeAndGo) {
  const auto client = open();
  take(client);
  const uint32_t channel = hub_.add_channel("LIDAR", "bot_core.planar_lidar_t", "{}");
  EXPECT_EQ(take(client).texts.at(0)["channels"][0]["topic"], "LIDAR");
  subscribe(client, 9, channel);
  EXPECT_TRUE(hub_.wanted(channel));
  hub_.publish(channel, 1, "waits");
  hub_.remove_channel(channel);
  EXPECT_FALSE(hub_.wanted(channel));
  const auto got = take(client);
  EXPECT_EQ(got.texts.at(0)["op"], "unadvertise");
  EXPECT_THAT(got.data, IsEmpty());
}

TEST_F(HubWithClients, GivesEachWhatItSubscribed) {
  const uint32_t a = hub_.add_channel("a", "s", "{}"), b = hub_.add_channel("b", "s", "{}");
  const auto one = open(), two = open();
  EXPECT_FALSE(hub_.wanted(a));
  subscribe(one, 5, a);
  subscribe(two, 6, a);
  subscribe(two, 7, b);
  take(one);
  take(two);
  hub_.publish(a, 1, "x");
  hub_.publish(b, 1, "y");
  EXPECT_THAT(take(one).data, ElementsAre("5:x"));
  EXPECT_THAT(take(two).data, ElementsAre("6:x", "7:y"));
  hub_.take_text(two, R"({"op":"unsubscribe","subscriptionIds":[6]})");
  hub_.close(one);
  EXPECT_FALSE(hub_.wanted(a));
  EXPECT_TRUE(hub_.wanted(b));
}

TEST_F(HubWithClients, SendsWhatIsKnownToANewSubscriberAlone) {
  const uint32_t channel = hub_.add_channel("a", "s", "{}");
  hub_.on_subscribed = [this](Hub::ClientId client, uint32_t wanted) {
    hub_.publish_to(client, wanted, 1, "known");
  };
  const auto one = open(), two = open();
  subscribe(one, 1, channel);
  take(one);
  subscribe(two, 2, channel);
  subscribe(two, 3, channel);  // one subscription a channel
  EXPECT_THAT(take(one).data, IsEmpty());
  EXPECT_THAT(take(two).data, ElementsAre("2:known"));
}

TEST_F(HubWithClients, CostsOthersNothingWhenOneDoesNotRead) {
  const uint32_t channel = hub_.add_channel("a", "s", "{}");
  const auto stalled = open(), reader = open();
  subscribe(stalled, 1, channel);
  subscribe(reader, 1, channel);
  take(reader);
  for (int i = 0; i < 1000; ++i) {
    hub_.publish(channel, i, std::to_string(i) + std::string(10000, 'x'));
    EXPECT_THAT(take(reader).data, SizeIs(1));
  }
  EXPECT_LT(hub_.outbox(stalled)->bytes(), 20000U);
  EXPECT_EQ(hub_.dropped(), 0);
  for (uint64_t tile = 0; tile < 40; ++tile) {
    hub_.publish(channel, 0, std::string(1 << 20, 'x'), tile + 1);
    EXPECT_THAT(take(reader).data, SizeIs(1));
  }
  const int64_t dropped = hub_.dropped();
  EXPECT_GE(dropped, 40 - 24);
  hub_.close(stalled);
  EXPECT_EQ(hub_.dropped(), dropped);
  EXPECT_EQ(hub_.outbox(stalled), nullptr);
}

TEST_F(HubWithClients, PassesOnWhatClientsPublish) {
  std::vector<std::string> published;
  hub_.on_published = [&](const Hub::Published& message) {
    published.push_back(message.topic + std::string(message.json) +
                        (message.may_steer ? "+" : "-"));
  };
  const auto one = open(true), two = open(false);
  advertise(one, 4, "/cmd_vel");
  advertise(two, 4, "/goal_pose");
  send(one, data(4, "{1}"));
  send(two, data(4, "{2}"));
  send(two, data(5, "{3}"));  // not advertised
  hub_.take_text(one, R"({"op":"unadvertise","channelIds":[4]})");
  send(one, data(4, "{4}"));
  EXPECT_THAT(published, ElementsAre("/cmd_vel{1}+", "/goal_pose{2}-"));
  EXPECT_EQ(drops_.by_cause().at("refused: a message on a channel that was not advertised"), 2);
}

TEST_F(HubWithClients, CountsOrdersAwayButNotVelocities) {
  int velocities = 0, goals = 0;
  hub_.on_published = [&](const Hub::Published& message) {
    ++(message.topic == "/cmd_vel" ? velocities : goals);
  };
  const auto client = open();
  advertise(client, 1, "/cmd_vel");
  advertise(client, 2, "/goal_pose");
  for (int i = 0; i < 200; ++i) {
    send(client, data(1, "{}"));
    send(client, data(2, "{}"));
  }
  EXPECT_EQ(velocities, 200);
  EXPECT_EQ(goals, 50);
  now_s_ += 1.0;
  for (int i = 0; i < 60; ++i) send(client, data(2, "{}"));
  EXPECT_EQ(goals, 100);
}

TEST_F(HubWithClients, AnswersCallsAndSaysWhyNot) {
  std::vector<Hub::Call> calls;
  hub_.add_service("go", "{}", "{}", [&](const Hub::Call& call, std::string_view json) {
    EXPECT_EQ(json, "{}");
    calls.push_back(call);
  });
  const auto client = open(false);
  take(client);
  send(client, call(1, 77));
  ASSERT_THAT(calls, SizeIs(1));
  EXPECT_FALSE(calls[0].may_steer);
  hub_.answer(calls[0], R"({"ok":true})");
  EXPECT_THAT(take(client).other.at(0), HasSubstr(R"({"ok":true})"));
  send(client, call(9, 78));
  const Json failure = take(client).texts.at(0);
  EXPECT_EQ(failure["op"], "serviceCallFailure");
  EXPECT_EQ(failure["callId"], 78);
  for (int i = 0; i < 100; ++i) send(client, call(1, 79));
  EXPECT_THAT(calls, SizeIs(50));
}

TEST_F(HubWithClients, NeverCountsAStopAway) {
  int stops = 0;
  hub_.add_service("stop", "{}", "{}", [&](const Hub::Call&, std::string_view) { ++stops; });
  const auto client = open(false);
  for (int i = 0; i < 200; ++i) send(client, call(1, 1));
  EXPECT_EQ(stops, 200);
}

TEST_F(HubWithClients, RefusesWhatItDoesNotUnderstand) {
  const auto client = open();
  take(client);
  hub_.take_text(client, "<script>");
  hub_.take_text(client, R"({"op":"somethingNew"})");
  send(client, "");
  const auto texts = take(client).texts;
  ASSERT_THAT(texts, SizeIs(2));
  EXPECT_EQ(texts[0]["op"], "status");
  EXPECT_EQ(texts[0]["level"], 2);
  EXPECT_THAT(let_go_, IsEmpty());
}

TEST_F(HubWithClients, LetsGoWhoSendsTooMuchOrReadsNothing) {
  const auto flood = open();
  for (int i = 0; i < 3000; ++i) hub_.take_text(flood, R"({"op":"x"})");
  EXPECT_THAT(let_go_, ElementsAre("let go: a client that sends too much"));
  const auto deaf = open();
  for (int i = 0; i < 3000; ++i) {
    now_s_ += 1.0;
    hub_.take_text(deaf, "x" + std::string(1000, 'x'));  // each is answered
    hub_.tell(deaf, foxglove::Level::info, std::string(10000, 'x'));
  }
  EXPECT_THAT(let_go_, ElementsAre("let go: a client that sends too much",
                                   "let go: a client that does not read"));
  EXPECT_LT(hub_.outbox(deaf)->bytes(), Outbox::kMostControlBytes + 20000);
}

TEST_F(HubWithClients, IsNotFilledByOneClientsChannels) {
  const auto client = open();
  for (uint32_t id = 0; id < 300; ++id) advertise(client, id, "/x");
  EXPECT_EQ(drops_.by_cause().at("refused: too many channels of one client"), 200);
  const auto other = open();
  advertise(other, 1, std::string(1000, 'x'));
  EXPECT_EQ(drops_.by_cause().at("refused: too many channels of one client"), 201);
}

TEST_F(HubWithClients, HasRoomFor64) {
  std::vector<Hub::ClientId> clients;
  for (std::size_t i = 0; i < Hub::kMostClients; ++i) clients.push_back(open());
  EXPECT_EQ(open(), 0U);
  hub_.close(clients[3]);
  EXPECT_NE(open(), 0U);
}

TEST_F(HubWithClients, AnswersParametersAndAssets) {
  hub_.add_parameter("mode", R"("live")");
  hub_.add_parameter("speed", "0.5");
  const auto client = open();
  take(client);
  hub_.take_text(client, R"({"op":"getParameters","parameterNames":["speed"],"id":"1"})");
  hub_.take_text(client, R"({"op":"fetchAsset","uri":"x","requestId":3})");
  const auto got = take(client);
  EXPECT_THAT(got.texts.at(0)["parameters"], SizeIs(1));
  EXPECT_THAT(got.other.at(0), HasSubstr("no assets"));
}

}  // namespace
}  // namespace marco::web
