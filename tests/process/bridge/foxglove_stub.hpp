#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace marco::testing {

/// A robot's foxglove_bridge for one client at a time, on a free port of this host.
class FoxgloveStub {
 public:
  FoxgloveStub();
  ~FoxgloveStub();

  int port() const;
  /// Waits for a client, for ten seconds at most, and grants it a subprotocol.
  /// @returns the subprotocols that were offered; "" nobody came.
  std::string accept(const std::string& subprotocol);
  void hang_up();

  void send_text(const std::string& text);
  void send_binary(const std::vector<uint8_t>& message);
  struct Message {
    bool is_text = false;
    std::string bytes;
  };
  /// The oldest message of the client that was not taken yet; waits for `seconds` at most.
  std::optional<Message> receive(double seconds);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace marco::testing
