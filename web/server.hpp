#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "lcm_tools/process/drop_counter.hpp"
#include "web/access.hpp"
#include "web/hub.hpp"
#include "web/site.hpp"

namespace marco::web {

struct ServerOptions {
  std::string address = "127.0.0.1";
  uint16_t port = 8765;          ///< 0 = any that is free
  std::string certificate, key;  ///< PEM files; "" = no TLS
};

/// HTTP and WebSocket on one port, by Boost.Beast: files of a Site, and clients of a Hub.
/// Everything is bounded: connections, headers, frames, and the time that each may take. One
/// thread: work is done within step(), and nothing waits for a client.
class Server {
 public:
  /// All outlive the server.
  /// @throws std::runtime_error saying why it cannot listen there, or read a certificate.
  Server(const ServerOptions& options,
         const Access& access,
         const Site& site,
         Hub& hub,
         process::DropCounter& drops);
  ~Server();

  /// "http://127.0.0.1:8765/"
  std::string url() const;

  /// Waits until a connection has something to do, or `other` (a file descriptor, -1 = none) can be
  /// read, or the time is over, and does what is to be done.
  void step(int other, int timeout_ms);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace marco::web
