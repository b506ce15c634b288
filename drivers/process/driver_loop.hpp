#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/process/line_watch.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"

namespace marco::drivers {

/// One device as long as its line stays open; made anew at each opening.
class DeviceSession {
 public:
  virtual ~DeviceSession() = default;

  /// Reads, decides, writes and publishes; returns after at most about 100 ms, also when the device
  /// is silent. @throws StreamLost when the line is gone.
  virtual void step() = 0;

  /// One line for a person: what the device does, its trouble first.
  virtual std::string state() const = 0;

  /// Whether the device answers: what it sends is understood.
  virtual bool answers() const = 0;

  /// Leaves the device quiet (motors off) at an orderly end. @throws StreamLost.
  virtual void stop() {}
};

struct DriverLoopOptions {
  std::string process;  ///< "marco-sick"
  std::string address;  ///< for open_stream
  LineSettings line;    ///< at opening
  /// Opens the line instead of open_stream(address, line), where there is more to it.
  std::function<std::unique_ptr<ByteStream>()> open;
  /// Called about once a second, with or without a device: SENSOR_INFO.
  std::function<void()> every_second;
};

/// The life of a driver process: opens the device, steps its session, says once a second on
/// PROCESS_STATUS how it is, and when the line is lost tries it again every second. A device that
/// is not there or does not answer is told of once, with what to do, and again when that changes.
/// When the host's clock was set, line and session are begun again.
class DriverLoop {
 public:
  using StartSession = std::function<std::unique_ptr<DeviceSession>(ByteStream&)>;

  /// @param bus, drops  outlive the loop.
  DriverLoop(process::Bus& bus,
             process::DropCounter& drops,
             DriverLoopOptions options,
             StartSession start_session);

  /// Returns when `stop` says so (process::stop_requested), after DeviceSession::stop.
  /// @throws std::invalid_argument when the address makes no sense or another process holds it.
  void run(const std::function<bool()>& stop);

  /// For the session: how long a message took from its last byte to its publication.
  void add_latency(double seconds) { status_.add_latency(seconds); }

 private:
  void tick(const std::string& state);
  void run_session(ByteStream& stream, const std::function<bool()>& stop);
  void tell_trouble(const LineWatch& line, LineWatch::Trouble trouble);
  void wait_to_reopen(const std::string& why, const std::function<bool()>& stop);

  DriverLoopOptions options_;
  StartSession start_session_;
  process::StatusPublisher status_;
  std::chrono::steady_clock::time_point last_second_;
  std::string told_loss_;  ///< since the line was last open
  LineWatch::Trouble told_trouble_ = LineWatch::Trouble::none;
};

}  // namespace marco::drivers
