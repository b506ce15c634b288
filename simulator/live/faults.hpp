#pragma once

#include <deque>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "drivers/transport/emulator.hpp"
#include "lcm_tools/base/options.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco::sim {

/// What can go wrong with a device of the simulated robot.
enum class FaultKind {
  off,           ///< its cable is cut: it neither hears nor speaks
  stuck,         ///< it goes on telling the same: a laser's ranges, an IMU's rates; wheels and
                 ///< pan-tilt count but do not move
  garbage,       ///< three of ten bytes that it sends are others
  slow,          ///< what it sends comes half a second late
  wrong,         ///< a constant offset: laser 0.2 m, IMU 3 deg/s, left wheel 10 %, tilt 2 deg
  intermittent,  ///< off for 0.4 s of each second
  unplugged,     ///< its port is gone
};

/// @throws std::invalid_argument naming what is known.
FaultKind fault_kind_named(const std::string& name);
/// The list of `marco-sim --faults`.
std::string describe_faults();

struct FaultSpec {
  std::string device;
  std::string kind = "off";
  double start_s = 0.0;  ///< from the start of the simulator, or from the order's arrival
  double duration_s = 5.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("kind", kind);
    v("start_s", start_s, kNotNegative);
    v("duration_s", duration_s, kPositive);
  }
};

/// A script of faults (`marco-sim --fault-script FILE`).
struct FaultScript {
  std::vector<FaultSpec> faults;

  template <class Visitor>
  void visit(Visitor& v) {
    v("faults", faults);
  }
};

/// Which device suffers from what, and when. One thread.
class FaultBoard {
 public:
  explicit FaultBoard(std::vector<std::string> devices = {}) : devices_(std::move(devices)) {}
  void add_device(const std::string& device) { devices_.push_back(device); }

  /// @param now when start_s counts from. Kind "none" ends all faults of the device.
  /// @throws std::invalid_argument for a device or kind that is not known, or times that make no
  /// sense.
  void add(const FaultSpec& spec, Utime now);

  bool has(const std::string& device, FaultKind kind, Utime now) const;
  /// "laser off, imu wrong"; "" when all is well.
  std::string state(Utime now) const;

 private:
  struct Fault {
    std::string device;
    FaultKind kind;
    Utime from, until;
  };
  std::vector<std::string> devices_;
  std::vector<Fault> faults_;
};

/// A device whose line suffers: off, garbage, slow, intermittent. What it measures (stuck, wrong)
/// is the robot's to falsify.
class FaultyEmulator final : public drivers::Emulator {
 public:
  /// @param inner, board  outlive it.
  FaultyEmulator(drivers::Emulator& inner, const FaultBoard& board, std::string device)
      : inner_(inner), board_(board), device_(std::move(device)) {}

  void receive(std::span<const uint8_t> bytes, int baud, Utime now) override;
  void advance(Utime now, std::vector<uint8_t>& out) override;
  Utime next_event() const override;
  void on_connection(bool connected, Utime now) override;

 private:
  bool silent(Utime now) const;
  void spoil(std::vector<uint8_t>& bytes);

  drivers::Emulator& inner_;
  const FaultBoard& board_;
  std::string device_;
  std::mt19937 random_{1};
  std::deque<std::pair<Utime, std::vector<uint8_t>>> late_;
};

}  // namespace marco::sim
