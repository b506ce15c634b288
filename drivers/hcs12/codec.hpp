#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/transport/line_cutter.hpp"

/// The two boards of thesis B's robot: lines of a letter, decimal numbers and LF at 9600 baud.
/// There is no checksum: what does not read as its letter's form is nothing, the rest is for the
/// driver to find plausible.
namespace marco::drivers::hcs12 {

inline constexpr int kBaud = 9600;
inline constexpr int64_t kTickUs = 1024;  ///< the firmware's time; its texts call it 1 ms
inline constexpr double kTickS = kTickUs * 1e-6;
inline constexpr double kByteUs = 1e7 / 9600;       ///< of one byte on the line
inline constexpr double kSonarUnitUs = 16.0 / 3.0;  ///< 24 MHz / 128: round trip of a sonar pulse
inline constexpr uint32_t kNoEcho = 65535;

/// "a10\n", "k5 30 50\n". The firmware reads sixteen bits of each number.
std::string encode_command(char letter, std::span<const uint32_t> values);
std::string encode_command(char letter, std::initializer_list<uint32_t> values = {});

/// A line as the firmware reads it.
struct Command {
  static constexpr std::size_t kMaxValues = 20;
  char letter = '\0';
  std::size_t count = 0;  ///< numbers given; the array holds 0 beyond
  std::array<uint16_t, kMaxValues> values{};
};

/// The firmware's own reading of a line: no check of anything, each space begins the next number (a
/// space after the letter makes a zero), any other byte is a digit, sixteen bits wrap.
/// @param line without its LF; more than 20 numbers, which overrun the real board, are left out.
std::optional<Command> parse_command(std::string_view line);

/// The directions in which a motion command of the base turns its wheels.
struct WheelSigns {
  int left = 1;
  int right = 1;
};
/// Of a (ahead), r (back), i (left) and d (right); nothing for another letter.
std::optional<WheelSigns> wheel_signs(char letter);

/// Reply of the base's `l`.
struct WheelStatus {
  uint32_t left_clicks = 0;  ///< since the last a, r, i, d; never signed
  uint32_t right_clicks = 0;
  bool left_on = false;
  bool right_on = false;
  bool sonar_on = false;
};
std::string encode_wheel_status(const WheelStatus& status);
std::optional<WheelStatus> parse_wheel_status(std::string_view line);

/// Reply of `t`: 12 V, 24 V, 12 V of the motors, 24 V of the motors, in mV.
using BatteryMillivolts = std::array<uint32_t, 4>;
std::string encode_batteries(const BatteryMillivolts& millivolts);
std::optional<BatteryMillivolts> parse_batteries(std::string_view line);

/// What robot 2's converter makes of a battery, and back: mV = adc * factor / 10.
inline constexpr std::array<uint32_t, 4> kBatteryFactors{199, 374, 188, 375};
uint32_t battery_millivolts(std::size_t battery, uint32_t adc);
uint32_t battery_adc(std::size_t battery, double volts);

/// The manual writes the readings of `s` in one line, the listing one a line.
enum class SonarForm { one_line, line_each };
std::string encode_sonar(std::span<const uint32_t> times, SonarForm form);

/// Collects `expected` readings of `s` in either form.
class SonarCollector {
 public:
  void begin(std::size_t expected);
  /// @returns the readings when the last has come. A line that is no number spoils the collection.
  std::optional<std::vector<uint32_t>> push(std::string_view line);
  bool collecting() const { return collecting_; }

 private:
  std::size_t expected_ = 0;
  bool collecting_ = false;
  std::vector<uint32_t> times_;
};

/// 0 for kNoEcho. @param speed_of_sound_m_per_s 343 at 20 degrees
double sonar_range_m(uint32_t time_units, double speed_of_sound_m_per_s);
uint32_t sonar_time_units(double range_m, double speed_of_sound_m_per_s);

/// Reply of the pan-tilt's `l`: four numbers in the manual, nine in the listing.
struct PanTiltStatus {
  int pan_units = 0;   ///< turns of the motor from the right end stop
  int pan_clicks = 0;  ///< beyond them, 1000 a unit; signed. 0 in the manual's form
  int tilt_units = 0;
  int tilt_clicks = 0;
  bool left_stop = false;
  bool right_stop = false;
  bool low_stop = false;
  bool pan_on = false;
  bool tilt_on = false;
  bool full = true;  ///< the listing's form
};
std::string encode_pantilt_status(const PanTiltStatus& status);
std::optional<PanTiltStatus> parse_pantilt_status(std::string_view line);

}  // namespace marco::drivers::hcs12
