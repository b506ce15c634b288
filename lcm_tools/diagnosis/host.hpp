#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/diagnosis/network.hpp"

/// The host we run on: /proc, interfaces, probes. Linux only.
namespace marco::diagnosis {

/// A whole small file of /proc; "" when it cannot be read.
std::string read_text(const std::string& path);
std::vector<int> running_pids();
/// "marco-slam"; of an interpreter also its script: "python3 drive.py".
std::string command_name(int pid);

/// The processes that own sockets, by inode. Sockets of other users' processes stay unknown without
/// root's rights. One walk over /proc for all of them.
std::map<uint64_t, Process> owners_of(const std::set<uint64_t>& inodes);

/// The owners of the sending sockets: by port on this host, by address for remote ones.
std::map<Address, Process> find_publishers(const std::vector<Address>& senders);

/// Sockets bound to `port`, with their owners.
std::vector<Listener> find_listeners(uint16_t port, uint64_t own_inode);

/// Sends LCM_SELF_TEST to a URL from its own port. Throws std::runtime_error when there are no
/// sockets left.
class Prober {
 public:
  Prober();
  ~Prober();
  Prober(const Prober&) = delete;
  Prober& operator=(const Prober&) = delete;

  uint16_t port() const { return port_; }  ///< the receiver ignores its messages
  /// Whether a message to `url` comes back to a listener of this process within 200 ms.
  /// @param error the system's message when it could not be sent
  bool comes_back(const UdpUrl& url, std::string& error);

 private:
  int socket_ = -1;
  uint16_t port_ = 0;
  uint32_t sequence_ = 0;
};

/// The input of diagnose(). Takes up to a second if no message arrives.
NetworkState look_at_network(const UdpUrl& url, Prober& prober, int64_t heard_messages);

}  // namespace marco::diagnosis
