#include "lcm_tools/process/status_publisher.hpp"

#include <algorithm>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "marco/process_status_t.hpp"

namespace marco::process {

StatusPublisher::StatusPublisher(Bus& bus, std::string process, const DropCounter& drops)
    : bus_(bus), process_(std::move(process)), drops_(drops) {}

void StatusPublisher::add_latency(double seconds) {
  latency_sum_s_ += seconds;
  latency_max_s_ = std::max(latency_max_s_, seconds);
  ++latencies_;
}

void StatusPublisher::tick(const std::string& state) {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < std::chrono::seconds(1)) return;
  send(state);
}

void StatusPublisher::send(const std::string& state) {
  last_ = std::chrono::steady_clock::now();
  process_status_t status;
  status.utime = wall_clock_us();
  status.process = process_;
  status.received = drops_.received();
  status.used = drops_.received() - drops_.dropped();
  for (const auto& [cause, count] : drops_.by_cause()) {
    status.drop_causes.push_back(cause);
    status.drop_counts.push_back(count);
  }
  for (const auto& [channel, count] : bus_.lost()) {
    status.received += count;
    status.drop_causes.push_back("arrived too fast: the oldest of " + channel);
    status.drop_counts.push_back(count);
  }
  if (const int64_t datagrams = bus_.lost_datagrams(); datagrams > 0) {
    status.drop_causes.push_back("the receive buffer overflowed: datagrams");
    status.drop_counts.push_back(datagrams);
  }
  status.num_causes = static_cast<int32_t>(status.drop_causes.size());
  status.latency_mean_s = latencies_ > 0 ? latency_sum_s_ / latencies_ : 0.0;
  status.latency_max_s = latency_max_s_;
  status.state = state;
  bus_.publish(channels::kProcessStatus, status);
  latency_sum_s_ = latency_max_s_ = 0.0;
  latencies_ = 0;
}

}  // namespace marco::process
