#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/spy/receiver.hpp"
#include "live/diagnosis/silence_watch.hpp"
#include "web/health.hpp"
#include "web/hub.hpp"
#include "web/process/source.hpp"

namespace marco::web {

/// page/health once a second: what programs say, what comes on each channel and what is lost (the
/// spy's model), and what is missing (the diagnosis of all live programs). While nobody listens,
/// the network is not listened to a second time.
class HealthChannel {
 public:
  /// All outlive it.
  HealthChannel(Hub& hub, const Source& source, const lcm_schema::Decoder& decoder);

  /// Of a recording: what the network's datagrams are live.
  void take(const process::RawMessage& message);
  /// See Health.
  void forget(const std::string& program) { health_.forget(program); }
  /// Call often. @param more  findings of others, requested when they are published
  void step(const std::function<std::vector<HealthFinding>()>& more);
  /// One line for PROCESS_STATUS.
  std::string state(const std::string& otherwise) const;

 private:
  void listen();
  void subscribe(process::Bus& in);
  std::vector<ChannelHealth> channels();
  std::vector<HealthFinding> lacking() const;

  Hub& hub_;
  process::DropCounter& drops_;
  uint32_t channel_;
  bool is_live_;
  std::optional<diagnosis::UdpUrl> url_;  // nothing: another transport
  const lcm_schema::Decoder& decoder_;
  std::unique_ptr<diagnosis::SilenceWatch> silence_;
  std::unique_ptr<spy::SharedModel> heard_;
  std::unique_ptr<spy::Receiver> receiver_;
  Health health_;
  int64_t told_us_ = 0, wanted_us_ = 0;  ///< monotonic
};

}  // namespace marco::web
