#include "simulator/devices/rplidar/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/rplidar/ultra_capsule.hpp"
#include "drivers/rplidar/ultra_dense_capsule.hpp"
#include "drivers/transport/wall_clock.hpp"

namespace marco::drivers::rplidar {
namespace {

constexpr Duration kAnswerDelay = Duration::from_us(1000);
constexpr int kGoodQuality = 47;
constexpr int kOffsetQ3 = 53;  // of an express scan's spots, 1/8 deg
constexpr int kA2 = 0x20;      // from this model on the host turns the motor, by PWM

void put(Bytes& bytes, uint32_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

}  // namespace

RplidarEmulator::RplidarEmulator(LaserWorld world, const RplidarEmulatorOptions& options)
    : world_(std::move(world)),
      options_(options),
      output_(options.baud),
      turning_(turns_by_itself()) {
  validate(options, "rplidar_emulator");
}

void RplidarEmulator::on_connection(bool connected, Utime /*now*/) {
  if (!connected) parser_.clear();
}

void RplidarEmulator::power_cycle(Utime now) {
  output_.clear();
  parser_.clear();
  scan_kind_ = 0;
  turning_ = turns_by_itself();
  greeted_ = false;
  ready_ = now + Duration::from_seconds(options_.reset_s);
}

void RplidarEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  if (now < ready_ || (baud != 0 && baud != options_.baud)) return;
  parser_.push(bytes);
  while (const auto request = parser_.next()) handle(*request, now);
}

void RplidarEmulator::answer(uint8_t kind, const Bytes& data, Utime now) {
  Bytes all = encode_descriptor(static_cast<uint32_t>(data.size()), false, kind);
  all.insert(all.end(), data.begin(), data.end());
  output_.send(all, now + kAnswerDelay);
}

void RplidarEmulator::handle(const Request& request, Utime now) {
  const uint8_t motor = family_of(options_.model) >= 6 ? kSetMotorSpeed : kSetMotorPwm;
  if (request.command == kSetMotorPwm || request.command == kSetMotorSpeed) {
    if (request.command == motor && !turns_by_itself() && request.data.size() == 2)
      turning_ = (request.data[0] | request.data[1] << 8) > 0;
    return;
  }
  scan_kind_ = 0;
  Bytes data;
  switch (request.command) {
    case kReset:
      power_cycle(now);
      break;
    case kScan:
    case kForceScan:
      start_scan(kNodes, now);
      break;
    case kExpressScan:
      start_scan(!request.data.empty() && request.data[0] == 1
                     ? static_cast<uint8_t>(options_.capsules)
                     : kCapsules,
                 now);
      break;
    case kGetInfo:
      data = {static_cast<uint8_t>(options_.model), 29, 1, 7};
      for (int i = 0; i < 16; ++i) data.push_back(static_cast<uint8_t>(i));
      answer(kInfo, data, now);
      break;
    case kGetHealth:
      answer(kHealth, {static_cast<uint8_t>(options_.health), 0, 0}, now);
      break;
    case kGetSampleRate:
      put(data, static_cast<uint32_t>(std::lround(options_.sample_s * 1e6)), 2);
      put(data, static_cast<uint32_t>(std::lround(options_.express_s * 1e6)), 2);
      answer(kSampleRate, data, now);
      break;
    case kGetAccessoryFlag:
      put(data, options_.model >= kA2 ? 1 : 0, 4);
      answer(kAccessoryFlag, data, now);
      break;
    case kGetConfiguration:
      answer(kConfiguration, configuration_answer(request.data), now);
      break;
    default:
      break;
  }
}

Bytes RplidarEmulator::configuration_answer(const Bytes& question) const {
  const uint8_t type = question.empty() ? 0 : question[0];
  const bool express = question.size() >= 6 && question[4] == 1;
  Bytes data;
  put(data, type, 4);
  switch (type) {
    case 0x70:  // how many scan modes
      put(data, 2, 2);
      break;
    case 0x71:  // microseconds a sample, eight bits of fraction
      put(data,
          static_cast<uint32_t>((express ? options_.express_s : options_.sample_s) * 1e6 * 256.0),
          4);
      break;
    case 0x74:  // metres, eight bits of fraction
      put(data, static_cast<uint32_t>(options_.range_max_m * 256.0), 4);
      break;
    case 0x75:
      put(data, express ? static_cast<uint8_t>(options_.capsules) : kNodes, 1);
      break;
    case 0x7C:  // the mode to be used by default
      put(data, static_cast<uint32_t>(options_.typical_mode), 2);
      break;
    case 0x7F:
      for (const char c : std::string(express ? "Express" : "Standard")) {
        data.push_back(static_cast<uint8_t>(c));
      }
      data.push_back(0);
      break;
    default:
      put(data, 0, 4);
      break;
  }
  return data;
}

void RplidarEmulator::start_scan(uint8_t kind, Utime now) {
  if (options_.health == 2) return;  // in its protection stop it measures nothing
  const std::size_t size = kind == kNodes ? kNodeSize : capsule_size(kind);
  output_.send(encode_descriptor(static_cast<uint32_t>(size), true, kind), now + kAnswerDelay);
  scan_kind_ = kind;
  first_capsule_ = true;
  scan_start_ = now + kAnswerDelay;
  next_sample_ = 0;
}

double RplidarEmulator::sample_period_s() const {
  return scan_kind_ == kNodes ? options_.sample_s : options_.express_s;
}

Utime RplidarEmulator::sample_time(int64_t sample) const {
  return scan_start_ + Duration::from_seconds(static_cast<double>(sample) * sample_period_s());
}

double RplidarEmulator::angle_deg(int64_t sample) const {
  if (!turning_) return 0.0;
  return std::fmod(static_cast<double>(sample) * sample_period_s() * options_.turns_per_s, 1.0) *
         360.0;
}

std::vector<double> RplidarEmulator::measure(int count, double behind_deg) const {
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  LaserSweep sweep;
  sweep.first_beam = sample_time(next_sample_);
  sweep.beam_interval_s = sample_period_s();
  sweep.first_bearing_rad = -(angle_deg(next_sample_) - behind_deg) * kRadPerDeg;
  sweep.bearing_step_rad = -360.0 * sample_period_s() * options_.turns_per_s * kRadPerDeg;
  sweep.beams = count;
  std::vector<double> ranges_m;
  if (turning_) ranges_m = world_(sweep);
  ranges_m.resize(static_cast<std::size_t>(count), 0.0);
  for (double& range_m : ranges_m) {
    if (!std::isfinite(range_m) || range_m > options_.range_max_m) range_m = 0.0;
  }
  return ranges_m;
}

// The spot that a sample measures lies behind its angle, by more the farther it is.
std::vector<int> RplidarEmulator::measure_behind(int count) const {
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  constexpr int kGuesses = 4;
  constexpr double kSettledDeg = 0.06;  // offsets come in steps of 0.056 deg
  std::vector<int> ranges_mm(static_cast<std::size_t>(count), 0);
  for (int i = 0; turning_ && i < count; ++i) {
    LaserSweep beam;
    beam.first_beam = sample_time(next_sample_ + i);
    beam.beams = 2;  // fewer make no sweep; the first counts
    beam.bearing_step_rad = -1e-6;
    double offset_deg = ultra_offset_deg(3000);
    for (int guess = 0; guess < kGuesses; ++guess) {
      beam.first_bearing_rad = -(angle_deg(next_sample_ + i) - offset_deg) * kRadPerDeg;
      const std::vector<double> range_m = world_(beam);
      const bool seen =
          !range_m.empty() && std::isfinite(range_m[0]) && range_m[0] <= options_.range_max_m;
      const int range_mm = seen ? static_cast<int>(std::lround(range_m[0] * 1e3)) : 0;
      const double change_deg = ultra_offset_deg(range_mm) - offset_deg;
      offset_deg += change_deg;
      if (std::abs(change_deg) > kSettledDeg) continue;  // at an edge it may never settle
      ranges_mm[static_cast<std::size_t>(i)] = range_mm;
      break;
    }
  }
  return ranges_mm;
}

void RplidarEmulator::send_nodes() {
  const std::vector<double> ranges_m = measure(batch());
  for (int i = 0; i < batch(); ++i) {
    const int64_t sample = next_sample_ + i;
    const double range_m = ranges_m[static_cast<std::size_t>(i)];
    Node node;
    node.first = sample == 0 || angle_deg(sample) < angle_deg(sample - 1);
    node.angle_q6 = static_cast<int>(angle_deg(sample) * 64.0);
    node.distance_q2 = static_cast<int>(std::lround(range_m * 4e3));
    node.quality = range_m > 0.0 ? kGoodQuality : 0;
    output_.send(encode_node(node), sample_time(sample + 1));
  }
}

void RplidarEmulator::send_capsule() {
  Capsule capsule;
  capsule.first = std::exchange(first_capsule_, false);
  capsule.start_q6 = static_cast<int>(angle_deg(next_sample_) * 64.0);
  if (scan_kind_ == kUltraCapsules) {
    const std::vector<int> ranges_mm = measure_behind(kUltraSamples + 1);
    set_ultra_ranges(capsule, std::span(ranges_mm).first<kUltraSamples>(), ranges_mm.back());
    return output_.send(encode_ultra_capsule(capsule), next_batch());
  }
  const int offset_q3 = scan_kind_ == kCapsules ? kOffsetQ3 : 0;
  capsule.offset_q3.fill(offset_q3);
  const std::vector<double> ranges_m = measure(batch(), offset_q3 / 8.0);
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    capsule.distance_mm[i] = static_cast<int>(std::lround(ranges_m[i] * 1e3));
  }
  if (scan_kind_ == kUltraDenseCapsules) {
    output_.send(encode_ultra_dense_capsule(capsule), next_batch());
  } else if (scan_kind_ == kDenseCapsules) {
    output_.send(encode_dense_capsule(capsule), next_batch());
  } else {
    output_.send(encode_capsule(capsule), next_batch());
  }
}

void RplidarEmulator::send_batch() {
  if (scan_kind_ == kNodes) {
    send_nodes();
  } else {
    send_capsule();
  }
  next_sample_ += batch();
}

void RplidarEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  if (!greeted_ && now >= ready_) {
    greeted_ = true;
    const std::string text = "RP LIDAR System.\r\nFirmware Ver 1.29, HW Ver 7\r\n";
    output_.send(Bytes(text.begin(), text.end()), ready_);
  }
  while (scan_kind_ != 0 && now >= next_batch()) send_batch();
  output_.advance(now, out);
}

Utime RplidarEmulator::next_event() const {
  Utime next = output_.next_event();
  if (!greeted_) next = std::min(next, ready_);
  if (scan_kind_ != 0) next = std::min(next, next_batch());
  return next;
}

}  // namespace marco::drivers::rplidar
