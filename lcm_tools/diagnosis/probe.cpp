#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>

#include "lcm_tools/diagnosis/host.hpp"
#include "lcm_tools/diagnosis/listening_socket.hpp"

namespace marco::diagnosis {

Prober::Prober() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0)
    throw std::runtime_error(std::string("cannot open a socket: ") + std::strerror(errno));
  sockaddr_in any = {};
  any.sin_family = AF_INET;
  socklen_t size = sizeof any;
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&any), size) == 0 &&
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&any), &size) == 0) {
    port_ = ntohs(any.sin_port);
  }
  const unsigned char stay = 0;
  ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &stay, sizeof stay);
}

Prober::~Prober() { ::close(socket_); }

bool Prober::comes_back(const UdpUrl& url, std::string& error) {
  std::unique_ptr<ListeningSocket> listener;
  try {
    listener = std::make_unique<ListeningSocket>(url, 1 << 16);
  } catch (const std::runtime_error& failure) {
    error = failure.what();
    return false;
  }
  if (!listener->join(error)) return false;
  std::array<uint8_t, 32> bytes = {'L', 'C', '0', '2'};
  const uint32_t number = htonl(sequence_++);
  std::memcpy(bytes.data() + 4, &number, 4);
  std::memcpy(bytes.data() + 8, "LCM_SELF_TEST", 14);
  sockaddr_in group = {};
  group.sin_family = AF_INET;
  group.sin_addr.s_addr = htonl(url.group);
  group.sin_port = htons(url.port);
  if (::sendto(socket_, bytes.data(), 22, 0, reinterpret_cast<const sockaddr*>(&group),
               sizeof group) < 0) {
    error = std::strerror(errno);
    return false;
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
  while (std::chrono::steady_clock::now() < end) {
    pollfd wait = {listener->descriptor(), POLLIN, 0};
    if (::poll(&wait, 1, 50) <= 0) continue;
    sockaddr_in from = {};
    socklen_t size = sizeof from;
    std::array<uint8_t, 64> received;
    if (::recvfrom(listener->descriptor(), received.data(), received.size(), MSG_DONTWAIT,
                   reinterpret_cast<sockaddr*>(&from), &size) > 0 &&
        ntohs(from.sin_port) == port_) {
      return true;
    }
  }
  return false;
}

namespace {

// The value of LCM_DEFAULT_URL in a process's environment; "" when unset or not ours to read.
std::string lcm_url_of(int pid) {
  const std::string environment = read_text("/proc/" + std::to_string(pid) + "/environ");
  static constexpr std::string_view kName = "LCM_DEFAULT_URL=";
  for (std::size_t at = 0; at < environment.size();) {
    const std::string_view entry(environment.c_str() + at);
    if (entry.starts_with(kName)) return std::string(entry.substr(kName.size()));
    at += entry.size() + 1;
  }
  return {};
}

std::vector<Interface> interfaces() {
  std::vector<Interface> result;
  const int asker = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  struct if_nameindex* names = if_nameindex();
  for (const struct if_nameindex* name = names; name != nullptr && name->if_name != nullptr;
       ++name) {
    ifreq request = {};
    std::strncpy(request.ifr_name, name->if_name, IFNAMSIZ - 1);
    if (::ioctl(asker, SIOCGIFFLAGS, &request) != 0) continue;
    result.push_back({name->if_name, (request.ifr_flags & IFF_UP) != 0,
                      (request.ifr_flags & IFF_MULTICAST) != 0});
  }
  if_freenameindex(names);
  ::close(asker);
  return result;
}

bool is_lcm(std::span<const uint8_t> payload) {
  return payload.size() > 8 && (std::memcmp(payload.data(), "LC02", 4) == 0 ||
                                std::memcmp(payload.data(), "LC03", 4) == 0);
}

// With root's rights: every multicast datagram on the wire for `milliseconds`.
bool sniff(const UdpUrl& own, std::set<std::string>& urls, int milliseconds) {
  const int raw = ::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP));
  if (raw < 0) return false;
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(milliseconds);
  std::array<uint8_t, 256> bytes;
  while (std::chrono::steady_clock::now() < end) {
    pollfd wait = {raw, POLLIN, 0};
    if (::poll(&wait, 1, 20) <= 0) continue;
    const ssize_t length = ::recv(raw, bytes.data(), bytes.size(), MSG_DONTWAIT);
    const std::size_t header = std::size_t{4} * (bytes[0] & 15U);
    constexpr uint8_t kUdp = 17;
    if (length < 28 || bytes[9] != kUdp || header < 20 ||
        header + 8 >= static_cast<std::size_t>(length))
      continue;
    UdpUrl url;
    url.group = static_cast<uint32_t>(bytes[16]) << 24U | static_cast<uint32_t>(bytes[17]) << 16U |
                static_cast<uint32_t>(bytes[18]) << 8U | bytes[19];
    url.port = static_cast<uint16_t>(bytes[header + 2] << 8U | bytes[header + 3]);
    const std::span<const uint8_t> payload(bytes.data() + header + 8,
                                           static_cast<std::size_t>(length) - header - 8);
    if (url.group >> 28U == 14 && is_lcm(payload) && url.text() != own.text())
      urls.insert(url.text());
  }
  ::close(raw);
  return true;
}

