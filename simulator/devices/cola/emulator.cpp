#include "simulator/devices/cola/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/pose2.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::cola {
namespace {

constexpr double kFirstDeg = -45.0;
constexpr Duration kSends = Duration::from_us(1000);  // after the last beam
constexpr Duration kAnswers = Duration::from_us(5000);
constexpr uint16_t kNoEcho = 0;
// The laser's clock has run for some time; it wraps 20 s after power-on.
constexpr uint32_t kFirstUs = 0U - 20'000'000U;

std::string word_of(const std::string& text, std::size_t index) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < index && at != std::string::npos; ++i) {
    at = text.find(' ', at);
    if (at != std::string::npos) ++at;
  }
  return at == std::string::npos ? "" : text.substr(at, text.find(' ', at) - at);
}

std::string with_length(const std::string& text) { return format("%zX ", text.size()) + text; }

}  // namespace

ColaEmulatorOptions tim551() {
  ColaEmulatorOptions options;
  options.model = "TiM551";
  options.step_e4 = 10'000;
  options.beams = 271;
  return options;
}

ColaEmulatorOptions lms111() {
  ColaEmulatorOptions options;
  options.model = "LMS111_FieldEval";
  options.turns_per_s = 50.0;
  options.step_e4 = 5000;
  options.beams = 541;
  options.range_max_m = 20.0;
  return options;
}

ColaEmulator::ColaEmulator(LaserWorld world, const ColaEmulatorOptions& options)
    : world_(std::move(world)), options_(options) {
  validate(options, "cola_emulator");
}

void ColaEmulator::on_connection(bool connected, Utime now) {
  parser_.clear();
  streaming_ = single_ = logged_in_ = false;
  output_.clear();
  // The first client finds it running.
  if (connected && power_on_.us == 0) power_on_ = ready_ = now;
}

void ColaEmulator::power_cycle(Utime now) {
  on_connection(false, now);
  intensities_ = false;
  power_on_ = now;
  ready_ = now + Duration::from_seconds(options_.power_on_s);
  scans_ = 0;
}

Utime ColaEmulator::begin_of(int64_t turn) const {
  return power_on_ + Duration::from_seconds(static_cast<double>(turn) / options_.turns_per_s);
}

Utime ColaEmulator::sent_at(int64_t turn) const {
  const double fan_turns = (options_.beams - 1) * 1e-4 * options_.step_e4 / 360.0;
  return begin_of(turn) + Duration::from_seconds(fan_turns / options_.turns_per_s) + kSends;
}

int64_t ColaEmulator::turn_after(Utime when) const {
  return static_cast<int64_t>(std::ceil((when - power_on_).seconds() * options_.turns_per_s));
}

uint32_t ColaEmulator::clock_us(Utime when) const {
  return kFirstUs + static_cast<uint32_t>((when - power_on_).us);
}

void ColaEmulator::receive(std::span<const uint8_t> bytes, int /*baud*/, Utime now) {
  if (now < ready_) return;
  parser_.push(bytes);
  if (options_.binary) {
    while (parser_.next()) {
    }
    // sFA 1 in CoLa B, to whatever came.
    if (!bytes.empty() && parser_.heard_binary()) {
      const Bytes refused{2, 2, 2, 2, 0, 0, 0, 5, 's', 'F', 'A', 0, 1, 0x75};
      output_.send(refused, now + kAnswers);
    }
    return;
  }
  while (const auto telegram = parser_.next()) {
    const std::string answer = answer_to(telegram->text, now);
    if (!answer.empty()) output_.send(encode_telegram(answer), now + kAnswers);
  }
}

std::string ColaEmulator::answer_method(const std::string& name,
                                        const std::string& text,
                                        Utime now) {
  if (name == "SetAccessMode") {
    const bool right = word_of(text, 2) == "03" && word_of(text, 3) == "F4724744";
    logged_in_ = right;
    return right && options_.login ? "sAN SetAccessMode 1" : "sAN SetAccessMode 0";
  }
  if (name == "Run") {
    logged_in_ = false;
    next_turn_ = turn_after(now);
    return "sAN Run 1";
  }
  return "sFA 2";
}

