#pragma once

#include <span>
#include <string>
#include <vector>

#include "drivers/transport/emulator.hpp"
#include "drivers/transport/serial_stream.hpp"

struct pollfd;

namespace marco::drivers {

/// Runs an emulator in real time behind a pseudo-terminal or a TCP server, one client at a time. A
/// client of the pseudo-terminal sees a serial port; the speed it sets is told to the emulator.
/// Not thread-safe: the ports of a simulator are served by one thread (serve_ports).
class EmulatorPort {
 public:
  /// @param emulator outlives the port.
  /// @param link_path  a symbolic link made to the terminal, so that its name stays the same; "" =
  /// none. An old link there is replaced, a file that is no link is refused.
  /// @throws std::runtime_error when the system gives no pseudo-terminal, or another simulator that
  /// runs has made the link.
  static EmulatorPort pty(Emulator& emulator, const std::string& link_path = "");

  /// @param port on this host only (127.0.0.1); 0 = any free one, see address().
  /// @throws std::runtime_error when it is taken.
  static EmulatorPort tcp(Emulator& emulator, int port);

  EmulatorPort(EmulatorPort&&) = default;
  EmulatorPort& operator=(EmulatorPort&&) = delete;
  ~EmulatorPort();

  /// What a driver gives open_stream: the link or the terminal, or tcp:127.0.0.1:PORT.
  const std::string& address() const { return address_; }
  bool connected() const { return connected_; }
  /// Bytes the emulator sent that the client did not fetch in time.
  int64_t bytes_overrun() const { return bytes_overrun_; }

  /// Pulls the plug: the client loses its line and the port's name is gone.
  void unplug();
  /// Puts it back under the same link or TCP port (without a link a terminal may change its name).
  void plug_in();

  /// For serve_ports: what to wait for, until when, and what to do then.
  void add_waits(std::vector<pollfd>& waits) const;
  Utime next_event(Utime now) const;
  void service(Utime now);

 private:
  EmulatorPort(Emulator& emulator, std::string link_path, int tcp_port);
  void open_pty();
  void remove_link();
  void open_tcp_server();
  void look_for_client(Utime now);
  void change_connection(bool connected, Utime now);
  void read_client(Utime now);
  void write_client();

  Emulator* emulator_;
  std::string link_path_;
  int tcp_port_;  ///< -1 = a pseudo-terminal
  std::string address_;
  FileHandle master_;    ///< of the pseudo-terminal
  FileHandle claim_;     ///< of its link
  FileHandle listener_;  ///< of the TCP server
  FileHandle client_;    ///< of the TCP server
  bool connected_ = false;
  int client_baud_ = 0;
  std::vector<uint8_t> pending_;
  int64_t bytes_overrun_ = 0;
};

/// Waits until something is due at one of the ports, at most `longest`, and does it.
void serve_ports(std::span<EmulatorPort*> ports, Duration longest);

}  // namespace marco::drivers
