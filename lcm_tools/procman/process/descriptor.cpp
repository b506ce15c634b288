#include "lcm_tools/procman/process/descriptor.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>

namespace marco::procman {

std::optional<uid_t> peer_of(const Descriptor& socket) {
  ucred who = {};
  socklen_t size = sizeof who;
  if (getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &who, &size) != 0) return std::nullopt;
  return who.uid;
}

int64_t monotonic_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

int64_t wall_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void poll_for(std::span<pollfd> sources, int64_t wait_us) {
  const timespec wait = {wait_us / 1'000'000, (wait_us % 1'000'000) * 1000};
  if (ppoll(sources.data(), sources.size(), &wait, nullptr) < 0 && errno != EINTR) {
    throw_errno("ppoll");
  }
}

std::optional<sockaddr_un> socket_address(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return std::nullopt;
  std::copy(path.begin(), path.end(), address.sun_path);
  return address;
}

void throw_errno(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

}  // namespace marco::procman
