#pragma once

#include <optional>
#include <utility>

#include "drivers/p2os/codec.hpp"
#include "drivers/transport/baud_search.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::drivers::p2os {

/// The driver's side of the robot's line: finds its speed, synchronizes, pulses so that the robot's
/// watchdog does not stop it, and collects what is to be sent.
class Session {
 public:
  void on_connection(bool connected, Utime now);
  void restart(Utime now);
  bool connected() const { return connected_; }
  bool is_open() const { return sync_ == 3; }
  const RobotName& name() const { return name_; }
  int baud() const { return search_.current(); }
  /// The speed that the line shall have from now on; nothing: as it is.
  std::optional<int> take_line_speed() { return std::exchange(speed_due_, std::nullopt); }

  std::vector<Bytes> receive(std::span<const uint8_t> bytes, Utime now);
  /// A packet that came before the session was open. @returns whether it opened the session.
  bool on_sync(const Bytes& payload, Utime now);

  void say(CommandId id, std::optional<int> value = std::nullopt);
  void send(const Bytes& packets) {
    to_send_.insert(to_send_.end(), packets.begin(), packets.end());
  }
  /// Says what is due. @returns false when the robot has fallen silent.
  bool advance(Utime now);
  /// Appends what was said; drops it when the line is gone.
  void flush(Utime now, std::vector<uint8_t>& out);
  void shut_down(std::vector<uint8_t>& out);

  void reject() { ++bad_packets_; }
  int64_t bad_packets() const { return parser_.bad_checksums() + bad_packets_; }

 private:
  PacketParser parser_;
  BaudSearch search_{kBaud, {38'400, 19'200, 57'600, 115'200}};
  std::optional<int> speed_due_;
  bool heard_ = false;  ///< a packet at this speed, ever: the robot has it for its life
  Bytes to_send_;
  bool connected_ = false;
  int sync_ = 0;  ///< the SYNC to send next; 3 = open
  RobotName name_;
  Utime next_sync_;
  Utime last_sent_;
  Utime last_packet_;
  int64_t bad_packets_ = 0;
};

}  // namespace marco::drivers::p2os
