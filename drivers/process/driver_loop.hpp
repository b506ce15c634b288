#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/process/guardian_link.hpp"
#include "drivers/process/line_watch.hpp"
#include "drivers/transport/byte_stream.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/heartbeat.hpp"
#include "lcm_tools/process/status_publisher.hpp"

namespace marco::drivers {

/// One device while its line is open. A new session starts at each opening.
class DeviceSession {
 public:
  virtual ~DeviceSession() = default;

  /// Reads, decides, writes and publishes. Returns within about 100 ms, even when the device is
  /// silent. @throws StreamLost when the line is gone.
  virtual void step() = 0;

  /// One line for a person: what the device does, its trouble first.
  virtual std::string state() const = 0;

  /// Whether the device answers: its bytes are understood.
  virtual bool answers() const = 0;

  /// What stops the device now, also behind a packet that was sent in part; empty: nothing moves.
  /// For the guardian.
  virtual std::vector<uint8_t> stop_bytes() const { return {}; }

  /// This process stood still for so long, and the device was stopped: nothing may resume.
  virtual void on_hang(double /*seconds*/) {}

  /// Leaves the device quiet (motors off) at an orderly end. @throws StreamLost.
  virtual void stop() {}

  /// Seconds from a message's last byte to its publication, of each since the last call.
  std::vector<double> take_latencies_s() { return std::exchange(latencies_s_, {}); }

 protected:
  void add_latency(double seconds) { latencies_s_.push_back(seconds); }

 private:
  std::vector<double> latencies_s_;
};

struct DriverLoopOptions {
  std::string process;  ///< "marco-sick"
  std::string address;  ///< for open_stream
  LineSettings line;    ///< at opening
  /// Opens the line; empty: open_stream(address, line).
  std::function<std::unique_ptr<ByteStream>()> open;
  /// Called about once a second, with or without a device: SENSOR_INFO.
  std::function<void()> every_second;
  /// Of a device that moves: arguments of its guardian, which stops it when this process hangs for
  /// half a second or dies. Without a guardian the line is not opened. The loop has a heartbeat
  /// then.
  std::optional<std::vector<std::string>> guardian;
};

/// The main loop of a driver process. Opens the device, steps its session, publishes PROCESS_STATUS
/// once a second, and reopens a lost line every second. Logs once when a device is missing or does
/// not answer, with advice, and again when that changes. Restarts line and session when the host's
/// clock was set. A device that moves has a guardian (docs/stopping.md).
class DriverLoop {
 public:
  using StartSession = std::function<std::unique_ptr<DeviceSession>(ByteStream&)>;

  /// @param bus, drops  outlive the loop.
  DriverLoop(process::Bus& bus,
             process::DropCounter& drops,
             DriverLoopOptions options,
             StartSession start_session);

  /// Returns when `stop` returns true (process::stop_requested), after DeviceSession::stop.
  /// @throws std::invalid_argument for an invalid address, or one that another process holds.
  void run(const std::function<bool()>& stop);

 private:
  void tick(const std::string& state);
  std::unique_ptr<ByteStream> open();
  void run_session(ByteStream& stream, const std::function<bool()>& stop);
  void log_trouble(const LineWatch& line, LineWatch::Trouble trouble);
  void wait_to_reopen(const std::string& why, const std::function<bool()>& stop);

  DriverLoopOptions options_;
  StartSession start_session_;
  process::StatusPublisher status_;
  process::Heartbeat heartbeat_;
  std::optional<GuardianLink> guardian_;
  std::chrono::steady_clock::time_point last_second_;
  std::string logged_loss_;  ///< since the line was last open
  LineWatch::Trouble logged_trouble_ = LineWatch::Trouble::none;
};

}  // namespace marco::drivers
