#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <cstdint>
#include <optional>
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

/// The user at the other end of a local socket; none when that cannot be told.
std::optional<uid_t> peer_of(const Descriptor& socket);

/// Microseconds of the monotonic clock.
int64_t monotonic_us();

/// Microseconds since 1970.
int64_t wall_clock_us();

/// A descriptor that becomes readable when one of SIGINT, SIGTERM, SIGHUP, SIGQUIT comes; they are
/// blocked in this thread and those it makes, so call it first. Also ignores SIGPIPE.
Descriptor open_stop_signals();

/// Reads one such signal. @returns its number, 0 if none has come.
int take_stop_signal(const Descriptor& signals);

/// Throws std::runtime_error "WHAT: the system's reason".
[[noreturn]] void throw_errno(const std::string& what);

}  // namespace marco::procman
