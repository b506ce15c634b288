#include "common/process/lcm_bus.hpp"

#include <poll.h>

#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace marco::process {
namespace {

// Enough that a burst of scans survives a slow map update; LCM's own 30 drops the newest.
constexpr int kQueueCapacity = 500;

}  // namespace

struct LcmBus::Subscription {
  LcmBus* bus;
  RawHandler handler;

  void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    try {
      handler({channel,
               {static_cast<const uint8_t*>(buffer->data), buffer->data_size},
               Utime::from_us(buffer->recv_utime)});
    } catch (...) {
      if (!bus->failure_) bus->failure_ = std::current_exception();
    }
  }
};

LcmBus::LcmBus(const std::string& url) : lcm_(effective_lcm_url(url)) {
  if (!lcm_.good()) {
    throw std::runtime_error("cannot open LCM at '" + effective_lcm_url(url) +
                             "'. Multicast needs a route; on a host without a network:\n"
                             "  sudo ip link set lo multicast on && "
                             "sudo ip route add 224.0.0.0/4 dev lo");
  }
}

LcmBus::~LcmBus() = default;

void LcmBus::subscribe_raw(const std::string& channel_regex, RawHandler handler) {
  subscriptions_.push_back(std::make_unique<Subscription>(Subscription{this, std::move(handler)}));
  lcm::Subscription* subscription =
      lcm_.subscribe(channel_regex, &Subscription::handle, subscriptions_.back().get());
  subscription->setQueueCapacity(kQueueCapacity);
}

void LcmBus::publish_raw(const std::string& channel,
                         std::span<const uint8_t> bytes,
                         Utime /*utime*/) {
  if (lcm_.publish(channel, bytes.data(), static_cast<unsigned int>(bytes.size())) != 0) {
    throw std::runtime_error("LCM could not send on " + channel);
  }
}

bool LcmBus::handle_once(int timeout_ms) {
  // Not handleTimeout(): it takes a signal for a failure.
  pollfd ready{lcm_.getFileno(), POLLIN, 0};
  const int count = poll(&ready, 1, timeout_ms);
  if (count == 0 || (count < 0 && errno == EINTR)) return false;
  const int result = count > 0 ? lcm_.handle() : -1;
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  if (result != 0) throw std::runtime_error("LCM stopped delivering messages");
  return true;
}

std::string effective_lcm_url(const std::string& from_command_line) {
  if (!from_command_line.empty()) return from_command_line;
  if (const char* url = std::getenv("LCM_DEFAULT_URL"); url != nullptr && *url != '\0') return url;
  return "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";
}

}  // namespace marco::process