// Without: listens for a moment wherever somebody on this host listens.
void listen_elsewhere(const UdpUrl& own, std::set<std::string>& urls) {
  std::vector<std::unique_ptr<ListeningSocket>> sockets;
  std::vector<pollfd> waits;
  std::vector<UdpUrl> tried;
  std::vector<uint32_t> groups = parse_joined_groups(read_text("/proc/net/igmp"));
  groups.push_back(UdpUrl().group);
  std::vector<uint16_t> ports = {UdpUrl().port};
  for (const UdpSocket& socket : parse_udp_sockets(read_text("/proc/net/udp")))
    ports.push_back(socket.local.port);
  for (const uint32_t group : groups) {
    for (const uint16_t port : ports) {
      UdpUrl url;
      url.group = group;
      url.port = port;
      const bool known = std::any_of(tried.begin(), tried.end(), [&](const UdpUrl& other) {
        return other.text() == url.text();
      });
      std::string error;
      if (known || url.text() == own.text() || sockets.size() >= 32) continue;
      tried.push_back(url);
      try {
        sockets.push_back(std::make_unique<ListeningSocket>(url, 1 << 16));
      } catch (const std::runtime_error&) {  // a port that is not shared: no LCM there
        tried.pop_back();
        continue;
      }
      sockets.back()->join(error);
      waits.push_back({sockets.back()->descriptor(), POLLIN, 0});
    }
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(400);
  while (!waits.empty() && std::chrono::steady_clock::now() < end) {
    ::poll(waits.data(), waits.size(), 50);
    for (std::size_t i = 0; i < waits.size(); ++i) {
      std::array<uint8_t, 16> bytes;
      const ssize_t length = ::recv(waits[i].fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (length > 0 && is_lcm({bytes.data(), static_cast<std::size_t>(length)}))
        urls.insert(tried[i].text());
    }
  }
}

// Whether LCM can listen on the port of `url`.
bool can_be_shared(const UdpUrl& url) {
  try {
    const ListeningSocket socket(url, 1 << 16);
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

void find_other_urls(const UdpUrl& own, NetworkState& state) {
  for (const int pid : running_pids()) {
    const std::string url = pid == getpid() ? "" : lcm_url_of(pid);
    if (url.empty() || state.other_urls.size() >= 3) continue;
    try {
      if (parse_udp_url(url).text() == own.text()) continue;
    } catch (const std::invalid_argument&) {  // another transport: worth naming as well
    }
    state.other_urls.push_back({{pid, command_name(pid)}, url});
  }
}

}  // namespace

NetworkState look_at_network(const UdpUrl& url, Prober& prober, int64_t heard_messages) {
  NetworkState state;
  state.url = url;
  state.heard_messages = heard_messages;
  state.rmem_max = std::atoll(read_text("/proc/sys/net/core/rmem_max").c_str());
  if (heard_messages > 0) return state;
  state.routes = parse_routes(read_text("/proc/net/route"));
  state.interfaces = interfaces();
  state.port_taken = !can_be_shared(url);
  if (!state.port_taken) state.self_test = prober.comes_back(url, state.self_test_error);
  std::set<std::string> urls;
  if (!sniff(url, urls, 400)) listen_elsewhere(url, urls);
  state.heard_urls.assign(urls.begin(), urls.end());
  if (urls.empty()) find_other_urls(url, state);
  return state;
}

}  // namespace marco::diagnosis
