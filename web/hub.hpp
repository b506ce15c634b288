#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/process/drop_counter.hpp"
#include "web/crowd.hpp"
#include "web/foxglove/server.hpp"
#include "web/outbox.hpp"
#include "web/rate_limit.hpp"

namespace marco::web {

/// The protocol's server without its sockets: channels, services, clients with what each of them
/// subscribed, and what waits for each. A client costs the others nothing: everything is put into
/// its own bounded outbox, and work for it is done in turns. One thread.
class Hub {
 public:
  using ClientId = uint64_t;

  /// What a connection does for its client.
  struct Link {
    std::function<void()> wake;                      ///< the outbox is no longer empty
    std::function<void(const std::string&)> let_go;  ///< with the reason; close() follows
    std::function<void()> ping;                      ///< on_pong() may follow
  };
  struct Who {
    bool may_steer = false;
    std::string address;  ///< of its host
  };
  /// A question of a client, answered now or later by answer().
  struct Call {
    ClientId client = 0;
    uint32_t service = 0, call = 0;
    bool may_steer = false;
  };
  using Service = std::function<void(const Call& call, std::string_view request_json)>;
  /// A message that a client published.
  struct Published {
    ClientId client = 0;
    bool may_steer = false;
    std::string topic;
    std::string_view json;
  };

  static constexpr int kMostSteering = 64;                               ///< clients who may steer
  static constexpr int kMostWatching = 64, kMostWatchingOfAddress = 32;  ///< others: none of those
  static constexpr std::size_t kMostWaitingBytes = std::size_t{64} << 20;  ///< of all clients
  static constexpr double kOrdersPerS = 50.0;     ///< of a client, but for velocities
  static constexpr double kMessagesPerS = 250.0;  ///< of a client, of any kind
  static constexpr double kSubscriptionsPerS = 20.0, kMostSubscriptions = 2000.0;  ///< of a client

  /// @param drops  counts what is refused, by cause; outlives the hub
  /// @param now_s  any clock that never steps back
  Hub(foxglove::Identity identity, process::DropCounter& drops, std::function<double()> now_s);

  /// Told to all clients. @returns its id, never used before.
  uint32_t add_channel(const std::string& topic,
                       const std::string& schema_name,
                       const std::string& schema);
  void remove_channel(uint32_t channel);
  void add_service(const std::string& name,
                   const std::string& request_schema,
                   const std::string& response_schema,
                   Service service);
  /// One that clients read. @param json  its value
  void add_parameter(const std::string& name, const std::string& json);

  /// Somebody subscribed to a channel: what is known of it may be sent by publish_to.
  std::function<void(ClientId, uint32_t channel)> on_subscribed;
  /// The same for what is large, a part at a time, as the client takes it. @param from  0, then
  /// what it returned. @returns where the next part begins; 0: that was all
  std::function<uint64_t(ClientId, uint32_t channel, uint64_t from)> on_part;
  std::function<void(const Published&)> on_published;
  std::function<void(ClientId)> on_closed;
  std::function<void(ClientId, const foxglove::PlaybackControl&)> on_playback;  ///< may steer

  /// Whether anybody listens: else a message need not be made.
  bool wanted(uint32_t channel) const;
  void publish(uint32_t channel, int64_t time_ns, std::string json, uint64_t slot = 0);
  void publish_to(
      ClientId client, uint32_t channel, int64_t time_ns, std::string json, uint64_t slot = 0);
  /// A message that makes those waiting of its channel needless.
  void publish_alone(uint32_t channel, int64_t time_ns, std::string json);
  void answer(const Call& call, std::string_view json);
  void tell(ClientId client, foxglove::Level level, const std::string& message);
  /// To all clients.
  void broadcast(std::string binary);
  void send_binary(ClientId client, std::string binary);

