#include "lcm_tools/process/lcm_bus.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <deque>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "lcm_tools/diagnosis/host.hpp"
#include "lcm_tools/diagnosis/listening_socket.hpp"

namespace marco::process {
namespace {

// Of LCM's own queues, drained before each message: what arrives while one is handled must fit.
constexpr int kLcmCapacity = 4000;
// Drained in a row before one message is handled, so that a flood cannot starve the handlers.
constexpr int kDrainedAtOnce = 1000;

constexpr int kReceiveBytes = 2 << 20;
constexpr std::string_view kBufferOption = "recv_buf_size=";

/// The receive buffer that a url asks for [bytes].
int wanted_buffer(const std::string& url) {
  const std::size_t at = url.find(kBufferOption);
  const int named = at == std::string::npos ? 0 : std::atoi(&url[at + kBufferOption.size()]);
  return named > 0 ? named : kReceiveBytes;
}

/// With as large a buffer as the system gives: LCM would report its failed request, without a
/// remedy. enlarge_buffer() does the rest.
std::string with_buffer(std::string url) {
  if (!url.starts_with("udpm:") && !url.starts_with("mpudpm:")) return url;
  const int most = std::atoi(diagnosis::read_text("/proc/sys/net/core/rmem_max").c_str());
  const int wanted = wanted_buffer(url);
  const std::string bytes = std::to_string(most > 0 ? std::min(wanted, most) : wanted);
  const std::size_t at = url.find(kBufferOption);
  if (at == std::string::npos) {
    return url + (url.find('?') == std::string::npos ? "?" : "&") + std::string(kBufferOption) +
           bytes;
  }
  const std::size_t value = at + kBufferOption.size();
  return url.replace(value, url.find_first_not_of("0123456789", value) - value, bytes);
}

bool is_of_the_network(int error) {
  return error == ENETUNREACH || error == ENETDOWN || error == EHOSTUNREACH || error == ENODEV ||
         error == EADDRNOTAVAIL;
}

bool port_is_taken(const std::string& url) {
  if (!url.starts_with("udpm:")) return false;
  try {
    const diagnosis::ListeningSocket socket(diagnosis::parse_udp_url(url), 1 << 16);
    return false;
  } catch (const std::runtime_error&) {
    return true;
  } catch (const std::invalid_argument&) {
    return false;  // LCM reads urls its own way
  }
}

std::string why_not_open(const std::string& url) {
  try {
    const diagnosis::UdpUrl udp = diagnosis::parse_udp_url(url);
    diagnosis::Prober prober;
    diagnosis::NetworkState state = diagnosis::look_at_network(udp, prober, 0);
    state.listeners = diagnosis::find_listeners(udp.port, 0);
    if (const auto broken = diagnosis::broken_path(state)) {
      return broken->text + ". To fix it:\n  " + broken->command;
    }
    return "see LCM's message above";
  } catch (const std::invalid_argument& not_udp) {
    return not_udp.what();
  }
}

}  // namespace

struct LcmBus::Subscription {
  struct Waiting {
    int64_t number;
    std::string channel;
    std::vector<uint8_t> bytes;
    Utime arrival;
  };

  LcmBus* bus;
  std::function<bool(const RawMessage&)> wanted;  // empty: all are
  RawHandler handler;
  std::deque<Waiting> queue;
  std::size_t bytes = 0;

  void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    const auto* data = static_cast<const uint8_t*>(buffer->data);
    const Utime arrival = Utime::from_us(buffer->recv_utime);
    if (wanted && !wanted({channel, {data, buffer->data_size}, arrival})) return;
    queue.push_back({bus->taken_, channel, {data, data + buffer->data_size}, arrival});
    bytes += buffer->data_size;
    ++bus->queued_;
    while (overflows()) {
      const int64_t number = queue.front().number;
      const Size size = size_of_oldest();
      drop_oldest();
      bus->drop_oldest_until(number, size);
    }
  }

  bool overflows() const {
    const bool large = bytes > kSmallBytes * queue.size();
    return queue.size() > (large ? kQueueCapacity : kSmallCapacity) ||
           (bytes > kQueueBytes && queue.size() > 1);
  }

  Size size_of_oldest() const {
    return queue.front().bytes.size() <= kSmallBytes ? Size::small : Size::large;
  }

  void drop_oldest() { ++bus->lost_[take().channel]; }

  Waiting take() {
    Waiting first = std::move(queue.front());
    queue.pop_front();
    bytes -= first.bytes.size();
    --bus->queued_;
    return first;
  }
};

LcmBus::LcmBus(const std::string& url)
    : effective_url_(effective_lcm_url(url)), lcm_(with_buffer(effective_url_)) {
  // LCM itself tries the port at the first subscription only, and then crashes.
  if (lcm_.good() && !port_is_taken(effective_url_)) return;
  throw std::runtime_error("cannot open LCM at '" + effective_url_ +
                           "': " + why_not_open(effective_url_));
}

