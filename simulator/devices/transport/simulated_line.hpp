#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "drivers/transport/byte_stream.hpp"
#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers {

/// An emulator and the client's end of its line in one thread and in simulated time, for tests.
/// Time passes only in read() and wait(). The plug can be pulled and bytes tampered with.
class SimulatedLine {
 public:
  using Tamper = std::function<void(std::vector<uint8_t>&)>;

  /// @param emulator outlives the line.
  /// @param has_baud  false for a line without a speed (TCP).
  explicit SimulatedLine(Emulator& emulator,
                         bool has_baud = true,
                         Utime start = Utime::from_us(1'000'000'000'000));

  /// The client's end; at most one at a time, and outlived by the line.
  /// @throws StreamLost while unplugged.
  std::unique_ptr<ByteStream> open(const LineSettings& line);

  Utime now() const { return now_; }
  void wait(Duration duration);
  /// Runs `action` when simulated time reaches `when`.
  void at(Utime when, std::function<void()> action);
  void forget_actions() { actions_.clear(); }
  /// The device stalls: what it would send until then comes at that time.
  void hold_up(Utime until) { held_until_ = until; }
  void unplug();
  void plug_in() { plugged_ = true; }
  void set_tamper_to_client(Tamper tamper) { tamper_to_client_ = std::move(tamper); }
  void set_tamper_to_device(Tamper tamper) { tamper_to_device_ = std::move(tamper); }

 private:
  friend class SimulatedStream;
  void step_towards(Utime limit);
  void disconnect();

  Emulator& emulator_;
  bool has_baud_;
  Utime now_;
  Utime held_until_;
  bool plugged_ = true;
  bool connected_ = false;
  int session_ = 0;  ///< of the open stream: one from before an unplugging is dead
  std::vector<uint8_t> to_client_;
  std::vector<std::pair<Utime, std::function<void()>>> actions_;
  Tamper tamper_to_client_;
  Tamper tamper_to_device_;
};

}  // namespace marco::drivers
