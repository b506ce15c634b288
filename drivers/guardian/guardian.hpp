#pragma once

#include <future>
#include <memory>
#include <string>
#include <vector>

#include "drivers/base/order_gate.hpp"
#include "drivers/base/stop_latch.hpp"
#include "drivers/guardian/guardian_watch.hpp"
#include "drivers/transport/serial_stream.hpp"
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

/// The driver's companion process that stops its device when the driver hangs or dies, and keeps
/// the emergency stop of a base (docs/stopping.md). It knows no protocol: its driver gives it the
/// line, and the bytes that stop the device.
class Guardian {
 public:
  /// @param driver, beat  shared with it. @param emergency  of a base
  Guardian(FileHandle driver, GuardianBeat& beat, std::unique_ptr<EmergencyListener> emergency);

  /// Until the driver is gone and the device stopped.
  void run();

 private:
  void wait();
  void receive();
  void on_message(GuardianWord word, std::vector<uint8_t> bytes, FileHandle line);
  void on_driver_gone();
  void stop_device(int64_t now);
  void look_after_emergency();
  void say(GuardianWord word, const std::string& text = "") const;
  GuardianWatch::Driver seen() const;

  FileHandle driver_;
  GuardianBeat& beat_;
  GuardianWatch watch_;
  FileHandle line_;
  std::unique_ptr<EmergencyListener>
      emergency_;  ///< ends before the line: the next driver reads it
  std::vector<uint8_t> stop_bytes_;
};

}  // namespace marco::drivers
