#include "lcm_tools/process/heartbeat.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <string_view>

namespace marco::process {
namespace {

constexpr std::chrono::milliseconds kPeriod{100};

/// @returns a datagram socket to the supervisor; -1 when there is none.
int connect_to_supervisor() noexcept {
  const char* name = std::getenv("NOTIFY_SOCKET");
  const std::string_view path = name != nullptr ? name : "";
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) return -1;
  path.copy(address.sun_path, path.size());
  if (path.front() == '@') address.sun_path[0] = '\0';  // an abstract name
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0 || connect(fd, reinterpret_cast<const sockaddr*>(&address), length) == 0) return fd;
  close(fd);
  return -1;
}

bool send_line(int socket, std::string_view line, int flags) noexcept {
  return send(socket, line.data(), line.size(), flags | MSG_NOSIGNAL) >= 0;
}

}  // namespace

Heartbeat::Heartbeat() noexcept : socket_(connect_to_supervisor()) {}

Heartbeat::~Heartbeat() {
  if (socket_ >= 0) close(socket_);
}

void Heartbeat::beat(std::chrono::steady_clock::time_point now) noexcept {
  if (socket_ < 0 || now < next_) return;
  next_ = now + kPeriod;
  send_line(socket_, "WATCHDOG=1", MSG_DONTWAIT);
}

void Heartbeat::stopping() noexcept {
  if (socket_ >= 0) send_line(socket_, "STOPPING=1", MSG_DONTWAIT);
}

bool outlive() noexcept {
  const int fd = connect_to_supervisor();
  if (fd < 0) return false;
  setsid();
  const timeval patience = {1, 0};
  setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  const bool sent = send_line(fd, "OUTLIVES=1", 0);
  close(fd);
  return sent;
}

}  // namespace marco::process