std::string ColaEmulator::answer_to(const std::string& text, Utime now) {
  const std::string kind = word_of(text, 0), name = word_of(text, 1);
  if (kind == "sRN" && name == "DeviceIdent") {
    return "sRA DeviceIdent " + with_length(options_.model) + " " + with_length("V2.50-11.07.14");
  }
  if (kind == "sRN" && name == "SCdevicestate") {
    const bool warm =
        now >= ready_ + Duration::from_seconds(ready_ > power_on_ ? options_.warm_up_s : 0.0);
    return warm ? "sRA SCdevicestate 1" : "sRA SCdevicestate 0";
  }
  if (kind == "sRN" && name == "LMDscandata") {
    single_ = true;
    next_turn_ = turn_after(now);
    return "";
  }
  if (kind == "sEN" && name == "LMDscandata") {
    streaming_ = word_of(text, 2) == "1";
    next_turn_ = turn_after(now);
    return "sEA LMDscandata " + std::string(streaming_ ? "1" : "0");
  }
  if (kind == "sWN" && name == "LMDscandatacfg") {
    if (!logged_in_) return "sFA 1";
    // A TiM tells intensities in 8 bits, an LMS in either.
    const bool wide = word_of(text, 5) == "1";
    if (wide && options_.model.starts_with("TiM")) return "sFA 4";
    intensities_ = word_of(text, 4) == "1";
    return "sWA LMDscandatacfg";
  }
  if (kind == "sMN") return answer_method(name, text, now);
  return "sFA 3";
}

ScanData ColaEmulator::measure(int64_t turn) {
  LaserSweep sweep;
  sweep.first_beam = begin_of(turn);
  sweep.beam_interval_s = 1e-4 * options_.step_e4 / 360.0 / options_.turns_per_s;
  sweep.first_bearing_rad = deg_to_rad(kFirstDeg - kAheadDeg);
  sweep.bearing_step_rad = deg_to_rad(1e-4 * options_.step_e4);
  sweep.beams = options_.beams;
  ScanData scan;
  scan.serial = 0x89A27F;
  scan.status = status_;
  scan.scans = scan.telegrams = ++scans_;
  scan.begin_us = clock_us(sweep.first_beam);
  scan.sent_us = clock_us(sent_at(turn));
  scan.rate_chz = static_cast<uint32_t>(std::lround(100.0 * options_.turns_per_s));
  scan.sample_rate = static_cast<uint32_t>(std::lround(0.01 / sweep.beam_interval_s));
  Channel ranges;
  ranges.name = "DIST1";
  ranges.start_e4 = static_cast<int32_t>(1e4 * kFirstDeg);
  ranges.step_e4 = options_.step_e4;
  Channel intensities = ranges;
  intensities.name = "RSSI1";
  for (const double range_m : world_(sweep)) {
    const bool echo = std::isfinite(range_m) && range_m <= options_.range_max_m;
    ranges.values.push_back(echo ? static_cast<uint16_t>(std::lround(1e3 * range_m)) : kNoEcho);
    // A grey wall's: it falls with the distance. The world has no colours.
    intensities.values.push_back(echo ? static_cast<uint16_t>(250.0 / (1.0 + range_m)) : kNoEcho);
  }
  scan.wide.push_back(std::move(ranges));
  if (intensities_ && options_.model.starts_with("TiM")) {
    scan.narrow.push_back(std::move(intensities));
  } else if (intensities_) {
    scan.wide.push_back(std::move(intensities));
  }
  if (options_.model.starts_with("TiM")) scan.name = "not defined";
  return scan;
}

void ColaEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  while ((streaming_ || single_) && !logged_in_ && now >= sent_at(next_turn_)) {
    const std::string text =
        encode_scan(measure(next_turn_), std::exchange(single_, false) ? "sRA" : "sSN");
    output_.send(encode_telegram(text), sent_at(next_turn_));
    ++next_turn_;
  }
  output_.advance(now, out);
}

Utime ColaEmulator::next_event() const {
  const Utime next = output_.next_event();
  const bool measures = (streaming_ || single_) && !logged_in_;
  return measures ? std::min(next, sent_at(next_turn_)) : next;
}

}  // namespace marco::drivers::cola
