#pragma once

#include <span>
#include <string>
#include <vector>

#include "drivers/transport/serial_stream.hpp"
#include "simulator/devices/transport/emulator.hpp"

struct pollfd;

namespace marco::drivers {

/// Runs an emulator in real time behind a pseudo-terminal or a TCP server, one client at a time. A
/// client of the pseudo-terminal sees a serial port; the emulator learns the baud rate that it
/// sets. Not thread-safe: one thread serves the ports of a simulator (serve_ports).
class EmulatorPort {
 public:
  /// @param emulator outlives the port.
  /// @param link_path  a symbolic link to the terminal, so that its name stays the same; "" = none.
  /// Replaces an old link; refuses to replace any other file.
  /// @throws std::runtime_error when there is no pseudo-terminal, or another running simulator has
  /// made the link.
  static EmulatorPort pty(Emulator& emulator, const std::string& link_path = "");

  /// @param port on this host only (127.0.0.1); 0 = any free one, see address().
  /// @throws std::runtime_error when it is taken.
  static EmulatorPort tcp(Emulator& emulator, int port);

  EmulatorPort(EmulatorPort&&) = default;
  EmulatorPort& operator=(EmulatorPort&&) = delete;
  ~EmulatorPort();

  /// For open_stream: the link, the terminal, or tcp:127.0.0.1:PORT.
  const std::string& address() const { return address_; }
  bool connected() const { return connected_; }

  /// Pulls the plug: the client loses its line, the port's name disappears.
  void unplug();
  /// Puts it back under the same link or TCP port (without a link a terminal may change its name).
  void plug_in();

  /// The steps of serve_ports: what to wait for, until when, and the work then.
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
};

/// Waits for the next event of any port, `longest` at most, and handles it.
void serve_ports(std::span<EmulatorPort*> ports, Duration longest);

}  // namespace marco::drivers
