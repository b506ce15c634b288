#include "simulator/devices/transport/emulator_port.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "drivers/transport/port_claim.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers {
namespace {

// The master of a terminal gives no event when a client comes. It is polled.
constexpr Duration kLookForClient = Duration::from_us(10'000);
// A terminal's buffer in the kernel. That of a pseudo-terminal holds about 16 KiB, so the rest
// waits here. What a slow client leaves beyond it is lost, as on a serial line.
constexpr std::size_t kMaxPending = 65536;

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

bool hung_up(int fd) {
  pollfd state{fd, 0, 0};
  poll(&state, 1, 0);
  return (state.revents & (POLLHUP | POLLERR)) != 0;
}

}  // namespace

EmulatorPort::EmulatorPort(Emulator& emulator, std::string link_path, int tcp_port)
    : emulator_(&emulator), link_path_(std::move(link_path)), tcp_port_(tcp_port) {
  plug_in();
}

EmulatorPort EmulatorPort::pty(Emulator& emulator, const std::string& link_path) {
  return EmulatorPort(emulator, link_path, -1);
}

EmulatorPort EmulatorPort::tcp(Emulator& emulator, int port) {
  require(port >= 0 && port < 65536, "TCP port " + std::to_string(port) + " does not exist");
  return EmulatorPort(emulator, "", port);
}

EmulatorPort::~EmulatorPort() { remove_link(); }

void EmulatorPort::remove_link() {
  if (!claim_.valid()) return;
  unlink(link_path_.c_str());
  give_up_port(link_path_, claim_);
}

void EmulatorPort::plug_in() {
  if (tcp_port_ < 0 && !master_.valid()) open_pty();
  if (tcp_port_ >= 0 && !listener_.valid()) open_tcp_server();
}

void EmulatorPort::unplug() {
  if (connected_) change_connection(false, wall_now());
  remove_link();
  master_.reset();
  listener_.reset();
  client_.reset();
}

void EmulatorPort::open_pty() {
  master_.reset(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK));
  if (!master_.valid() || grantpt(master_.get()) != 0 || unlockpt(master_.get()) != 0) {
    fail("no pseudo-terminal");
  }
  char name[128];
  if (ptsname_r(master_.get(), name, sizeof(name)) != 0) fail("no pseudo-terminal");
  {
    // Opening it once makes it raw before a client comes, and makes the master report a hang-up
    // until then.
    const FileHandle slave(::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC));
    if (!slave.valid() || !set_terminal(slave.get(), {})) fail(name);
  }
  address_ = name;
  if (link_path_.empty()) return;
  const std::filesystem::path link = link_path_;
  if (link.has_parent_path()) std::filesystem::create_directories(link.parent_path());
  require(!std::filesystem::exists(std::filesystem::symlink_status(link)) ||
              std::filesystem::is_symlink(link),
          link_path_ + " exists and is not a link: not replaced");
  claim_ = claim_port(link_path_, name);
  std::filesystem::remove(link);
  std::filesystem::create_symlink(name, link);
  address_ = link_path_;
}

void EmulatorPort::open_tcp_server() {
  listener_.reset(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  setsockopt(listener_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<uint16_t>(tcp_port_));
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener_.get(), generic, sizeof(address)) != 0 || listen(listener_.get(), 4) != 0) {
    fail("TCP port " + std::to_string(tcp_port_));
  }
  socklen_t size = sizeof(address);
  getsockname(listener_.get(), generic, &size);
  tcp_port_ = ntohs(address.sin_port);
  address_ = "tcp:127.0.0.1:" + std::to_string(tcp_port_);
}

void EmulatorPort::change_connection(bool connected, Utime now) {
  connected_ = connected;
  client_baud_ = 0;
  pending_.clear();
  if (!connected) client_.reset();
  emulator_->on_connection(connected, now);
}

void EmulatorPort::look_for_client(Utime now) {
  if (master_.valid()) {
    if (!hung_up(master_.get())) change_connection(true, now);
  } else if (listener_.valid()) {
    client_.reset(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!client_.valid()) return;
    const int on = 1;
    setsockopt(client_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    change_connection(true, now);
  }
}

void EmulatorPort::read_client(Utime now) {
  const int fd = master_.valid() ? master_.get() : client_.get();
  const int baud = master_.valid() ? baud_of_terminal(fd) : 0;
  if (baud != client_baud_) emulator_->receive({}, baud, now);
  client_baud_ = baud;
  uint8_t buffer[4096];
  while (connected_) {
    const ssize_t count = ::read(fd, buffer, sizeof(buffer));
    if (count > 0) {
      emulator_->receive({buffer, static_cast<std::size_t>(count)}, baud, now);
    } else if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
      change_connection(false, now);
    } else {
      return;
    }
  }
}

void EmulatorPort::write_client() {
  const int fd = master_.valid() ? master_.get() : client_.get();
  std::size_t sent = 0;
  while (sent < pending_.size()) {
    const ssize_t count =
        master_.valid() ? ::write(fd, pending_.data() + sent, pending_.size() - sent)
                        : ::send(fd, pending_.data() + sent, pending_.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) break;
    sent += static_cast<std::size_t>(count);
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(sent));
  pending_.resize(std::min(pending_.size(), kMaxPending));
}

void EmulatorPort::add_waits(std::vector<pollfd>& waits) const {
  const short events = static_cast<short>(POLLIN | (pending_.empty() ? 0 : POLLOUT));
  if (connected_) {
    waits.push_back({master_.valid() ? master_.get() : client_.get(), events, 0});
  } else if (listener_.valid()) {
    waits.push_back({listener_.get(), POLLIN, 0});
  }
}

Utime EmulatorPort::next_event(Utime now) const {
  const bool must_look = master_.valid();
  return must_look ? std::min(emulator_->next_event(), now + kLookForClient)
                   : emulator_->next_event();
}

void EmulatorPort::service(Utime now) {
  if (connected_) read_client(now);
  if (!connected_) {
    look_for_client(now);
    if (connected_) read_client(now);
  }
  std::vector<uint8_t> left;
  emulator_->advance(now, left);
  if (!connected_) return;
  pending_.insert(pending_.end(), left.begin(), left.end());
  if (!pending_.empty()) write_client();
}

void serve_ports(std::span<EmulatorPort*> ports, Duration longest) {
  const Utime now = wall_now();
  Utime next = now + longest;
  std::vector<pollfd> waits;
  for (const EmulatorPort* port : ports) {
    next = std::min(next, port->next_event(now));
    port->add_waits(waits);
  }
  const int64_t wait_us = std::max<int64_t>(0, (next - now).us);
  const timespec limit{wait_us / 1'000'000, (wait_us % 1'000'000) * 1000};
  ppoll(waits.data(), waits.size(), &limit, nullptr);
  for (EmulatorPort* port : ports) port->service(wall_now());
}

}  // namespace marco::drivers
