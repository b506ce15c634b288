#include "lcm_tools/diagnosis/listening_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace marco::diagnosis {

ListeningSocket::ListeningSocket(const UdpUrl& url, int buffer_bytes)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), group_(url.group) {
  const int on = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  ::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  // Other groups on this port belong to other URLs.
  const int off = 0;
  ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off);
  if (::setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &buffer_bytes, sizeof buffer_bytes) != 0) {
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof buffer_bytes);
  }
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
