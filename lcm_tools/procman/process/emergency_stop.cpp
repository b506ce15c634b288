#include "lcm_tools/procman/process/emergency_stop.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "lcm_tools/lcmtypes/channels.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "marco/emergency_stop_t.hpp"

namespace marco::procman {
namespace {

constexpr int kQuickSends = 10;
constexpr int64_t kQuickPeriodUs = 50'000;
constexpr int64_t kSlowPeriodUs = 1'000'000;
constexpr const char* kLayout = "lbss";

}  // namespace

EmergencyStop::EmergencyStop(process::Bus& bus, process::DropCounter& drops, std::string sender)
    : bus_(bus), sender_(std::move(sender)) {
  subscribe_checked<marco::emergency_stop_t>(
      bus_, marco::channels::kEmergencyStop, kLayout, drops, [this](const auto& message) {
        if (message.utime <= utime_us_) return;  // ours again, or one that is over
        utime_us_ = message.utime;
        is_ours_ = false;
        note(message.engaged != 0, message.sender, message.reason);
      });
}

void EmergencyStop::note(bool engaged, const std::string& sender, const std::string& reason) {
  engages_ = engaged;
  engaged_ = engaged ? "by " + sender.substr(0, 40) + ": " + reason.substr(0, 200) : "";
}

void EmergencyStop::order(Order order, int64_t now_us) {
  utime_us_ = std::max(wall_clock_us(), utime_us_ + 1);
  is_ours_ = true;
  sent_ = 0;
  next_send_us_ = now_us + kQuickPeriodUs;
  note(order == Order::engage, sender_, "the operator's key");
  send();
}

void EmergencyStop::step_to(int64_t now_us) {
  if (!is_ours_ || now_us < next_send_us_) return;
  if (sent_ >= kQuickSends && !engages_) return;
  next_send_us_ = now_us + (sent_ < kQuickSends ? kQuickPeriodUs : kSlowPeriodUs);
  try {
    send();
  } catch (const std::runtime_error&) {
    sent_ = 0;  // the network is away: as new when it is back
  }
}

void EmergencyStop::send() {
  marco::emergency_stop_t message;
  message.utime = utime_us_;
  message.engaged = engages_ ? 1 : 0;
  message.sender = sender_;
  message.reason = "the operator's key";
  bus_.publish(marco::channels::kEmergencyStop, message);
  ++sent_;
}

}  // namespace marco::procman
