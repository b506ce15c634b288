#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lcm_tools/diagnosis/datagram.hpp"

/// Diagnoses from the system's own tables who sends and listens, and why no message arrives. Pure:
/// texts of /proc in, findings out; host.hpp reads them.
namespace marco::diagnosis {

struct UdpUrl {
  uint32_t group = 0xEFFF4C43;  ///< 239.255.76.67, host byte order
  uint16_t port = 7667;
  int ttl = 0;
  int recv_buf_bytes = 0;  ///< 0: not given

  std::string text() const;  ///< "udpm://239.255.76.67:7667"
};
/// "udpm://GROUP:PORT?ttl=N&recv_buf_size=N", parts may be missing ("udpm://").
/// @throws std::invalid_argument for other transports, saying why they cannot be spied on.
UdpUrl parse_udp_url(const std::string& url);

std::string ip_text(uint32_t ip);

/// A line of /proc/net/udp.
struct UdpSocket {
  Address local;
  uint64_t inode = 0;
  int64_t drops = 0;  ///< datagrams dropped because its buffer was full
};
std::vector<UdpSocket> parse_udp_sockets(std::string_view proc_net_udp);

/// A line of /proc/net/route, host byte order.
struct Route {
  std::string device;
  uint32_t destination = 0;
  uint32_t mask = 0;
  int metric = 0;
};
std::vector<Route> parse_routes(std::string_view proc_net_route);

/// Groups joined on this host, from /proc/net/igmp.
std::vector<uint32_t> parse_joined_groups(std::string_view proc_net_igmp);

struct Interface {
  std::string name;
  bool up = false;
  bool multicast = false;
};

struct Process {
  int pid = -1;      ///< -1: unknown (another user's, another host's, or gone)
  std::string name;  ///< its command; "" = unknown
};
/// "marco-slam (4711)", "?" when not known.
std::string to_string(const Process& process);

/// A socket bound to the bus's port.
struct Listener {
  Process process;
  int64_t drops = 0;
  bool self = false;  ///< this process's own
};

/// The input of the diagnosis.
struct NetworkState {
  std::string program = "marco-spy";  ///< named in the commands for the user
  UdpUrl url;
  std::vector<Route> routes;
  std::vector<Interface> interfaces;
  std::optional<bool> self_test;        ///< whether our own probe came back; nothing: not tried
  bool port_taken = false;              ///< by a process that does not share it
  std::string self_test_error;          ///< the system's message when it could not be sent
  std::vector<std::string> heard_urls;  ///< other URLs with recent LCM messages
  /// Processes that have another URL in their LCM_DEFAULT_URL, and that URL.
  std::vector<std::pair<Process, std::string>> other_urls;
  std::vector<Listener> listeners;
  int64_t own_buffer_bytes = 0;  ///< receive buffer the system gave us
  int64_t rmem_max = 0;          ///< net.core.rmem_max
  int64_t heard_messages = 0;
};

/// A cause of lost messages, and the command that fixes it ("" = none).
struct Finding {
  std::string text;
  std::string command;
};

/// The command that lets programs have receive buffers of 8 MB.
std::string larger_buffers_command();

/// Most certain cause first. While messages arrive: only losses and their causes. Otherwise: at
/// least one finding.
std::vector<Finding> diagnose(const NetworkState& state);

/// The first fault on a message's way through this host; nothing when there is none.
std::optional<Finding> broken_path(const NetworkState& state);

/// The route multicast to `group` takes: longest mask, then lowest metric; nullptr: none.
const Route* route_to(const std::vector<Route>& routes, uint32_t group);

}  // namespace marco::diagnosis
