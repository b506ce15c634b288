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
/// LCM's own queues refuse the newest message when they are full. So they are emptied into queues
/// of ours before each message that is handled. When one of these has more than kQueueCapacity
/// messages that are not small (kSmallBytes on average), kSmallCapacity of any or kQueueBytes, its
/// oldest is given up: scans, meshes. Small ones on other channels stay, for a scan is worth
/// nothing without the odometry of its time, nor the next scan without that between. The others
/// that came before it go, too, and where small ones must be given up all that came before them;
/// only where kFewMessages or less wait (orders, what a sensor says of itself) they stay. Counted
/// in lost(), once a subscription. A process that is too slow thus falls behind by so much at most,
/// and works on what is now.
///
/// An exception leaving an LCM handler would make the next handle() abort the process: ours run
/// after LCM has returned. The first exception is thrown by handle_once() when all handlers of the
/// message have run.
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
  void publish_raw(const std::string& channel,
                   std::span<const uint8_t> bytes,
                   Utime utime) override;

  std::map<std::string, int64_t> lost() const override { return lost_; }

  /// Waits up to `timeout_ms` for a message and handles it. @returns whether one was handled.
  /// @throws what a handler threw; std::runtime_error when the bus broke.
  bool handle_once(int timeout_ms);

  /// Messages wait that lcm()'s file descriptor no longer tells of: for who polls it.
  bool waiting() const { return queued_ > 0; }

  lcm::LCM& lcm() { return lcm_; }

  /// Called with each message once, before its handlers; the last one set holds.
  void set_tap(RawHandler tap) { tap_ = std::move(tap); }

 private:
  struct Subscription;
  void take_what_came(int timeout_ms);
  void handle_oldest();
  enum class Size { small, large };
  void give_up_until(int64_t number, Size given_up);

  lcm::LCM lcm_;
  int64_t taken_ = 0;  ///< messages so far: the order of arrival over all subscriptions
  std::size_t queued_ = 0;
  std::map<std::string, int64_t> lost_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  RawHandler tap_;
};

/// The url a process uses: `--lcm-url`, else LCM_DEFAULT_URL, else multicast with ttl 0 and a
/// receive buffer of 2 MB, which a grid or mesh tile needs.
std::string effective_lcm_url(const std::string& from_command_line);

}  // namespace marco::process
