#include "drivers/transport/serial_stream.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/transport/port_advice.hpp"
#include "drivers/transport/port_claim.hpp"
#include "lcm_tools/base/check.hpp"

// <termios.h> is kept out of this folder (terminal.cpp); the queue selectors of TCFLSH are ABI.
#ifndef TCIFLUSH
#define TCIFLUSH 0
#define TCOFLUSH 1
#endif

namespace marco::drivers {
namespace {

using std::chrono::duration_cast;
using std::chrono::microseconds;
using std::chrono::steady_clock;
constexpr microseconds kWriteTimeout{400'000};
constexpr microseconds kConnectTimeout{2'000'000};

timespec to_timespec(microseconds time) {
  return {time.count() / 1'000'000, (time.count() % 1'000'000) * 1000};
}

class TcpStream final : public DescriptorStream {
 public:
  TcpStream(FileHandle handle, std::string name)
      : DescriptorStream(std::move(handle), std::move(name)) {}
  void set_line(const LineSettings&) override {}
};

// @returns an open descriptor, or an invalid one with errno set.
FileHandle connect_to(const addrinfo& address) {
  FileHandle handle(
      socket(address.ai_family, address.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!handle.valid()) return handle;
  if (connect(handle.get(), address.ai_addr, address.ai_addrlen) == 0) return handle;
  if (errno != EINPROGRESS) return FileHandle();
  pollfd waiting{handle.get(), POLLOUT, 0};
  const timespec limit = to_timespec(kConnectTimeout);
  int error = ETIMEDOUT;
  if (ppoll(&waiting, 1, &limit, nullptr) > 0) {
    socklen_t size = sizeof(error);
    getsockopt(handle.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  }
  if (error == 0) return handle;
  errno = error;
  return FileHandle();
}

}  // namespace

bool is_pseudo_terminal(int fd) {
  struct stat status {};
  return fstat(fd, &status) == 0 && major(status.st_rdev) >= 136 && major(status.st_rdev) <= 143;
}

void FileHandle::reset(int fd) {
  if (fd_ >= 0) ::close(fd_);
  fd_ = fd;
}

void DescriptorStream::lost(const std::string& why) const { throw StreamLost(name_ + ": " + why); }

bool DescriptorStream::wait(short events, microseconds timeout) const {
  pollfd waiting{handle_.get(), events, 0};
  const timespec limit = to_timespec(timeout);
  const int ready = ppoll(&waiting, 1, &limit, nullptr);
  if (ready < 0 && errno != EINTR) lost(std::strerror(errno));
  if (ready <= 0) return false;
  if ((waiting.revents & events) == 0) lost("the other side closed the line");
  return true;
}

std::size_t DescriptorStream::read(std::span<uint8_t> into, microseconds timeout) {
  if (!wait(POLLIN, timeout)) return 0;
  const ssize_t count = ::read(handle_.get(), into.data(), into.size());
  if (count > 0) return static_cast<std::size_t>(count);
  if (count == 0 && !into.empty()) lost("closed by the other side");
  if (count < 0 && errno != EAGAIN && errno != EINTR) lost(std::strerror(errno));
  return 0;
}

void discard_output(int fd) { ioctl(fd, TCFLSH, TCOFLUSH); }

void DescriptorStream::write(std::span<const uint8_t> bytes) {
  const auto deadline = steady_clock::now() + kWriteTimeout;
  while (!bytes.empty()) {
    const auto left = duration_cast<microseconds>(deadline - steady_clock::now());
    if (left.count() <= 0) {
      discard_output(handle_.get());
      lost("takes no bytes");
    }
    const ssize_t count = ::write(handle_.get(), bytes.data(), bytes.size());
    if (count > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    } else if (errno != EAGAIN && errno != EINTR) {
      lost(std::strerror(errno));
    } else {
      wait(POLLOUT, left);
    }
  }
}

void DescriptorStream::discard_input() {
  uint8_t waste[4096];
  while (read(waste, microseconds(0)) > 0) {
  }
}

SerialStream::SerialStream(const std::string& path, const LineSettings& line)
    : DescriptorStream(FileHandle(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)),
                       path) {
  const int error = errno;
  if (fd() < 0) {
    const std::string why = why_not_open(path, error, DeviceKind::serial);
    require(error != EBUSY, why);
    throw StreamLost(why);
  }
  if (const std::string why = why_no_device(path, fd()); !why.empty()) lost(why);
  if (flock(fd(), LOCK_EX | LOCK_NB) != 0) {
    if (flock(fd(), LOCK_SH | LOCK_NB) == 0) lost("the guardian of its last driver still stops it");
    throw std::invalid_argument(why_not_open(path, EBUSY, DeviceKind::serial));
  }
  require(baud_of_terminal(fd()) != 0, path + ": not a serial port");
  // On a pseudo-terminal TIOCEXCL would outlive a driver that was killed, as long as the emulator
  // keeps its end open; the file lock ends with the process.
  if (!is_pseudo_terminal(fd())) ioctl(fd(), TIOCEXCL);
  set_line(line);
}

SerialStream::~SerialStream() { ioctl(fd(), TIOCNXCL); }

void SerialStream::set_line(const LineSettings& line) {
  if (!set_terminal(fd(), line)) {
    if (errno == EINVAL) {
      throw std::invalid_argument(name() + ": this port does not support " +
                                  std::to_string(line.baud) + " baud");
    }
    lost(std::strerror(errno));
  }
}

void SerialStream::discard_input() { ioctl(fd(), TCFLSH, TCIFLUSH); }

void SerialStream::set_dtr(bool raised) {
  int line = TIOCM_DTR;
  ioctl(fd(), raised ? TIOCMBIS : TIOCMBIC, &line);
}

std::unique_ptr<ByteStream> open_tcp(const std::string& host, const std::string& port) {
  const std::string name = "tcp:" + host + ":" + port;
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &wanted, &found); error != 0) {
    throw StreamLost(name + ": " + gai_strerror(error));
  }
  FileHandle handle;
  for (const addrinfo* one = found; one != nullptr && !handle.valid(); one = one->ai_next) {
    handle = connect_to(*one);
  }
  const int error = errno;
  freeaddrinfo(found);
  if (!handle.valid()) {
    const char* hint = error == ECONNREFUSED
                           ? ": the host answers, but nothing listens on this port"
                       : error == ETIMEDOUT || error == EHOSTUNREACH || error == ENETUNREACH
                           ? ": is it powered, the cable in, the address right?"
                           : "";
    throw StreamLost(name + ": " + std::strerror(error) + hint);
  }
  const int on = 1;
  setsockopt(handle.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  return std::make_unique<TcpStream>(std::move(handle), name);
}

std::unique_ptr<ByteStream> open_stream(const std::string& address, const LineSettings& line) {
  require(!address.empty(), "no device given: a path, serial:PATH or tcp:HOST:PORT");
  require(line.baud > 0, "the baud rate must be above 0, got " + std::to_string(line.baud));
  if (address.starts_with("tcp:")) {
    const std::size_t colon = address.rfind(':');
    require(colon > 4 && colon + 1 < address.size(), "'" + address + "' is not tcp:HOST:PORT");
    return open_tcp(address.substr(4, colon - 4), address.substr(colon + 1));
  }
  const bool prefixed = address.starts_with("serial:");
  return std::make_unique<SerialStream>(prefixed ? address.substr(7) : address, line);
}

}  // namespace marco::drivers
