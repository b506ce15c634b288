#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/keeper_message.hpp"

namespace marco::procman {

/// A deputy's end of the line to one keeper.
class KeeperLink {
 public:
  /// Starts a keeper and sends it the command to run. @throws std::runtime_error, also for an exec
  /// string of more than about 100 kB.
  static KeeperLink spawn(const std::string& program,
                          const std::string& socket_path,
                          const KeeperMessage& run);

  /// Calls a keeper that an earlier deputy started. @returns none when nobody answers there.
  static std::optional<KeeperLink> connect(const std::string& socket_path);

  int fd() const { return socket_.get(); }

  void send(const KeeperMessage& message) const;

  /// What has come, without waiting. @param closed set when the keeper is gone.
  std::vector<KeeperMessage> receive(bool& closed);

 private:
  explicit KeeperLink(Descriptor socket) : socket_(std::move(socket)) {}

  Descriptor socket_;
};

}  // namespace marco::procman