LcmBus::~LcmBus() = default;

std::string LcmBus::url() const { return with_buffer(effective_url_); }

void LcmBus::subscribe_raw(const std::string& channel_regex, RawHandler handler) {
  subscribe_some(channel_regex, {}, std::move(handler));
}

void LcmBus::subscribe_some(const std::string& channel_regex,
                            std::function<bool(const RawMessage&)> wanted,
                            RawHandler handler) {
  subscriptions_.push_back(std::make_unique<Subscription>(
      Subscription{this, std::move(wanted), std::move(handler), {}, 0}));
  const std::set<int> before = diagnosis::own_udp_sockets();
  lcm::Subscription* subscription =
      lcm_.subscribe(channel_regex, &Subscription::handle, subscriptions_.back().get());
  subscription->setQueueCapacity(kLcmCapacity);
  for (const int socket : diagnosis::own_udp_sockets()) {
    if (!before.contains(socket)) enlarge_buffer(socket);
  }
}

void LcmBus::enlarge_buffer(int socket) {
  sockets_.push_back(socket);
  const int wanted = wanted_buffer(effective_url_);
  const int64_t given = diagnosis::ask_for_buffer(socket, wanted);
  if (given >= wanted) return;
  spdlog::warn(
      "LCM's receive buffer has {} kB instead of {}: large messages may be lost. To fix it:\n  {}",
      given / 1024, wanted / 1024, diagnosis::larger_buffers_command());
}

int64_t LcmBus::lost_datagrams() const {
  int64_t sum = 0;
  for (const int socket : sockets_) sum += diagnosis::lost_datagrams(socket);
  return sum;
}

void LcmBus::publish_raw(const std::string& channel,
                         std::span<const uint8_t> bytes,
                         Utime /*utime*/) {
  errno = 0;
  if (lcm_.publish(channel, bytes.data(), static_cast<unsigned int>(bytes.size())) == 0) {
    if (unsent_ > 0) spdlog::info("LCM can send again; {} messages were not sent", unsent_);
    unsent_ = 0;
    return;
  }
  const bool gone = is_of_the_network(errno);
  const bool news = gone && unsent_++ == 0;  // to find out why takes time
  std::string why = "LCM could not send on " + channel;
  if (news) why += ": " + why_not_open(effective_url_);
  if (!gone || !keep_going_) throw std::runtime_error(why);
  if (news) spdlog::warn("{}", why);
}

void LcmBus::drop_oldest_until(int64_t number, Size dropped) {
  for (const auto& one : subscriptions_) {
    while (one->queue.size() > kFewMessages && one->queue.front().number <= number &&
           (dropped == Size::small || one->size_of_oldest() == Size::large)) {
      one->drop_oldest();
    }
  }
}

void LcmBus::drain_lcm(int timeout_ms) {
  for (int i = 0; i < kDrainedAtOnce; ++i) {
    // Not handleTimeout(): it takes a signal for a failure.
    pollfd ready{lcm_.getFileno(), POLLIN, 0};
    const int count = poll(&ready, 1, i == 0 ? timeout_ms : 0);
    if (count == 0 || (count < 0 && errno == EINTR)) return;
    ++taken_;
    if (count < 0 || lcm_.handle() != 0) {
      throw std::runtime_error("LCM stopped delivering messages");
    }
  }
}

void LcmBus::handle_oldest() {
  int64_t oldest = std::numeric_limits<int64_t>::max();
  for (const auto& one : subscriptions_) {
    if (!one->queue.empty()) oldest = std::min(oldest, one->queue.front().number);
  }
  std::exception_ptr failure;
  bool tapped = !tap_;
  for (std::size_t i = 0; i < subscriptions_.size(); ++i) {  // a handler may subscribe
    Subscription& one = *subscriptions_[i];
    if (one.queue.empty() || one.queue.front().number != oldest) continue;
    const Subscription::Waiting message = one.take();
    try {
      if (!std::exchange(tapped, true)) tap_({message.channel, message.bytes, message.arrival});
      one.handler({message.channel, message.bytes, message.arrival});
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

bool LcmBus::handle_once(int timeout_ms) {
  drain_lcm(queued_ > 0 ? 0 : timeout_ms);
  if (queued_ == 0) return false;
  handle_oldest();
  return true;
}

std::string effective_lcm_url(const std::string& from_command_line) {
  if (!from_command_line.empty()) return from_command_line;
  if (const char* url = std::getenv("LCM_DEFAULT_URL"); url != nullptr && *url != '\0') return url;
  return "udpm://239.255.76.67:7667?ttl=0";
}

}  // namespace marco::process
