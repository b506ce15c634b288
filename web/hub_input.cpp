// What clients send to the hub.
#include <stdexcept>

#include "web/foxglove/fields.hpp"
#include "web/hub.hpp"

namespace marco::web {
namespace {

constexpr std::size_t kMostPublished = 100, kLongestTopic = 256;  // of one client
constexpr std::string_view kVelocityTopic = "/cmd_vel";           // repeated; the newest counts
constexpr std::string_view kStop = "stop";                        // never counted away

}  // namespace

bool Hub::admits(Client& client) {
  if (client.is_going) return false;
  const double now_s = client.heard_s = now_s_();
  if (client.messages.take(now_s)) return true;
  let_go(client, "disconnected: client sends too much");
  return false;
}

void Hub::on_ping(ClientId id) {
  const auto at = clients_.find(id);
  if (at != clients_.end()) admits(at->second);  // it counts as a message
}

void Hub::take_text(ClientId id, std::string_view text) {
  const auto at = clients_.find(id);
  if (at == clients_.end() || !admits(at->second)) return;
  Client& client = at->second;
  drops_.count_received();
  try {
    const foxglove::ClientText message = foxglove::parse_client_text(text);
    if (const auto* wanted = std::get_if<foxglove::Subscribe>(&message)) {
      subscribe(id, client, *wanted);
    } else if (const auto* gone = std::get_if<foxglove::Unsubscribe>(&message)) {
      unsubscribe(client, *gone);
    } else if (const auto* offered = std::get_if<foxglove::Publish>(&message)) {
      publish_channels(client, *offered);
    } else if (const auto* over = std::get_if<foxglove::Unpublish>(&message)) {
      for (const uint32_t channel : over->channels) client.publishes.erase(channel);
    } else if (const auto* asked = std::get_if<foxglove::GetParameters>(&message)) {
      send_parameters(client, *asked);
    } else if (std::holds_alternative<foxglove::Alive>(message)) {
      client.says_alive = true;
    } else if (const auto* asset = std::get_if<foxglove::FetchAsset>(&message)) {
      send_binary(id, foxglove::asset_failure(asset->request, "there are no assets"));
    }
  } catch (const std::invalid_argument& mistake) {
    refuse(client, std::string("refused: ") + mistake.what());
  }
}

void Hub::take_binary(ClientId id, std::span<const uint8_t> message) {
  const auto at = clients_.find(id);
  if (at == clients_.end() || !admits(at->second)) return;
  Client& client = at->second;
  drops_.count_received();
  try {
    const foxglove::ClientBinary parsed = foxglove::parse_client_binary(message);
    if (const auto* data = std::get_if<foxglove::PublishedData>(&parsed)) {
      take_published(id, client, *data);
    } else if (const auto* call = std::get_if<foxglove::ServiceCall>(&parsed)) {
      take_call(id, client, *call);
    } else if (const auto* control = std::get_if<foxglove::PlaybackControl>(&parsed)) {
      if (!client.who.may_steer)
        throw std::invalid_argument("only watching: other clients watch, too");
      if (on_playback) on_playback(id, *control);
    }
  } catch (const std::invalid_argument& mistake) {
    refuse(client, std::string("refused: ") + mistake.what());
  }
}

bool Hub::is_stop(std::span<const uint8_t> message) const {
  constexpr uint8_t kCall = 2;
  if (message.size() < 5 || message[0] != kCall) return false;
  const auto service = services_.find(foxglove::number_at<uint32_t>(message, 1));
  return service != services_.end() && service->second.offered.name == kStop;
}

void Hub::subscribe(ClientId id, Client& client, const foxglove::Subscribe& wanted) {
  for (const auto& [subscription, channel] : wanted.subscriptions) {
    // One subscription a channel.
    if (!channels_.contains(channel) || client.channel_of.contains(subscription) ||
        client.subscription_of.contains(channel)) {
      continue;
    }
    if (!client.subscriptions.take(now_s_())) {
      throw std::invalid_argument("more than 20 subscriptions a second");
    }
    client.channel_of[subscription] = channel;
    client.subscription_of[channel] = subscription;
    ++listeners_[channel];
    if (on_subscribed) on_subscribed(id, channel);
    if (on_part) client.parts.emplace_back(channel, 0);
  }
  tell_parts(id, client);
}

void Hub::unsubscribe(Client& client, const foxglove::Unsubscribe& gone) {
  for (const uint32_t subscription : gone.subscriptions) {
    const auto own = client.channel_of.find(subscription);
    if (own == client.channel_of.end()) continue;
    --listeners_[own->second];
    client.outbox.drop(own->second);
    std::erase_if(client.parts, [&](const auto& part) { return part.first == own->second; });
    client.subscription_of.erase(own->second);
    client.channel_of.erase(own);
  }
}

void Hub::publish_channels(Client& client, const foxglove::Publish& offered) {
  for (const foxglove::PublishedChannel& channel : offered.channels) {
    if (client.publishes.size() >= kMostPublished || channel.topic.size() > kLongestTopic) {
      throw std::invalid_argument("too many channels of one client");
    }
    if (channel.encoding != "json") {
      throw std::invalid_argument("a client's channel that is not json");
    }
    client.publishes[channel.id] = channel.topic;
  }
}

void Hub::send_parameters(Client& client, const foxglove::GetParameters& wanted) {
  std::vector<foxglove::Parameter> found;
  for (const foxglove::Parameter& parameter : parameters_) {
    if (wanted.names.empty() || wanted.names.contains(parameter.name)) found.push_back(parameter);
  }
  send_text(client, foxglove::parameters_text(found, wanted.id));
}

void Hub::take_published(ClientId id, Client& client, const foxglove::PublishedData& data) {
  const auto channel = client.publishes.find(data.channel);
  if (channel == client.publishes.end()) {
    throw std::invalid_argument("a message on a channel that was not advertised");
  }
  if (channel->second != kVelocityTopic && !client.orders.take(now_s_())) {
    throw std::invalid_argument("more than 50 orders a second");
  }
  if (!on_published) return;
  on_published({id,
                client.who.may_steer,
                channel->second,
                {reinterpret_cast<const char*>(data.payload.data()), data.payload.size()}});
}

void Hub::take_call(ClientId id, Client& client, const foxglove::ServiceCall& call) {
  const auto fail = [&](const std::string& why) {
    drops_.count("refused: " + why);
    send_text(client, foxglove::service_failure_text(call.service, call.call, why));
  };
  const auto service = services_.find(call.service);
  if (service == services_.end()) return fail("there is no such service");
  if (call.encoding != "json") return fail("a request that is not json");
  if (service->second.offered.name != kStop && !client.orders.take(now_s_())) {
    return fail("more than 50 orders a second");
  }
  service->second.serve({id, call.service, call.call, client.who.may_steer},
                        {reinterpret_cast<const char*>(call.payload.data()), call.payload.size()});
}

}  // namespace marco::web
