#include "lcm_tools/diagnosis/listening_socket.hpp"

#include <arpa/inet.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace marco::diagnosis {

int64_t ask_for_buffer(int socket, int bytes) {
  if (::setsockopt(socket, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0) {
    ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  }
  int has = 0;
  socklen_t size = sizeof has;
  ::getsockopt(socket, SOL_SOCKET, SO_RCVBUF, &has, &size);
  return has / 2;  // the kernel doubles it, for its own records
}

int64_t lost_datagrams(int socket) {
  uint32_t counts[SK_MEMINFO_VARS] = {};
  socklen_t size = sizeof counts;
  ::getsockopt(socket, SOL_SOCKET, SO_MEMINFO, counts, &size);
  return counts[SK_MEMINFO_DROPS];
}

std::set<int> own_udp_sockets() {
  std::set<int> sockets;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", none)) {
    const int fd = std::atoi(entry.path().filename().c_str());
    int kind = 0;
    sockaddr_storage address = {};
    socklen_t kind_size = sizeof kind, address_size = sizeof address;
    if (::getsockopt(fd, SOL_SOCKET, SO_TYPE, &kind, &kind_size) == 0 && kind == SOCK_DGRAM &&
        ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &address_size) == 0 &&
        address.ss_family == AF_INET) {
      sockets.insert(fd);
    }
  }
  return sockets;
}

ListeningSocket::ListeningSocket(const UdpUrl& url, int buffer_bytes)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), group_(url.group) {
  const int on = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  ::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  // Other groups on this port belong to other URLs.
  const int off = 0;
  ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off);
  ask_for_buffer(socket_, buffer_bytes);
  sockaddr_in any = {};
  any.sin_family = AF_INET;
  any.sin_port = htons(url.port);
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) {
    const std::string why = std::strerror(errno);
    ::close(socket_);
    throw std::runtime_error("cannot listen on UDP port " + std::to_string(url.port) + ": " + why);
  }
}

ListeningSocket::~ListeningSocket() { ::close(socket_); }

bool ListeningSocket::join(std::string& error) const {
  ip_mreq request = {};
  request.imr_multiaddr.s_addr = htonl(group_);
  request.imr_interface.s_addr = htonl(INADDR_ANY);
  if (::setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0)
    return true;
  error = std::strerror(errno);
  return false;
}

uint64_t ListeningSocket::inode() const {
  struct stat status = {};
  return ::fstat(socket_, &status) == 0 ? status.st_ino : 0;
}

int64_t ListeningSocket::buffer_bytes() const {
  int bytes = 0;
  socklen_t size = sizeof bytes;
  ::getsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, &size);
  return bytes;
}

}  // namespace marco::diagnosis