  /// Why one more has no room, for the counts; "" = it has.
  std::string why_full(const Who& who) const;
  /// @returns the new client, or 0 when there are too many.
  ClientId open(Link link, const Who& who);
  void close(ClientId client);
  void take_text(ClientId client, std::string_view text);
  void take_binary(ClientId client, std::span<const uint8_t> message);
  /// Whether a message orders a stop, or its release: it waits for no turn.
  bool is_stop(std::span<const uint8_t> message) const;
  /// What is to be sent next; nothing also for a client that is gone.
  std::optional<Outgoing> next_outgoing(ClientId client);
  /// What remains to be done for clients.
  Turns& turns() { return turns_; }

  /// Since a client last sent anything. Of clients that know no `alive`, which our page sends
  /// often, a pong counts. Infinite for one that is gone.
  double silence_s(ClientId client) const;
  /// Asks a client that does not say `alive` for a sign of life.
  void ping(ClientId client);
  void on_pong(ClientId client);
  void on_ping(ClientId client);

  std::size_t clients() const { return clients_.size(); }
  /// Of what waits for all of them and is being sent.
  std::size_t waiting_bytes() const { return *waiting_; }
  /// Messages that clients did not get, those gone included.
  int64_t dropped() const;

 private:
  struct Client {
    Link link;
    Who who;
    Outbox outbox;
    std::deque<std::pair<uint32_t, uint64_t>> parts;  // channels to announce, from where
    bool has_turn = false;                            // for a part
    double heard_s = 0.0;
    bool says_alive = false;
    std::map<uint32_t, uint32_t> channel_of;       // by the client's subscription
    std::map<uint32_t, uint32_t> subscription_of;  // by our channel
    std::map<uint32_t, std::string> publishes;     // topics, by the client's channel
    RateLimit orders{kOrdersPerS, kOrdersPerS};
    RateLimit messages{kMessagesPerS, 2 * kMessagesPerS};
    RateLimit subscriptions{kSubscriptionsPerS, kMostSubscriptions};
    bool is_going = false;
  };
  struct ServedService {
    foxglove::OfferedService offered;
    Service serve;
  };
  std::shared_ptr<const std::string> share(std::string text);
  std::shared_ptr<const std::string> share_again(uint32_t channel, std::string text);
  void make_room();
  Client* slowest();
  void tell_parts(ClientId id, Client& client);
  void tell_part(ClientId id);
  void greet(Client& client);
  void send_text(Client& client, std::string text);
  void push_control(Client& client, Outgoing message);
  void push_data(Client& client,
                 uint32_t channel,
                 int64_t time_ns,
                 const std::shared_ptr<const std::string>& body,
                 uint64_t slot);
  void let_go(Client& client, const std::string& why);
  void refuse(Client& client, const std::string& why);
  bool admits(Client& client);
  void subscribe(ClientId id, Client& client, const foxglove::Subscribe& wanted);
  void unsubscribe(Client& client, const foxglove::Unsubscribe& gone);
  void publish_channels(Client& client, const foxglove::Publish& offered);
  void send_parameters(Client& client, const foxglove::GetParameters& wanted);
  void take_published(ClientId id, Client& client, const foxglove::PublishedData& data);
  void take_call(ClientId id, Client& client, const foxglove::ServiceCall& call);

  foxglove::Identity identity_;
  process::DropCounter& drops_;
  std::function<double()> now_s_;
  std::map<uint32_t, foxglove::OfferedChannel> channels_;
  std::map<uint32_t, int> listeners_;  // by channel
  std::map<uint32_t, ServedService> services_;
  std::vector<foxglove::Parameter> parameters_;
  // Of what waits and is being sent, in bytes; texts that are told outlive the hub.
  std::shared_ptr<std::size_t> waiting_ = std::make_shared<std::size_t>(0);
  std::map<uint32_t, std::weak_ptr<const std::string>> told_;  // to one client, by channel
  Turns turns_;
  std::map<ClientId, Client> clients_;
  uint32_t last_channel_ = 0;
  ClientId last_client_ = 0;
  int64_t dropped_before_ = 0;  // of clients that are gone
};

}  // namespace marco::web
