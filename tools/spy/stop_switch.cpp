#include "tools/spy/stop_switch.hpp"

#include <chrono>
#include <thread>

#include "lcmtypes/channels.hpp"
#include "tools/spy/system.hpp"

namespace marco::spy {

void StopSwitch::order(Order order) {
  constexpr int kTimes = 10;
  if (!bus_) bus_ = std::make_unique<process::LcmBus>(url_);
  message_.utime = wall_clock_us();
  message_.engaged = order == Order::stop ? 1 : 0;
  message_.sender = "marco-spy";
  message_.reason = order == Order::stop ? "stop key" : "release key";
  left_ = kTimes;
  repeat();
}

void StopSwitch::repeat() {
  if (left_ == 0) return;
  --left_;
  bus_->publish(channels::kEmergencyStop, message_);
}

void StopSwitch::finish() {
  for (; left_ > 0; repeat()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

}  // namespace marco::spy
