#pragma once

#include <poll.h>
#include <sys/types.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace marco::procman {

/// A file descriptor that closes itself. -1 = none.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) reset(std::exchange(other.fd_, -1));
    return *this;
  }
  ~Descriptor() { reset(); }

  int get() const { return fd_; }
  bool is_open() const { return fd_ >= 0; }
  void reset(int fd = -1) {
    if (fd_ >= 0) close(fd_);
    fd_ = fd;
  }

 private:
  int fd_;
};

/// The user at the other end of a local socket; none when that is not known.
std::optional<uid_t> peer_of(const Descriptor& socket);

/// Microseconds of the monotonic clock.
int64_t monotonic_us();

/// Microseconds since 1970.
int64_t wall_clock_us();

/// Waits until one of the sources is ready, at most `wait_us` (>= 0). @throws std::runtime_error.
void poll_for(std::span<pollfd> sources, int64_t wait_us);

/// The address of a socket file; none when the path is too long for one.
std::optional<sockaddr_un> socket_address(const std::string& path);

/// Throws std::runtime_error "WHAT: the system's reason".
[[noreturn]] void throw_errno(const std::string& what);

}  // namespace marco::procman
