#include "lcm_tools/diagnosis/network.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <sstream>

#include "lcm_tools/base/check.hpp"

namespace marco::diagnosis {
namespace {

template <class Number>
bool parse(std::string_view text, Number& value, int base = 10) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

// The kernel prints addresses in memory order.
uint32_t kernel_ip(uint32_t printed) { return __builtin_bswap32(printed); }

std::vector<std::vector<std::string>> table(std::string_view text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines{std::string(text)};
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::vector<std::string> row;
    std::string word;
    while (words >> word) row.push_back(std::move(word));
    if (!row.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

uint32_t parse_group(std::string_view text, const std::string& url) {
  uint32_t group = 0;
  int parts = 0;
  while (parts < 4) {
    const std::size_t dot = text.find('.');
    uint8_t part = 0;
    require(parse(text.substr(0, dot), part), "'" + url + "': the group is not an IP address");
    group = group << 8U | part;
    ++parts;
    if (dot == std::string_view::npos) break;
    text.remove_prefix(dot + 1);
  }
  require(parts == 4 && group >> 28U == 14,
          "'" + url + "': the group must be 224.0.0.0 to 239.255.255.255");
  return group;
}

}  // namespace

std::string ip_text(uint32_t ip) {
  const std::string text = to_string(Address{ip, 0});
  return text.substr(0, text.find(':'));
}

std::string UdpUrl::text() const { return "udpm://" + to_string(Address{group, port}); }

UdpUrl parse_udp_url(const std::string& url) {
  const std::size_t scheme = url.find("://");
  require(scheme != std::string::npos && url.substr(0, scheme) == "udpm",
          "'" + url +
              "': only udpm:// can be observed (memq:// stays inside a process, tcpq:// names no "
              "senders); for a log give its path");
  UdpUrl result;
  std::string_view rest = std::string_view(url).substr(scheme + 3);
  std::string_view options;
  if (const std::size_t mark = rest.find('?'); mark != std::string_view::npos) {
    options = rest.substr(mark + 1);
    rest = rest.substr(0, mark);
  }
  if (!rest.empty()) {
    const std::size_t colon = rest.find(':');
    if (colon > 0) result.group = parse_group(rest.substr(0, colon), url);
    if (colon != std::string_view::npos) {
      require(parse(rest.substr(colon + 1), result.port) && result.port > 0,
              "'" + url + "': the port must be 1 to 65535");
    }
  }
  while (!options.empty()) {
    const std::string_view option = options.substr(0, options.find_first_of("&;"));
    options.remove_prefix(std::min(options.size(), option.size() + 1));
    const std::size_t equals = option.find('=');
    const std::string_view key = option.substr(0, equals);
    const std::string_view value =
        equals == std::string_view::npos ? std::string_view() : option.substr(equals + 1);
    if (key == "ttl") require(parse(value, result.ttl), "'" + url + "': ttl must be a number");
    if (key == "recv_buf_size")
      require(parse(value, result.recv_buf_bytes), "'" + url + "': recv_buf_size must be a number");
  }
  return result;
}

std::vector<UdpSocket> parse_udp_sockets(std::string_view proc_net_udp) {
  std::vector<UdpSocket> sockets;
  for (const auto& row : table(proc_net_udp)) {
    if (row.size() < 13) continue;
    const std::size_t colon = row[1].find(':');
    UdpSocket socket;
    uint32_t ip = 0;
    if (colon == std::string::npos || !parse(std::string_view(row[1]).substr(0, colon), ip, 16) ||
        !parse(std::string_view(row[1]).substr(colon + 1), socket.local.port, 16) ||
        !parse(row[9], socket.inode) || !parse(row.back(), socket.drops)) {
      continue;
    }
    socket.local.ip = kernel_ip(ip);
    sockets.push_back(socket);
  }
  return sockets;
}

std::vector<Route> parse_routes(std::string_view proc_net_route) {
  constexpr uint32_t kUp = 1;
  std::vector<Route> routes;
  for (const auto& row : table(proc_net_route)) {
    if (row.size() < 8) continue;
    Route route;
    uint32_t flags = 0;
    uint32_t destination = 0;
    uint32_t mask = 0;
    if (!parse(row[1], destination, 16) || !parse(row[3], flags, 16) ||
        !parse(row[6], route.metric) || !parse(row[7], mask, 16) || (flags & kUp) == 0) {
      continue;
    }
    route.device = row[0];
    route.destination = kernel_ip(destination);
    route.mask = kernel_ip(mask);
    routes.push_back(std::move(route));
  }
  return routes;
}

std::vector<uint32_t> parse_joined_groups(std::string_view proc_net_igmp) {
  constexpr uint32_t kAllHosts = 0xE0000001;
  std::vector<uint32_t> groups;
  for (const auto& row : table(proc_net_igmp)) {
    uint32_t group = 0;
    if (row[0].size() != 8 || !parse(row[0], group, 16)) continue;
    group = kernel_ip(group);
    if (group != kAllHosts && std::find(groups.begin(), groups.end(), group) == groups.end())
      groups.push_back(group);
  }
  return groups;
}

std::string to_string(const Process& process) {
  if (process.pid < 0) return process.name.empty() ? "?" : process.name;
  return process.name + " (" + std::to_string(process.pid) + ")";
}

const Route* route_to(const std::vector<Route>& routes, uint32_t group) {
  const Route* best = nullptr;
  for (const Route& route : routes) {
    if ((group & route.mask) != route.destination) continue;
    const int bits = std::popcount(route.mask);
    const int best_bits = best == nullptr ? -1 : std::popcount(best->mask);
    if (bits > best_bits || (bits == best_bits && route.metric < best->metric)) best = &route;
  }
  return best;
}

namespace {

constexpr int64_t kWanted = 8 << 20;

void find_losses(const NetworkState& state, std::vector<Finding>& findings) {
  for (const Listener& listener : state.listeners) {
    if (listener.drops <= 0) continue;
    const std::string who = (listener.self ? state.program : to_string(listener.process)) + "'s";
    findings.push_back(
        {who + " receive buffer overflowed: " + std::to_string(listener.drops) + " datagrams lost",
         state.rmem_max < kWanted
             ? larger_buffers_command() +
                   (listener.self ? ""
                                  : "   and start it with ...&recv_buf_size=2097152 in its LCM url")
             : "LCM_DEFAULT_URL='" + state.url.text() + "?ttl=" + std::to_string(state.url.ttl) +
                   "&recv_buf_size=" + std::to_string(kWanted) + "'"});
  }
}

}  // namespace

std::string larger_buffers_command() {
  return "sudo sysctl -w net.core.rmem_max=" + std::to_string(kWanted);
}

std::optional<Finding> broken_path(const NetworkState& state) {
  const std::string group = ip_text(state.url.group);
  if (state.port_taken) {
    return Finding{
        "UDP port " + std::to_string(state.url.port) + " is held by " +
            (state.listeners.empty() ? "another process" : to_string(state.listeners[0].process)) +
            ", which does not share it: stop it, or use another port",
        "LCM_DEFAULT_URL='udpm://" + group + ":" + std::to_string(state.url.port + 1) +
            "?ttl=" + std::to_string(state.url.ttl) + "'   for all processes"};
  }
  const auto loopback = std::find_if(state.interfaces.begin(), state.interfaces.end(),
                                     [](const Interface& i) { return i.name == "lo"; });
  const bool loopback_down = loopback != state.interfaces.end() && !loopback->up;
  const Route* route = route_to(state.routes, state.url.group);
  if (route == nullptr) {
    return Finding{"no route leads to " + group + ": no process can publish" +
                       (loopback_down ? ", and the loopback interface is down" : ""),
                   std::string("sudo ip link set lo ") + (loopback_down ? "up " : "") +
                       "multicast on && sudo ip route add 224.0.0.0/4 dev lo"};
  }
  const auto device = std::find_if(state.interfaces.begin(), state.interfaces.end(),
                                   [&](const Interface& i) { return i.name == route->device; });
  if (device == state.interfaces.end()) return std::nullopt;
  if (!device->up) {
    return Finding{"multicast is routed to " + device->name + ", which is down",
                   "sudo ip link set " + device->name + " up"};
  }
  if (!device->multicast) {
    return Finding{"multicast is routed to " + device->name + ", which has no multicast flag",
                   "sudo ip link set " + device->name + " multicast on"};
  }
  if (state.self_test == false) {
    return Finding{
        "a message sent to " + state.url.text() + " through " + device->name +
            " does not come back" +
            (state.self_test_error.empty() ? ": a firewall?" : ": " + state.self_test_error),
        "sudo iptables -I INPUT -d " + group + " -p udp --dport " + std::to_string(state.url.port) +
            " -j ACCEPT"};
  }
  return std::nullopt;
}

std::vector<Finding> diagnose(const NetworkState& state) {
  std::vector<Finding> findings;
  find_losses(state, findings);
  if (state.heard_messages > 0) return findings;
  const std::optional<Finding> broken = broken_path(state);
  if (broken) findings.push_back(*broken);
  for (const std::string& url : state.heard_urls) {
    findings.push_back(
        {"LCM messages arrive on another URL: " + url, state.program + " --lcm-url '" + url + "'"});
  }
  for (const auto& [process, url] : state.other_urls) {
    findings.push_back({to_string(process) + " uses another URL: " + url,
                        state.program + " --lcm-url '" + url + "'"});
  }
  if (broken || !state.heard_urls.empty()) return findings;
  const Route* route = route_to(state.routes, state.url.group);
  const std::string works =
      state.self_test == true ? "multicast works on this host (a probe came back): " : "";
  findings.push_back({works + "nobody publishes on " + state.url.text(), ""});
  if (route != nullptr && route->device != "lo") {
    findings.push_back(
        {"a publisher on another host reaches this one only with a ttl above 0 (0 is the default); "
         "start it with",
         "LCM_DEFAULT_URL='" + state.url.text() + "?ttl=1'"});
  } else if (state.interfaces.size() > 1) {
    const auto other = std::find_if(state.interfaces.begin(), state.interfaces.end(),
                                    [](const Interface& i) { return i.name != "lo" && i.up; });
    if (other != state.interfaces.end()) {
      findings.push_back(
          {"multicast stays on this host (its route is lo): messages from other hosts do not "
           "arrive, unless it uses " +
               other->name + " and those hosts use ttl=1",
           "sudo ip route add " + ip_text(state.url.group) + "/32 dev " + other->name});
    }
  }
  return findings;
}

}  // namespace marco::diagnosis
