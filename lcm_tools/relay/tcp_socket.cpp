#include "lcm_tools/relay/tcp_socket.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::relay {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses addresses_of(const Endpoint& endpoint, int flags) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags;
  addrinfo* found = nullptr;
  const int code = getaddrinfo(endpoint.host.c_str(), endpoint.port.c_str(), &hints, &found);
  if (code != 0) throw std::runtime_error(to_string(endpoint) + ": " + gai_strerror(code));
  return {found, &freeaddrinfo};
}

TcpSocket open_socket(const addrinfo& address) {
  return TcpSocket(socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

void set(int descriptor, int level, int option, int value) {
  setsockopt(descriptor, level, option, &value, sizeof value);
}

void tune(int descriptor) {
  constexpr int kGoneMs = 10'000;
  set(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
  set(descriptor, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(descriptor, IPPROTO_TCP, TCP_KEEPIDLE, 3);
  set(descriptor, IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set(descriptor, IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, kGoneMs);
  // What waits is better in our queue, which knows what to drop.
  set(descriptor, SOL_SOCKET, SO_SNDBUF, 256 << 10);
}

}  // namespace

Endpoint parse_endpoint(const std::string& text) {
  Endpoint endpoint;
  const std::size_t colon = text.rfind(':');
  endpoint.port = colon == std::string::npos ? text : text.substr(colon + 1);
  if (colon != std::string::npos) endpoint.host = text.substr(0, colon);
  if (endpoint.host.size() > 2 && endpoint.host.front() == '[' && endpoint.host.back() == ']') {
    endpoint.host = endpoint.host.substr(1, endpoint.host.size() - 2);
  }
  const bool is_number = !endpoint.port.empty() && endpoint.port.size() <= 5 &&
                         endpoint.port.find_first_not_of("0123456789") == std::string::npos;
  require(is_number && !endpoint.host.empty() && std::stoi(endpoint.port) > 0 &&
              std::stoi(endpoint.port) < 65536,
          "'" + text + "': give HOST:PORT or PORT, such as robot:7700");
  return endpoint;
}

std::string to_string(const Endpoint& endpoint) { return endpoint.host + ":" + endpoint.port; }

TcpSocket::TcpSocket(int descriptor) : descriptor_(descriptor) {
  if (is_open()) tune(descriptor_);
}
TcpSocket::~TcpSocket() { close(); }
TcpSocket::TcpSocket(TcpSocket&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}
TcpSocket& TcpSocket::operator=(TcpSocket&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

void TcpSocket::close() {
  if (is_open()) ::close(descriptor_);
  descriptor_ = -1;
}

TcpSocket TcpSocket::listen(const Endpoint& endpoint) {
  const Addresses addresses = addresses_of(endpoint, AI_PASSIVE);
  TcpSocket listener = open_socket(*addresses);
  set(listener.descriptor(), SOL_SOCKET, SO_REUSEADDR, 1);
  constexpr int kWaiting = 16;
  const bool listens =
      listener.is_open() &&
      bind(listener.descriptor(), addresses->ai_addr, addresses->ai_addrlen) == 0 &&
      ::listen(listener.descriptor(), kWaiting) == 0;
  if (!listens) {
    throw std::runtime_error("cannot listen at " + to_string(endpoint) + ": " +
                             std::strerror(errno));
  }
  return listener;
}

TcpSocket TcpSocket::connect(const Endpoint& endpoint) {
  const Addresses addresses = addresses_of(endpoint, 0);
  TcpSocket socket = open_socket(*addresses);
  const bool begun = socket.is_open() && (::connect(socket.descriptor(), addresses->ai_addr,
                                                    addresses->ai_addrlen) == 0 ||
                                          errno == EINPROGRESS);
  if (!begun) throw std::runtime_error(to_string(endpoint) + ": " + std::strerror(errno));
  return socket;
}

TcpSocket TcpSocket::accept() const {
  return TcpSocket(accept4(descriptor_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
}

std::size_t TcpSocket::read(std::span<uint8_t> into) const {
  const auto got = ::recv(descriptor_, into.data(), into.size(), 0);
  if (got > 0) return static_cast<std::size_t>(got);
  if (got == 0) throw std::runtime_error("the other side closed it");
  if (errno == EAGAIN || errno == EINTR) return 0;
  throw std::runtime_error(std::strerror(errno));
}

std::size_t TcpSocket::write(std::span<const char> bytes) const {
  const auto wrote = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (wrote >= 0) return static_cast<std::size_t>(wrote);
  if (errno == EAGAIN || errno == EINTR) return 0;
  throw std::runtime_error(std::strerror(errno));
}

}  // namespace marco::relay
