#include "drivers/hcs12/codec.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace marco::drivers::hcs12 {
namespace {

// Numbers separated by single spaces; one space at the end is forgiven (the manual's pan-tilt
// form).
std::optional<std::vector<int64_t>> parse_numbers(std::string_view text) {
  std::vector<int64_t> numbers;
  if (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  while (true) {
    int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return std::nullopt;
    numbers.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) return numbers;
    if (text.front() != ' ' || numbers.size() > 32) return std::nullopt;
    text.remove_prefix(1);
  }
}

bool is_flag(int64_t value) { return value == 0 || value == 1; }

// "10.03" = 1003 clicks.
std::optional<uint32_t> parse_clicks(std::string_view text) {
  const std::size_t point = text.find('.');
  if (point == std::string_view::npos || text.size() != point + 3) return std::nullopt;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  uint32_t turns = 0, rest = 0;
  const auto [turns_end, turns_error] = std::from_chars(text.data(), text.data() + point, turns);
  const auto [rest_end, rest_error] =
      std::from_chars(text.data() + point + 1, text.data() + text.size(), rest);
  if (turns_error != std::errc() || rest_error != std::errc()) return std::nullopt;
  if (turns_end != text.data() + point || !is_digit(text[point + 1]) || !is_digit(text[point + 2]))
    return std::nullopt;
  if (turns > 0xFFFF) return std::nullopt;
  return turns * 100 + rest;
}

void append_clicks(std::string& text, uint32_t clicks) {
  text += std::to_string((clicks / 100) & 0xFFFF) + '.';
  text += static_cast<char>('0' + clicks % 100 / 10);
  text += static_cast<char>('0' + clicks % 10);
}

}  // namespace

std::string encode_command(char letter, std::span<const uint32_t> values) {
  std::string line(1, letter);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) line += ' ';
    line += std::to_string(values[i]);
  }
  return line + '\n';
}

std::string encode_command(char letter, std::initializer_list<uint32_t> values) {
  return encode_command(letter, std::span(values.begin(), values.size()));
}

std::optional<Command> parse_command(std::string_view line) {
  if (line.empty()) return std::nullopt;
  Command command;
  command.letter = line.front();
  line.remove_prefix(1);
  if (line.empty()) return command;
  std::size_t index = 0;
  for (const char c : line) {
    if (c == ' ') {
      ++index;
    } else if (index < Command::kMaxValues) {
      command.values[index] =
          static_cast<uint16_t>(command.values[index] * 10 + (static_cast<uint8_t>(c) - '0'));
    }
  }
  command.count = std::min(index + 1, Command::kMaxValues);
  return command;
}

std::optional<WheelSigns> wheel_signs(char letter) {
  switch (letter) {
    case 'a':
      return WheelSigns{1, 1};
    case 'r':
      return WheelSigns{-1, -1};
    case 'i':
      return WheelSigns{-1, 1};
    case 'd':
      return WheelSigns{1, -1};
    default:
      return std::nullopt;
  }
}

std::string encode_wheel_status(const WheelStatus& status) {
  std::string text = "l";
  append_clicks(text, status.left_clicks);
  text += ' ';
  append_clicks(text, status.right_clicks);
  for (const bool on : {status.left_on, status.right_on, status.sonar_on}) text += on ? " 1" : " 0";
  return text + '\n';
}

std::optional<WheelStatus> parse_wheel_status(std::string_view line) {
  if (line.empty() || line.front() != 'l') return std::nullopt;
  line.remove_prefix(1);
  const std::size_t first = line.find(' ');
  if (first == std::string_view::npos) return std::nullopt;
  const std::size_t second = line.find(' ', first + 1);
  if (second == std::string_view::npos) return std::nullopt;
  const auto left = parse_clicks(line.substr(0, first));
  const auto right = parse_clicks(line.substr(first + 1, second - first - 1));
  const auto flags = parse_numbers(line.substr(second + 1));
  if (!left || !right || !flags || flags->size() != 3) return std::nullopt;
  if (!std::all_of(flags->begin(), flags->end(), is_flag)) return std::nullopt;
  return WheelStatus{*left, *right, (*flags)[0] == 1, (*flags)[1] == 1, (*flags)[2] == 1};
}

std::string encode_batteries(const BatteryMillivolts& millivolts) {
  return encode_command('t', millivolts);
}

std::optional<BatteryMillivolts> parse_batteries(std::string_view line) {
  if (line.empty() || line.front() != 't') return std::nullopt;
  const auto numbers = parse_numbers(line.substr(1));
  if (!numbers || numbers->size() != 4) return std::nullopt;
  BatteryMillivolts millivolts;
  for (std::size_t i = 0; i < 4; ++i) {
    // Ten bits of converter at the largest factor give 38362 mV.
    if ((*numbers)[i] < 0 || (*numbers)[i] > 40000) return std::nullopt;
    millivolts[i] = static_cast<uint32_t>((*numbers)[i]);
  }
  return millivolts;
}

