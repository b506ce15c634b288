// The protocol's server with clients that are values.
#include "web/hub.hpp"

#include <gmock/gmock.h>

#include <bit>
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
  Hub::ClientId open(bool may_steer = true, const std::string& address = "10.0.0.2") {
    return hub_.open(
        {[] {}, [this](const std::string& why) { let_go_.push_back(why); }, [this] { ++pings_; }},
        {may_steer, address});
  }
  Got take(Hub::ClientId client) {
    Got got;
    while (auto message = hub_.next_outgoing(client)) {
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
  int pings_ = 0;
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
  EXPECT_EQ(hub_.dropped(), 0);
  for (uint64_t tile = 0; tile < 40; ++tile) {
    hub_.publish(channel, 0, std::string(1 << 20, 'x'), tile + 1);
    EXPECT_THAT(take(reader).data, SizeIs(1));
  }
  const int64_t dropped = hub_.dropped();
  EXPECT_GE(dropped, 40 - 24);
  hub_.close(stalled);
  EXPECT_EQ(hub_.dropped(), dropped);
  EXPECT_FALSE(hub_.next_outgoing(stalled));
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
  EXPECT_THAT(let_go_, ElementsAre("disconnected: client sends too much"));
  const auto deaf = open();
  for (int i = 0; i < 3000; ++i) {
    now_s_ += 1.0;
    hub_.take_text(deaf, "x" + std::string(1000, 'x'));  // each is answered
    hub_.tell(deaf, foxglove::Level::info, std::string(10000, 'x'));
  }
  EXPECT_THAT(let_go_,
              ElementsAre("disconnected: client sends too much", "disconnected: client too slow"));
}

TEST_F(HubWithClients, IsNotFilledByOneClientsChannels) {
  const auto client = open();
  for (uint32_t id = 0; id < 300; ++id) advertise(client, id, "/x");
  EXPECT_EQ(drops_.by_cause().at("refused: too many channels of one client"), 200);
  const auto other = open();
  advertise(other, 1, std::string(1000, 'x'));
  EXPECT_EQ(drops_.by_cause().at("refused: too many channels of one client"), 201);
}

TEST_F(HubWithClients, WhoWatchesTakesNoRoomFromWhoSteers) {
  std::vector<Hub::ClientId> watching;
  for (int i = 0; i < Hub::kMostWatchingOfAddress; ++i) watching.push_back(open(false));
  EXPECT_EQ(open(false), 0U);  // from the same address
  for (int i = Hub::kMostWatchingOfAddress; i < Hub::kMostWatching; ++i) {
    EXPECT_NE(open(false, "10.0.0." + std::to_string(i)), 0U);
  }
  EXPECT_EQ(open(false, "10.0.1.1"), 0U);
  for (int i = 0; i < Hub::kMostSteering; ++i) EXPECT_NE(open(), 0U);
  EXPECT_EQ(open(), 0U);
  hub_.close(watching[3]);
  EXPECT_NE(open(false), 0U);
  EXPECT_EQ(drops_.by_cause().at("refused: more than 32 clients that watch from one address"), 1);
  EXPECT_EQ(drops_.by_cause().at("refused: more than 64 clients that watch"), 1);
}

TEST_F(HubWithClients, WhatWaitsForAllIsBoundedAndWhoSteersKeepsTheirs) {
  const uint32_t channel = hub_.add_channel("a", "s", "{}");
  const auto owner = open();
  subscribe(owner, 1, channel);
  for (int i = 0; i < 30; ++i) subscribe(open(false), 1, channel);
  take(owner);
  const std::string megabyte(1 << 20, 'x');
  for (uint64_t slot = 0; slot < 20; ++slot) hub_.publish(channel, 0, megabyte, slot);
  EXPECT_THAT(let_go_, IsEmpty());  // all hold the same 20 MB
  for (int client = 2; client <= 31; ++client) {
    for (uint64_t slot = 0; slot < 10; ++slot) {
      hub_.publish_to(static_cast<Hub::ClientId>(client), channel, 0,
                      megabyte + std::to_string(client * 100) + std::to_string(slot), 100 + slot);
    }
  }
  EXPECT_GT(let_go_.size(), 20U);
  EXPECT_LE(hub_.waiting_bytes(), Hub::kMostWaitingBytes);
  for (const std::string& why : let_go_) EXPECT_EQ(why, "disconnected: client too slow");
  EXPECT_THAT(take(owner).data, SizeIs(20));
}

TEST_F(HubWithClients, WhatIsLargeComesInPartsAsItIsTaken) {
  const uint32_t channel = hub_.add_channel("a", "s", "{}"),
                 other = hub_.add_channel("b", "s", "{}");
  int made = 0;
  hub_.on_part = [&](Hub::ClientId client, uint32_t of, uint64_t from) -> uint64_t {
    ++made;
    hub_.publish_to(client, of, 0, std::string(600'000, 'x') + std::to_string(from), from);
    return from + 1 < 10 ? from + 1 : 0;
  };
  const auto slow = open(false), gone = open(false);
  subscribe(slow, 1, channel);
  subscribe(gone, 1, other);
  EXPECT_EQ(made, 0);  // each has its turn
  hub_.close(gone);
  while (!hub_.turns().empty()) hub_.turns().take_one();
  EXPECT_EQ(made, 2);  // more than a megabyte waits
  std::size_t got = 0;
  for (int i = 0; i < 20; ++i) {
    got += take(slow).data.size();
    while (!hub_.turns().empty()) hub_.turns().take_one();
  }
  EXPECT_EQ(got, 10U);
  EXPECT_EQ(made, 10);
}

TEST_F(HubWithClients, EveryMessageIsASignOfLifeAndAPongWhereNothingElseIs) {
  const auto page = open(), foxglove = open();
  hub_.take_text(page, R"({"op":"alive"})");
  now_s_ += 0.5;
  hub_.ping(page);
  hub_.ping(foxglove);
  EXPECT_EQ(pings_, 1);
  hub_.on_pong(page);  // of a browser whose page stands still
  hub_.on_pong(foxglove);
  EXPECT_EQ(hub_.silence_s(page), 0.5);
  EXPECT_EQ(hub_.silence_s(foxglove), 0.0);
  send(page, data(1, "{}"));
  EXPECT_EQ(hub_.silence_s(page), 0.0);
  hub_.close(page);
  EXPECT_GT(hub_.silence_s(page), 1e9);
}

TEST_F(HubWithClients, KnowsAStopAndPlaysForWhoMaySteer) {
  hub_.add_service("go", "{}", "{}", {});
  hub_.add_service("stop", "{}", "{}", {});
  const auto is_stop = [&](const std::string& bytes) {
    return hub_.is_stop({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  };
  EXPECT_TRUE(is_stop(call(2, 1)));
  EXPECT_FALSE(is_stop(call(1, 1)));
  EXPECT_FALSE(is_stop(data(2, "{}")));
  EXPECT_FALSE(is_stop(call(2, 1).substr(0, 4)));
  int played = 0;
  hub_.on_playback = [&](Hub::ClientId, const foxglove::PlaybackControl&) { ++played; };
  std::string pause("\x03\x01", 2);
  foxglove::append_number(pause, std::bit_cast<uint32_t>(1.0F));
  pause += std::string(13, '\0');
  send(open(false), pause);
  EXPECT_EQ(played, 0);
  send(open(), pause);
  EXPECT_EQ(played, 1);
}

TEST_F(HubWithClients, SubscriptionsAreFewInTheLongRun) {
  const uint32_t channel = hub_.add_channel("a", "s", "{}");
  int told = 0;
  hub_.on_subscribed = [&](Hub::ClientId, uint32_t) { ++told; };
  const auto client = open(false);
  for (int i = 0; i < 10'000; ++i) {
    now_s_ += 0.01;
    subscribe(client, 1, channel);
    hub_.take_text(client, R"({"op":"unsubscribe","subscriptionIds":[1]})");
  }
  EXPECT_LT(told, Hub::kMostSubscriptions + 100.0 * Hub::kSubscriptionsPerS + 1);
  EXPECT_THAT(let_go_, IsEmpty());
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
