#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace marco::relay {

/// "robot:7700", "10.0.0.5:7700", "[fe80::1]:7700", or "7700" for this host.
struct Endpoint {
  std::string host = "127.0.0.1";
  std::string port;
};
/// @throws std::invalid_argument naming what is wrong.
Endpoint parse_endpoint(const std::string& text);
std::string to_string(const Endpoint& endpoint);

/// A TCP socket that never blocks. A peer that is gone without a word is noticed within about ten
/// seconds (keepalive, user timeout).
class TcpSocket {
 public:
  TcpSocket() = default;
  explicit TcpSocket(int descriptor);
  ~TcpSocket();
  TcpSocket(TcpSocket&& other) noexcept;
  TcpSocket& operator=(TcpSocket&& other) noexcept;
  TcpSocket(const TcpSocket&) = delete;
  TcpSocket& operator=(const TcpSocket&) = delete;

  /// Waits for connections. @throws std::runtime_error naming the endpoint.
  static TcpSocket listen(const Endpoint& endpoint);
  /// Begins to connect; writable() when it is done or failed. @throws std::runtime_error where the
  /// host has no address.
  static TcpSocket connect(const Endpoint& endpoint);

  /// Of a listening socket: who came; not open where nobody did.
  TcpSocket accept() const;

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  void close();

  /// @returns bytes, 0 where there is nothing to do now. @throws std::runtime_error when the
  /// connection ended, saying how.
  std::size_t read(std::span<uint8_t> into) const;
  std::size_t write(std::span<const char> bytes) const;

 private:
  int descriptor_ = -1;
};

}  // namespace marco::relay
