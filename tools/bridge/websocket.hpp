#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace marco::bridge {

struct WebSocketUrl {
  std::string host, port, path;
};
/// "ws://HOST[:PORT][/PATH]"; port 8765 and path "/" where they are left out.
/// @throws std::invalid_argument for another scheme or form.
WebSocketUrl parse_websocket_url(const std::string& url);

/// A client that connects, and connects again a second after each failure. One thread: handlers run
/// within step().
class WebSocketClient {
 public:
  struct Handlers {
    std::function<void(const std::string& subprotocol)> opened;
    std::function<void(std::string_view)> text;
    std::function<void(std::span<const uint8_t>)> binary;
    /// Also after a connection that failed. @param why  for a person
    std::function<void(const std::string& why)> closed;
  };

  /// @param subprotocols  offered, as the header says them
  WebSocketClient(WebSocketUrl url, std::string subprotocols, Handlers handlers);
  ~WebSocketClient();

  /// Waits until the socket has something to do, or `other` (a file descriptor) can be read, or the
  /// time is over, and handles what the socket has.
  void step(int other, int timeout_ms);

  /// Queued; nothing where no connection is open.
  void send_text(std::string text);
  /// @returns false, and sends nothing, while too much waits to be sent.
  bool send_binary(std::vector<uint8_t> message);
  bool is_open() const;

 private:
  class Connection;
  struct State;
  void connect();
  std::unique_ptr<State> state_;
};

}  // namespace marco::bridge
