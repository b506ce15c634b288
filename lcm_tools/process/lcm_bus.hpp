#pragma once

#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <vector>

#include "lcm_tools/process/bus.hpp"

namespace marco::process {

/// The network: udpm:// live, memq:// in tests.
///
/// LCM's own queues refuse the newest message when they are full. They are therefore drained into
/// our queues before each message is handled. A queue is full above kQueueCapacity messages that
/// are larger than kSmallBytes on average, above kSmallCapacity messages of any size, and above
/// kQueueBytes. It then drops its oldest message, and every queue drops its large messages that
/// arrived before that one. Small messages such as odometry stay, because a scan is useless without
/// the odometry of its time. If the dropped message was itself small, all older messages go. A
/// queue of kFewMessages or fewer (orders, sensor infos) keeps them all. Drops are counted in
/// lost(), once a subscription. A process that is too slow thus lags by a bounded time and works on
/// recent messages.
///
/// The receive buffer is 2 MB, which a grid or mesh tile needs, unless the url names a size
/// (recv_buf_size). The log says once when the system gives less.
///
/// An exception that leaves an LCM handler would make the next handle() abort the process, so our
/// handlers run after LCM has returned. handle_once() throws the first exception once all handlers
/// of the message have run.
class LcmBus : public Bus {
 public:
  /// @param url "" = LCM_DEFAULT_URL, or multicast that stays on this host (ttl 0).
  /// @throws std::runtime_error saying why LCM cannot open the url, and what to try.
  explicit LcmBus(const std::string& url);
  static constexpr std::size_t kQueueCapacity = 500;  ///< enough for a burst during a map update
  static constexpr std::size_t kSmallBytes = 512;     ///< and less: odometry, poses, states
  static constexpr std::size_t kSmallCapacity = 50000;
  static constexpr std::size_t kQueueBytes = 64 << 20;
  static constexpr std::size_t kFewMessages = 16;
  ~LcmBus() override;

  void subscribe_raw(const std::string& channel_regex, RawHandler handler) override;
  /// The same for those messages that are wanted. `wanted` is asked when they arrive: others are
  /// neither copied nor queued.
  void subscribe_some(const std::string& channel_regex,
                      std::function<bool(const RawMessage&)> wanted,
                      RawHandler handler);
  /// @throws std::runtime_error when LCM cannot send, unless keep_going_without_network() was
  /// called and the network is what is missing.
  void publish_raw(const std::string& channel,
                   std::span<const uint8_t> bytes,
                   Utime utime) override;
  /// For what must outlive a network that comes and goes (Wi-Fi). Messages that cannot be sent are
  /// dropped; the log reports it once, with the command that fixes it, and again when they are
  /// sent. Not for who drives: a base that nobody can stop stops.
  void keep_going_without_network() { keep_going_ = true; }

  std::map<std::string, int64_t> lost() const override { return lost_; }
  int64_t lost_datagrams() const override;

  /// Waits up to `timeout_ms` for a message and handles it. @returns whether one was handled.
  /// @throws what a handler threw; std::runtime_error when the bus broke.
  bool handle_once(int timeout_ms);

  /// Whether messages wait in our queues. A caller that polls lcm()'s file descriptor must ask: LCM
  /// no longer reports these.
  bool waiting() const { return queued_ > 0; }

  lcm::LCM& lcm() { return lcm_; }
  /// With the receive buffer that it asks for: for programs of others on the same network.
  std::string url() const;

  /// Called once for each message, before its handlers. A new tap replaces the old one.
  void set_tap(RawHandler tap) { tap_ = std::move(tap); }
  /// Shows the tap a message that comes to handlers by another way.
  void tell_tap(const RawMessage& message) const {
    if (tap_) tap_(message);
  }

 private:
  struct Subscription;
  void enlarge_buffer(int socket);
  void drain_lcm(int timeout_ms);
  void handle_oldest();
  enum class Size { small, large };
  void drop_oldest_until(int64_t number, Size dropped);

  std::string effective_url_;
  lcm::LCM lcm_;
  std::vector<int> sockets_;  ///< LCM's own, of the udpm:// that it listens to
  bool keep_going_ = false;
  int64_t unsent_ = 0;  ///< since the network is gone
  int64_t taken_ = 0;   ///< messages so far: the order of arrival over all subscriptions
  std::size_t queued_ = 0;
  std::map<std::string, int64_t> lost_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  RawHandler tap_;
};

/// The url a process uses: `--lcm-url`, else LCM_DEFAULT_URL, else multicast with ttl 0.
std::string effective_lcm_url(const std::string& from_command_line);

}  // namespace marco::process
