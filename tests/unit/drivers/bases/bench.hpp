#pragma once

#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "simulator/devices/transport/emulator.hpp"

namespace marco::drivers::testing {

/// A driver and an emulator on one line in simulated time, stepped by half a millisecond. `Driver`
/// has on_connection, receive and advance (BaseDriver, PanTiltDriver ...).
template <class Driver>
class Bench {
 public:
  Bench(Driver& driver, Emulator& emulator, int baud)
      : driver_(driver), emulator_(emulator), baud_(baud) {
    plug(true);
  }

  void plug(bool in) {
    plugged_ = in;
    emulator_.on_connection(in, now_);
    driver_.on_connection(in, now_ + host_ahead);
  }

  void step() {
    now_ = now_ + Duration::from_us(500);
    std::vector<uint8_t> from_device, from_driver;
    emulator_.advance(now_, from_device);
    if (spoil) spoil(from_device);
    if (plugged_) waiting_.insert(waiting_.end(), from_device.begin(), from_device.end());
    if (!frozen) {
      const std::vector<uint8_t> received = std::exchange(waiting_, {});
      if (!received.empty()) driver_.receive(received, now_ + host_ahead);
      if constexpr (requires { driver_.take_line_speed(); }) {
        baud_ = driver_.take_line_speed().value_or(baud_);
      }
      driver_.advance(now_ + host_ahead, from_driver);
    }
    if (!from_driver.empty()) sent_by_size[from_driver.size()] = from_driver;
    for (const uint8_t byte : from_driver) on_line_.push_back(byte);
    // At 9600 baud a byte takes about two steps; faster lines deliver at once.
    budget_ += baud_ * 0.0005 / 10.0;
    std::vector<uint8_t> arrived;
    while (!on_line_.empty() && budget_ >= 1.0) {
      arrived.push_back(on_line_.front());
      on_line_.erase(on_line_.begin());
      budget_ -= 1.0;
    }
    if (on_line_.empty()) budget_ = 0.0;
    if (plugged_ && !deaf && !arrived.empty()) emulator_.receive(arrived, baud_, now_);
    if (each_step) each_step(now_);
  }

  /// Bytes of somebody else on the line, behind what the driver has sent of late.
  void inject(std::span<const uint8_t> bytes) {
    on_line_.insert(on_line_.end(), bytes.begin(), bytes.end());
  }

  void run(double seconds) {
    const Utime end = now_ + Duration::from_seconds(seconds);
    while (now_ < end) step();
  }

  /// @returns whether `done` came true within the time.
  bool run_until(double seconds, const std::function<bool()>& done) {
    const Utime end = now_ + Duration::from_seconds(seconds);
    while (now_ < end && !done()) step();
    return done();
  }

  Utime now() const { return now_; }
  Utime host_now() const { return now_ + host_ahead; }  ///< by the driver's clock

  std::function<void(std::vector<uint8_t>&)> spoil;  ///< changes bytes on their way to the driver
  std::function<void(Utime)> each_step;
  std::map<std::size_t, std::vector<uint8_t>> sent_by_size;  ///< of the driver's steps, the last
  Duration host_ahead;  ///< the driver's clock is set so much ahead of now()
  bool deaf = false;    ///< the device hears nothing
  bool frozen = false;  ///< the driver's process stands still; bytes wait for it

 private:
  Driver& driver_;
  Emulator& emulator_;
  int baud_;
  bool plugged_ = true;
  double budget_ = 0.0;
  std::vector<uint8_t> on_line_;
  std::vector<uint8_t> waiting_;  ///< for the driver
  Utime now_ = Utime::from_us(1'000'000'000);
};

}  // namespace marco::drivers::testing
