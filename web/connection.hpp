#pragma once

#include "lcm_tools/process/drop_counter.hpp"
#include "web/access.hpp"
#include "web/byte_stream.hpp"
#include "web/hub.hpp"
#include "web/site.hpp"

/// One connection from its first byte to its last. Internal to the server.
namespace marco::web {

inline constexpr int kMostConnections = 256;

/// What all connections use, and how many there are.
struct Shared {
  const Access& access;
  const Site& site;
  Hub& hub;
  process::DropCounter& drops;
  int connections = 0;
};

/// Serves it until it ends. @param tls  null: plain
void start_connection(Tcp::socket socket, Shared& shared, Tls* tls);

}  // namespace marco::web
