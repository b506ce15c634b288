#include "lcm_tools/diagnosis/host.hpp"

#include <arpa/inet.h>
#include <dirent.h>
#include <ifaddrs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

namespace marco::diagnosis {
namespace {

namespace fs = std::filesystem;

std::string base_name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

std::set<uint32_t> own_addresses() {
  std::set<uint32_t> result;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return result;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address = {};
    std::memcpy(&address, entry->ifa_addr, sizeof address);
    result.insert(ntohl(address.sin_addr.s_addr));
  }
  freeifaddrs(list);
  return result;
}

}  // namespace

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<int> running_pids() {
  std::vector<int> pids;
  std::error_code error;
  for (fs::directory_iterator entry("/proc", error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    int pid = 0;
    const auto [end, bad] = std::from_chars(name.data(), name.data() + name.size(), pid);
    if (bad == std::errc() && end == name.data() + name.size()) pids.push_back(pid);
  }
  return pids;
}

std::string command_name(int pid) {
  const std::string line = read_text("/proc/" + std::to_string(pid) + "/cmdline");
  std::vector<std::string> words;
  for (std::size_t at = 0; at < line.size() && words.size() < 8;) {
    words.emplace_back(line.c_str() + at);
    at += words.back().size() + 1;
  }
  if (words.empty()) {
    std::string name = read_text("/proc/" + std::to_string(pid) + "/comm");
    return name.substr(0, name.find('\n'));
  }
  std::string name = base_name(words[0]);
  for (const char* interpreter : {"python", "java", "bash", "sh", "perl", "ruby", "node"}) {
    if (!name.starts_with(interpreter)) continue;
    const auto script = std::find_if(words.begin() + 1, words.end(), [](const std::string& word) {
      return !word.starts_with("-");
    });
    if (script != words.end()) name += " " + base_name(*script);
    break;
  }
  return name;
}

// When a process began, in clock ticks since the boot; the 22nd field, counted behind the name.
uint64_t start_ticks(int pid) {
  constexpr int kFieldsBetween = 19;
  const std::string stat = read_text("/proc/" + std::to_string(pid) + "/stat");
  const std::size_t name_end = stat.rfind(") ");
  if (name_end == std::string::npos) return std::numeric_limits<uint64_t>::max();
  std::istringstream fields(stat.substr(name_end + 2));
  std::string skipped;
  for (int i = 0; i < kFieldsBetween; ++i) fields >> skipped;
  uint64_t ticks = 0;
  return fields >> ticks ? ticks : std::numeric_limits<uint64_t>::max();
}

std::map<uint64_t, Process> owners_of(const std::set<uint64_t>& inodes) {
  std::map<uint64_t, Process> owners;
  std::map<uint64_t, uint64_t> began;  // by inode
  if (inodes.empty()) return owners;
  for (const int pid : running_pids()) {
    const std::string folder = "/proc/" + std::to_string(pid) + "/fd";
    DIR* directory = opendir(folder.c_str());
    if (directory == nullptr) continue;
    while (const dirent* entry = readdir(directory)) {
      std::array<char, 64> target = {};
      const ssize_t length =
          readlinkat(dirfd(directory), entry->d_name, target.data(), target.size() - 1);
      constexpr std::string_view kSocket = "socket:[";
      if (length <= 0 || !std::string_view(target.data()).starts_with(kSocket)) continue;
      uint64_t inode = 0;
      std::from_chars(target.data() + kSocket.size(), target.data() + length, inode);
      if (!inodes.contains(inode)) continue;
      // A child may share its parent's socket: the parent, which began earlier, counts. Numbers of
      // processes wrap round and tell nothing.
      const uint64_t ticks = start_ticks(pid);
      if (owners.contains(inode) && began[inode] <= ticks) continue;
      owners[inode] = {pid, command_name(pid)};
      began[inode] = ticks;
    }
    closedir(directory);
  }
  return owners;
}

std::map<Address, Process> find_publishers(const std::vector<Address>& senders) {
  const std::vector<UdpSocket> sockets = parse_udp_sockets(read_text("/proc/net/udp"));
  std::set<uint32_t> own = own_addresses();
  own.insert(0);  // what the kernel writes when the loopback route names no source
  std::map<Address, uint64_t> inode_of_sender;
  std::map<Address, Process> publishers;
  for (const Address& sender : senders) {
    if (!own.contains(sender.ip)) {
      publishers[sender] = {-1, "host " + ip_text(sender.ip)};
      continue;
    }
    for (const UdpSocket& socket : sockets) {
      const bool same = socket.local.port == sender.port &&
                        (socket.local.ip == 0 || socket.local.ip == sender.ip);
      if (same) inode_of_sender[sender] = socket.inode;
    }
  }
  std::set<uint64_t> inodes;
  for (const auto& [sender, inode] : inode_of_sender) inodes.insert(inode);
  const std::map<uint64_t, Process> owners = owners_of(inodes);
  for (const auto& [sender, inode] : inode_of_sender) {
    if (const auto found = owners.find(inode); found != owners.end())
      publishers[sender] = found->second;
  }
  return publishers;
}

std::vector<Listener> find_listeners(uint16_t port, uint64_t own_inode) {
  std::vector<Listener> listeners;
  std::vector<uint64_t> found;
  std::set<uint64_t> inodes;
  for (const UdpSocket& socket : parse_udp_sockets(read_text("/proc/net/udp"))) {
    if (socket.local.port != port) continue;
    listeners.push_back({{}, socket.drops, socket.inode == own_inode});
    found.push_back(socket.inode);
    inodes.insert(socket.inode);
  }
  const std::map<uint64_t, Process> owners = owners_of(inodes);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (const auto owner = owners.find(found[i]); owner != owners.end())
      listeners[i].process = owner->second;
  }
  return listeners;
}

}  // namespace marco::diagnosis