uint32_t battery_millivolts(std::size_t battery, uint32_t adc) {
  return adc * kBatteryFactors.at(battery) / 10;
}

uint32_t battery_adc(std::size_t battery, double volts) {
  const double adc = std::round(volts * 1e4 / kBatteryFactors.at(battery));
  return static_cast<uint32_t>(std::clamp(adc, 0.0, 1023.0));
}

std::string encode_sonar(std::span<const uint32_t> times, SonarForm form) {
  std::string text = encode_command('s', times);
  if (form == SonarForm::line_each) std::replace(text.begin(), text.end(), ' ', '\n');
  return text;
}

void SonarCollector::begin(std::size_t expected) {
  expected_ = expected;
  collecting_ = true;
  times_.clear();
}

std::optional<std::vector<uint32_t>> SonarCollector::push(std::string_view line) {
  if (!collecting_) return std::nullopt;
  if (times_.empty() && !line.empty() && line.front() == 's') line.remove_prefix(1);
  if (line.empty() && times_.empty()) return std::nullopt;  // a lone "s" before the values
  const auto numbers = parse_numbers(line);
  const auto in_range = [](int64_t value) { return value >= 0 && value <= kNoEcho; };
  if (!numbers || !std::all_of(numbers->begin(), numbers->end(), in_range) ||
      times_.size() + numbers->size() > expected_) {
    collecting_ = false;
    return std::nullopt;
  }
  for (const int64_t value : *numbers) times_.push_back(static_cast<uint32_t>(value));
  if (times_.size() < expected_) return std::nullopt;
  collecting_ = false;
  return times_;
}

double sonar_range_m(uint32_t time_units, double speed_of_sound_m_per_s) {
  if (time_units >= kNoEcho) return 0.0;
  return time_units * kSonarUnitUs * 1e-6 * speed_of_sound_m_per_s / 2.0;
}

uint32_t sonar_time_units(double range_m, double speed_of_sound_m_per_s) {
  const double units = std::round(2.0 * range_m / speed_of_sound_m_per_s * 1e6 / kSonarUnitUs);
  return units >= 0.0 && units < kNoEcho ? static_cast<uint32_t>(units) : kNoEcho;
}

std::string encode_pantilt_status(const PanTiltStatus& status) {
  std::string text = "l";
  const auto add = [&text](int value) { text += std::to_string(value) + ' '; };
  add(status.pan_units);
  if (status.full) add(status.pan_clicks);
  add(status.tilt_units);
  if (status.full) {
    add(status.tilt_clicks);
    add(status.left_stop ? 1 : 0);
    add(status.right_stop ? 1 : 0);
    add(status.low_stop ? 1 : 0);
  }
  add(status.pan_on ? 1 : 0);
  add(status.tilt_on ? 1 : 0);
  if (status.full) text.pop_back();  // only the manual's form ends with a space
  return text + '\n';
}

std::optional<PanTiltStatus> parse_pantilt_status(std::string_view line) {
  if (line.empty() || line.front() != 'l') return std::nullopt;
  const auto numbers = parse_numbers(line.substr(1));
  if (!numbers || (numbers->size() != 4 && numbers->size() != 9)) return std::nullopt;
  const std::vector<int64_t>& n = *numbers;
  const bool full = n.size() == 9;
  // The drives turn at most 254 units; clicks within a unit stay below a few turns.
  const auto plausible = [](int64_t units) { return units >= -20 && units <= 400; };
  if (!plausible(n[0]) || !plausible(n[full ? 2 : 1])) return std::nullopt;
  if (!std::all_of(n.begin() + (full ? 4 : 2), n.end(), is_flag)) return std::nullopt;
  PanTiltStatus status;
  status.full = full;
  status.pan_units = static_cast<int>(n[0]);
  status.tilt_units = static_cast<int>(n[full ? 2 : 1]);
  if (full) {
    if (std::abs(n[1]) > 5000 || std::abs(n[3]) > 5000) return std::nullopt;
    status.pan_clicks = static_cast<int>(n[1]);
    status.tilt_clicks = static_cast<int>(n[3]);
    status.left_stop = n[4] == 1;
    status.right_stop = n[5] == 1;
    status.low_stop = n[6] == 1;
  }
  status.pan_on = n[n.size() - 2] == 1;
  status.tilt_on = n[n.size() - 1] == 1;
  return status;
}

}  // namespace marco::drivers::hcs12
