#include "web/hub.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace marco::web {
namespace {

constexpr std::size_t kBatch = 100;  // channels announced at once, as the SDK does

constexpr std::size_t kRoomBytes = std::size_t{1} << 20;  // more waits: parts wait, too

}  // namespace

Hub::Hub(foxglove::Identity identity, process::DropCounter& drops, std::function<double()> now_s)
    : identity_(std::move(identity)), drops_(drops), now_s_(std::move(now_s)) {}

uint32_t Hub::add_channel(const std::string& topic,
                          const std::string& schema_name,
                          const std::string& schema) {
  const uint32_t id = ++last_channel_;
  const foxglove::OfferedChannel& channel =
      channels_.emplace(id, foxglove::OfferedChannel{id, topic, schema_name, schema}).first->second;
  for (auto& [client, state] : clients_) send_text(state, foxglove::offer_text({&channel, 1}));
  return id;
}

void Hub::remove_channel(uint32_t channel) {
  if (channels_.erase(channel) == 0) return;
  listeners_.erase(channel);
  told_.erase(channel);
  for (auto& [id, client] : clients_) {
    if (const auto own = client.subscription_of.find(channel);
        own != client.subscription_of.end()) {
      client.channel_of.erase(own->second);
      client.subscription_of.erase(own);
    }
    client.outbox.drop(channel);
    send_text(client, foxglove::withdraw_text({channel}));
  }
}

void Hub::add_service(const std::string& name,
                      const std::string& request_schema,
                      const std::string& response_schema,
                      Service service) {
  const auto id = static_cast<uint32_t>(services_.size() + 1);
  services_[id] = {{id, name, request_schema, response_schema}, std::move(service)};
}

void Hub::add_parameter(const std::string& name, const std::string& json) {
  parameters_.push_back({name, json});
}

bool Hub::wanted(uint32_t channel) const {
  const auto count = listeners_.find(channel);
  return count != listeners_.end() && count->second > 0;
}

void Hub::publish(uint32_t channel, int64_t time_ns, std::string json, uint64_t slot) {
  if (!wanted(channel)) return;
  const auto body = share(std::move(json));
  for (auto& [id, client] : clients_) push_data(client, channel, time_ns, body, slot);
}

void Hub::publish_alone(uint32_t channel, int64_t time_ns, std::string json) {
  for (auto& [id, client] : clients_) client.outbox.drop(channel);
  publish(channel, time_ns, std::move(json));
}

void Hub::publish_to(
    ClientId client, uint32_t channel, int64_t time_ns, std::string json, uint64_t slot) {
  const auto at = clients_.find(client);
  if (at != clients_.end()) {
    push_data(at->second, channel, time_ns, share_again(channel, std::move(json)), slot);
  }
}

std::shared_ptr<const std::string> Hub::share(std::string text) {
  *waiting_ += text.size();
  return {new std::string(std::move(text)), [waiting = waiting_](const std::string* gone) {
            *waiting -= gone->size();
            delete gone;
          }};
}

// Many who come to see the same map hold it once.
std::shared_ptr<const std::string> Hub::share_again(uint32_t channel, std::string text) {
  auto& before = told_[channel];
  if (auto same = before.lock(); same && *same == text) return same;
  auto shared = share(std::move(text));
  before = shared;
  return shared;
}

/// Of those for whom something waits: a watcher before who may steer, then by how much it is.
Hub::Client* Hub::slowest() {
  Client* slowest = nullptr;
  for (auto& [id, client] : clients_) {
    if (client.is_going || client.outbox.bytes() == 0) continue;
    const auto rank = [](const Client& one) {
      return std::pair(!one.who.may_steer, one.outbox.bytes());
    };
    if (slowest == nullptr || rank(client) > rank(*slowest)) slowest = &client;
  }
  return slowest;
}

void Hub::make_room() {
  while (*waiting_ > kMostWaitingBytes) {
    std::size_t ends = 0;  // with connections that are being closed
    for (const auto& [id, client] : clients_) ends += client.is_going ? client.outbox.bytes() : 0;
    Client* client =
        *waiting_ - std::min(ends, *waiting_) > kMostWaitingBytes ? slowest() : nullptr;
    if (client == nullptr) return;
    client->outbox.clear();
    let_go(*client, "disconnected: client too slow");
  }
}

void Hub::push_data(Client& client,
                    uint32_t channel,
                    int64_t time_ns,
                    const std::shared_ptr<const std::string>& body,
                    uint64_t slot) {
  const auto own = client.subscription_of.find(channel);
  if (own == client.subscription_of.end() || client.is_going) return;
  client.outbox.push_data(channel, slot, {false, foxglove::data_head(own->second, time_ns), body});
  client.link.wake();
  make_room();
}

void Hub::send_text(Client& client, std::string text) {
  push_control(client, {true, "", share(std::move(text))});
}

void Hub::send_binary(ClientId client, std::string binary) {
  const auto at = clients_.find(client);
  if (at != clients_.end()) push_control(at->second, {false, "", share(std::move(binary))});
}

