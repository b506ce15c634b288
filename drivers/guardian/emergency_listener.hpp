#pragma once

#include <future>
#include <string>

#include "drivers/base/order_gate.hpp"
#include "drivers/base/stop_latch.hpp"
#include "lcm_tools/process/lcm_bus.hpp"

namespace marco::drivers {

/// A guardian's ears: EMERGENCY_STOP, of which it keeps the base's latch on the disk, and
/// BASE_STATUS while the driver cannot say it.
class EmergencyListener {
 public:
  /// @throws as LcmBus.
  EmergencyListener(const std::string& base, const std::string& lcm_url);
  /// Waits until the latch is on the disk.
  ~EmergencyListener();
  EmergencyListener(const EmergencyListener&) = delete;
  EmergencyListener& operator=(const EmergencyListener&) = delete;

  /// To wait for; -1 when the network is gone.
  int descriptor();
  /// Whether messages wait here already.
  bool waits() const { return bus_.waiting(); }
  /// @returns whether somebody said stop.
  bool receive();
  /// Writes the latch where it changed, without waiting for the disk. @returns what went wrong; "".
  std::string keep();
  /// Publishes the status of a base that its driver has left alone, twice a second.
  void publish_hung(const std::string& note);

 private:
  process::LcmBus bus_;
  process::DropCounter drops_;
  std::string base_;
  StopLatch latch_;
  OrderGate gate_;
  bool heard_stop_ = false;
  bool is_open_ = true;
  bool must_save_ = false;
  std::future<std::string> saving_;
  Utime published_;
};

}  // namespace marco::drivers
