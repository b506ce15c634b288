#pragma once

#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <vector>

#include "common/process/bus.hpp"

namespace marco::process {

/// The network: udpm:// live, memq:// in tests.
///
/// An exception leaving an LCM handler would make the next handle() abort the process, so handlers
/// are wrapped: the first exception is kept and thrown by handle_once() after LCM has returned.
class LcmBus : public Bus {
 public:
  /// @param url "" = LCM_DEFAULT_URL, or multicast that stays on this host (ttl 0).
  /// @throws std::runtime_error saying what to try when LCM cannot open the url.
  explicit LcmBus(const std::string& url);
  ~LcmBus() override;

  void subscribe_raw(const std::string& channel_regex, RawHandler handler) override;
  void publish_raw(const std::string& channel,
                   std::span<const uint8_t> bytes,
                   Utime utime) override;

  /// Waits up to `timeout_ms` for a message and handles it. @returns whether one was handled.
  /// @throws what a handler threw; std::runtime_error when the bus broke.
  bool handle_once(int timeout_ms);

  lcm::LCM& lcm() { return lcm_; }

 private:
  struct Subscription;
  lcm::LCM lcm_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::exception_ptr failure_;
};

/// The url a process uses: `--lcm-url`, else LCM_DEFAULT_URL, else multicast with ttl 0 and a
/// receive buffer of 2 MB, which a grid or mesh tile needs.
std::string effective_lcm_url(const std::string& from_command_line);

}  // namespace marco::process
