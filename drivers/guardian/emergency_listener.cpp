#include "drivers/guardian/emergency_listener.hpp"

#include "drivers/transport/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert_robot.hpp"

namespace marco::drivers {

EmergencyListener::EmergencyListener(const std::string& base, const std::string& lcm_url)
    : bus_(lcm_url), base_(base), latch_(base, lcm_url) {
  bus_.subscribe<emergency_stop_t>(
      channels::kEmergencyStop, drops_, [this](const emergency_stop_t& message, const auto&) {
        heard_stop_ = heard_stop_ || message.engaged != 0;
        must_save_ = gate_.on_emergency_stop(from_message(message), wall_now()) || must_save_;
      });
  if (const auto kept = latch_.load()) gate_.on_emergency_stop(*kept, wall_now());
}

EmergencyListener::~EmergencyListener() {
  while (must_save_ || saving_.valid()) {
    if (saving_.valid()) saving_.wait();
    keep();
  }
}

int EmergencyListener::descriptor() { return is_open_ ? bus_.lcm().getFileno() : -1; }

bool EmergencyListener::receive() {
  constexpr int kAtMost = 50;
  heard_stop_ = false;
  try {
    for (int i = 0; is_open_ && i < kAtMost && bus_.handle_once(0); ++i) {
    }
  } catch (const std::runtime_error&) {
    is_open_ = false;  // the driver ends by the same, and the guardian stops what it drove
  }
  return heard_stop_;
}

std::string EmergencyListener::keep() {
  std::string fault;
  if (saving_.valid()) {
    if (saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return "";
    fault = saving_.get();
  }
  if (!std::exchange(must_save_, false)) return fault;
  // A disk may take seconds, in which somebody must look after the wheels.
  saving_ = std::async(std::launch::async, [latch = latch_, stop = gate_.latched()] {
    try {
      latch.save(stop);
      return std::string();
    } catch (const std::exception& failure) {
      return std::string("the emergency stop, or its release, could not be saved for a restart: ") +
             failure.what();
    }
  });
  return fault;
}

void EmergencyListener::publish_hung(const std::string& note) {
  const Utime now = wall_now();
  if (!is_open_ || std::abs((now - published_).seconds()) < 0.5) return;
  published_ = now;
  BaseStatus status;
  status.utime = now;
  status.base = base_;
  status.link = BaseStatus::Link::down;
  status.note = gate_.note() + (gate_.stopped() ? "; " : "") + note;
  try {
    bus_.publish(channels::kBaseStatus, to_message(status));
  } catch (const std::runtime_error&) {
    is_open_ = false;
  }
}

}  // namespace marco::drivers
