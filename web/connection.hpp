#pragma once

#include "lcm_tools/process/drop_counter.hpp"
#include "web/access.hpp"
#include "web/byte_stream.hpp"
#include "web/crowd.hpp"
#include "web/hub.hpp"
#include "web/site.hpp"

/// One connection from its first byte to its last. Internal to the server.
namespace marco::web {

/// What all connections use.
struct Shared {
  const Access& access;
  const Site& site;
  Hub& hub;
  process::DropCounter& drops;
  Connections connections = {};
  GuessPace guesses = {};
};

/// Of whom it comes: an IPv4 address, or the network of an IPv6 one, of which a host has many.
std::string address_of(const Tcp::socket& socket);

/// Serves it until it ends. @param tls  null: plain
void start_connection(Tcp::socket socket, Shared& shared, Tls* tls);

}  // namespace marco::web
