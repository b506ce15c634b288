#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "lcm_tools/diagnosis/network.hpp"

namespace marco::diagnosis {

/// Asks the system for a receive buffer: root gets it, others up to net.core.rmem_max.
/// @returns what the socket has now, counted as it was asked for.
int64_t ask_for_buffer(int socket, int bytes);

/// Datagrams that a socket has lost, because its buffer was full.
int64_t lost_datagrams(int socket);

/// The UDP sockets that this process has open.
std::set<int> own_udp_sockets();

/// A UDP socket bound to a URL's port, shared with LCM's own.
class ListeningSocket {
 public:
  /// @param buffer_bytes  see ask_for_buffer().
  /// @throws std::runtime_error naming the port when it cannot be bound.
  ListeningSocket(const UdpUrl& url, int buffer_bytes);
  ~ListeningSocket();
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket& operator=(const ListeningSocket&) = delete;

  /// Joins the group. @returns false, with the system's message, while there is no route to it.
  bool join(std::string& error) const;
  int descriptor() const { return socket_; }
  uint64_t inode() const;
  int64_t buffer_bytes() const;

 private:
  int socket_ = -1;
  uint32_t group_ = 0;
};

}  // namespace marco::diagnosis