void Hub::broadcast(std::string binary) {
  const auto body = share(std::move(binary));
  for (auto& [id, client] : clients_) push_control(client, {false, "", body});
}

void Hub::push_control(Client& client, Outgoing message) {
  if (client.is_going) return;
  if (!client.outbox.push_control(std::move(message))) {
    return let_go(client, "disconnected: client too slow");
  }
  client.link.wake();
  make_room();
}

void Hub::let_go(Client& client, const std::string& why) {
  if (std::exchange(client.is_going, true)) return;
  drops_.count(why);
  client.link.let_go(why);
}

void Hub::refuse(Client& client, const std::string& why) {
  drops_.count(why);
  send_text(client, foxglove::status_text(foxglove::Level::error, why));
}

void Hub::answer(const Call& call, std::string_view json) {
  send_binary(call.client, foxglove::service_message(call.service, call.call, json));
}

void Hub::tell(ClientId client, foxglove::Level level, const std::string& message) {
  const auto at = clients_.find(client);
  if (at != clients_.end()) send_text(at->second, foxglove::status_text(level, message));
}

std::string Hub::why_full(const Who& who) const {
  int alike = 0, of_address = 0;
  for (const auto& [id, client] : clients_) {
    if (client.who.may_steer != who.may_steer) continue;
    ++alike;
    of_address += client.who.address == who.address ? 1 : 0;
  }
  if (who.may_steer) return alike < kMostSteering ? "" : "refused: more than 64 clients that steer";
  if (alike >= kMostWatching) return "refused: more than 64 clients that watch";
  return of_address < kMostWatchingOfAddress
             ? ""
             : "refused: more than 32 clients that watch from one address";
}

Hub::ClientId Hub::open(Link link, const Who& who) {
  if (const std::string why = why_full(who); !why.empty()) {
    drops_.count(why);
    return 0;
  }
  Client& client = clients_[++last_client_];
  client.link = std::move(link);
  client.who = who;
  client.heard_s = now_s_();
  greet(client);
  return last_client_;
}

void Hub::greet(Client& client) {
  foxglove::Identity identity = identity_;
  identity.metadata["read_only"] = client.who.may_steer ? "false" : "true";
  send_text(client, foxglove::server_info_text(identity));
  std::vector<foxglove::OfferedChannel> batch;
  for (const auto& [id, channel] : channels_) {
    batch.push_back(channel);
    if (batch.size() < kBatch) continue;
    send_text(client, foxglove::offer_text(batch));
    batch.clear();
  }
  if (!batch.empty()) send_text(client, foxglove::offer_text(batch));
  std::vector<foxglove::OfferedService> services;
  for (const auto& [id, service] : services_) services.push_back(service.offered);
  if (!services.empty()) send_text(client, foxglove::services_text(services));
}

void Hub::close(ClientId client) {
  const auto at = clients_.find(client);
  if (at == clients_.end()) return;
  for (const auto& [channel, subscription] : at->second.subscription_of) --listeners_[channel];
  dropped_before_ += at->second.outbox.dropped();
  clients_.erase(at);
  if (on_closed) on_closed(client);
}

std::optional<Outgoing> Hub::next_outgoing(ClientId id) {
  const auto at = clients_.find(id);
  if (at == clients_.end()) return std::nullopt;
  auto next = at->second.outbox.take();
  tell_parts(id, at->second);
  return next;
}

void Hub::tell_parts(ClientId id, Client& client) {
  if (client.parts.empty() || client.outbox.bytes() > kRoomBytes || client.is_going ||
      std::exchange(client.has_turn, true)) {
    return;
  }
  turns_.add(client.who.may_steer ? Turns::Rank::steers : Turns::Rank::watches,
             [this, id] { tell_part(id); });
}

void Hub::tell_part(ClientId id) {
  const auto at = clients_.find(id);
  if (at == clients_.end()) return;
  Client& client = at->second;
  client.has_turn = false;
  if (client.parts.empty()) return;
  const auto [channel, from] = client.parts.front();
  client.parts.pop_front();
  if (client.subscription_of.contains(channel)) {
    if (const uint64_t next = on_part(id, channel, from); next != 0) {
      client.parts.emplace_front(channel, next);
    }
  }
  tell_parts(id, client);
}

double Hub::silence_s(ClientId id) const {
  const auto at = clients_.find(id);
  return at == clients_.end() ? std::numeric_limits<double>::infinity()
                              : now_s_() - at->second.heard_s;
}

void Hub::ping(ClientId id) {
  const auto at = clients_.find(id);
  if (at != clients_.end() && !at->second.says_alive && at->second.link.ping)
    at->second.link.ping();
}

void Hub::on_pong(ClientId id) {
  const auto at = clients_.find(id);
  if (at != clients_.end() && !at->second.says_alive) at->second.heard_s = now_s_();
}

int64_t Hub::dropped() const {
  int64_t dropped = dropped_before_;
  for (const auto& [id, client] : clients_) dropped += client.outbox.dropped();
  return dropped;
}

}  // namespace marco::web
