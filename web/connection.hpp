#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <string>

#include "lcm_tools/process/drop_counter.hpp"
#include "web/access.hpp"
#include "web/hub.hpp"
#include "web/site.hpp"

/// One connection from its first byte to its last. Internal to the server.
namespace marco::web {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;

inline constexpr int kMostConnections = 256;

/// What all connections use, and how many there are.
struct Shared {
  const Access& access;
  const Site& site;
  Hub& hub;
  process::DropCounter& drops;
  int connections = 0;
};

/// A certificate and its key. @throws std::runtime_error where they cannot be read.
class Tls {
 public:
  Tls(const std::string& certificate, const std::string& key);
  ~Tls();
  struct Context;
  Context& context() { return *context_; }

 private:
  std::unique_ptr<Context> context_;
};

/// Serves it until it ends. @param tls  null: plain
void start_connection(Tcp::socket socket, Shared& shared, Tls* tls);

}  // namespace marco::web
