#pragma once

#include <memory>
#include <vector>

#include "drivers/guardian/emergency_listener.hpp"
#include "drivers/guardian/guardian_watch.hpp"
#include "drivers/transport/serial_stream.hpp"

namespace marco::drivers {

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
