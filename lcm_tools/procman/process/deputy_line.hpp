#pragma once

#include <optional>
#include <string>

#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/keeper_message.hpp"

namespace marco::procman {

/// A keeper's end of the line to its deputy: the one that started it, or a later one that found its
/// socket. A deputy too busy to read does not delay the command: messages that it must get are kept
/// until they can be sent.
class DeputyLine {
 public:
  /// @param deputy SOCK_SEQPACKET. @param socket_path where a later deputy finds this keeper.
  DeputyLine(Descriptor deputy, std::string socket_path);
  ~DeputyLine();
  DeputyLine(const DeputyLine&) = delete;
  DeputyLine& operator=(const DeputyLine&) = delete;

  /// Waits for the first message, which must be "run". @throws std::runtime_error.
  KeeperMessage await_run() const;
  /// Opens the socket for later deputies. @throws std::runtime_error.
  void listen();

  int fd() const { return deputy_.get(); }
  int listener_fd() const { return listener_.get(); }
  bool is_open() const { return deputy_.is_open(); }
  /// Whether a message waits to be sent.
  bool owes() const { return is_open() && (owes_state_ || owes_ended_); }

  /// Takes a caller of the same user in the place of the deputy. @returns whether there was one.
  bool accept();
  /// None when there is no message, or the deputy is gone.
  std::optional<KeeperMessage> receive();

  void owe_state() { owes_state_ = true; }
  void owe_ended() { owes_ended_ = true; }
  /// Sends what is owed, "state" before "ended", as far as the deputy takes it.
  void send_owed(KeeperMessage& state);
  /// @returns whether the deputy took it.
  bool send(const char* kind, KeeperMessage& state);

 private:
  Descriptor deputy_;
  Descriptor listener_;
  std::string socket_path_;
  bool owes_state_ = false;
  bool owes_ended_ = false;
};

}  // namespace marco::procman
