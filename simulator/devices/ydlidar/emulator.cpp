#include "simulator/devices/ydlidar/emulator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/pose2.hpp"

namespace marco::drivers::ydlidar {
namespace {

constexpr Duration kAnswerDelay = Duration::from_us(1000);
constexpr int kPacketSamples = 40;
constexpr int kIntensity = 200;

Bytes value(uint32_t number, int size) {
  Bytes bytes;
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<uint8_t>(number >> 8 * i));
  return bytes;
}

}  // namespace

YdlidarEmulatorOptions x2() {
  YdlidarEmulatorOptions options;
  options.baud = 115'200;
  options.samples_per_s = 3000.0;
  options.hears = false;
  options.range_max_m = 8.0;
  return options;
}

YdlidarEmulatorOptions g4() {
  YdlidarEmulatorOptions options;
  options.baud = 230'400;
  options.model = 5;
  options.samples_per_s = 9000.0;
  options.health_command = kGetHealthToo;
  options.range_max_m = 16.0;
  return options;
}

YdlidarEmulator::YdlidarEmulator(LaserWorld world, const YdlidarEmulatorOptions& options)
    : world_(std::move(world)),
      options_(options),
      form_(static_cast<SampleForm>(options.intensity_bytes)),
      output_(options.baud) {
  validate(options, "ydlidar_emulator");
}

void YdlidarEmulator::on_connection(bool connected, Utime now) {
  marked_ = false;
  // The first client finds it ready; an X2 has long begun to talk.
  if (connected && !std::exchange(on_, true)) {
    ready_ = now;
    if (!options_.hears) start_scan(now);
  }
}

void YdlidarEmulator::power_cycle(Utime now) {
  output_.clear();
  marked_ = scanning_ = false;
  on_ = true;
  ready_ = now + Duration::from_seconds(options_.power_on_s);
  if (options_.hears) return;
  answer(kInfo, info(), ready_);
  start_scan(ready_);
}

void YdlidarEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  client_baud_ = baud;
  if (!options_.hears || now < ready_ || (baud != 0 && baud != options_.baud)) return;
  for (const uint8_t byte : bytes) {
    if (!std::exchange(marked_, byte == kRequestMark)) continue;
    marked_ = false;
    handle(byte, now);
  }
}

void YdlidarEmulator::answer(uint8_t kind, const Bytes& data, Utime now) {
  Bytes all = encode_header(static_cast<uint32_t>(data.size()), false, kind);
  all.insert(all.end(), data.begin(), data.end());
  output_.send(all, now + kAnswerDelay);
}

Bytes YdlidarEmulator::info() const {
  Bytes data{static_cast<uint8_t>(options_.model), 10, 1, 1};  // firmware 1.10, hardware 1
  for (int i = 0; i < 16; ++i) data.push_back(static_cast<uint8_t>(i % 10));
  return data;
}

void YdlidarEmulator::handle(uint8_t command, Utime now) {
  if (command == kStop || command == kForceStop) {
    scanning_ = false;
    return;
  }
  if (scanning_) return;  // then it hears only a stop
  if (command == kScan && options_.health < 2) start_scan(now);
  if (command == kReset || command == kResetToo) power_cycle(now);
  if (command == kGetInfo) answer(kInfo, info(), now);
  if (command == options_.health_command) {
    answer(kHealth, {static_cast<uint8_t>(options_.health), 0, 0}, now);
  }
  if (options_.model != g4().model) return;
  if (command == kGetFrequency) {
    answer(kInfo, value(static_cast<uint32_t>(std::lround(100.0 * options_.turns_per_s)), 4), now);
  }
  if (command == kGetSampleRate) {  // 0: 4 kHz, 1: 8, 2: 9
    answer(kInfo,
           {static_cast<uint8_t>(options_.samples_per_s < 5e3     ? 0
                                 : options_.samples_per_s < 8.5e3 ? 1
                                                                  : 2)},
           now);
  }
}

void YdlidarEmulator::start_scan(Utime now) {
  if (options_.hears) output_.send(encode_header(5, true, kPackets), now + kAnswerDelay);
  scanning_ = true;
  scan_start_ = now + Duration::from_seconds(options_.spin_up_s);
  next_sample_ = 0;
}

Utime YdlidarEmulator::sample_time(int64_t sample) const {
  return scan_start_ + Duration::from_seconds(static_cast<double>(sample) / options_.samples_per_s);
}

double YdlidarEmulator::angle_deg(int64_t sample) const {
  const double turns = static_cast<double>(sample) / options_.samples_per_s * options_.turns_per_s;
  return (turns - std::floor(turns)) * 360.0;
}

bool YdlidarEmulator::starts_turn(int64_t sample) const {
  return sample == 0 || angle_deg(sample) < angle_deg(sample - 1);
}

int YdlidarEmulator::next_count() const {
  if (starts_turn(next_sample_)) return 1;
  int count = 1;
  while (count < kPacketSamples && !starts_turn(next_sample_ + count)) ++count;
  return count;
}

// The range decides where beside its angle the laser looks, and what is there decides the range.
Sample YdlidarEmulator::measure(int64_t sample) {
  double range_mm = last_range_mm_;
  for (int i = 0; i < 2; ++i) {
    const double beside_deg =
        form_ == SampleForm::wide_intensity ? 0.0 : angle_correction_deg(range_mm);
    LaserSweep beam;  // of two: no world takes less
    beam.first_beam = sample_time(sample);
    beam.beam_interval_s = 1.0 / options_.samples_per_s;
    beam.first_bearing_rad = -deg_to_rad(angle_deg(sample) + beside_deg);
    beam.bearing_step_rad = -deg_to_rad(360.0 * options_.turns_per_s / options_.samples_per_s);
    beam.beams = 2;
    const std::vector<double> ranges_m = world_(beam);
    const double range_m = ranges_m.empty() ? 0.0 : ranges_m[0];
    if (!std::isfinite(range_m) || range_m <= 0.0 || range_m > options_.range_max_m) return {};
    range_mm = 1e3 * range_m;
  }
  last_range_mm_ = range_mm;
  return {range_mm, form_ == SampleForm::range ? 0 : kIntensity};
}

void YdlidarEmulator::send_packet() {
  const int count = next_count();
  Packet packet;
  packet.turn_start = starts_turn(next_sample_);
  packet.frequency_dhz =
      packet.turn_start ? static_cast<int>(std::lround(10.0 * options_.turns_per_s)) : 0;
  const auto q6 = [this](int64_t sample) {
    return static_cast<int>(std::lround(64.0 * angle_deg(sample))) % (360 * 64);
  };
  packet.first_q6 = q6(next_sample_);
  packet.last_q6 = q6(next_sample_ + count - 1);
  for (int i = 0; i < count; ++i) packet.samples.push_back(measure(next_sample_ + i));
  next_sample_ += count;
  output_.send(encode_packet(packet, form_), sample_time(next_sample_));
}

void YdlidarEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  while (scanning_ && now >= sample_time(next_sample_ + next_count())) send_packet();
  const std::size_t before = out.size();
  output_.advance(now, out);
  if (client_baud_ == 0 || client_baud_ == options_.baud) return;
  for (std::size_t i = before; i < out.size(); ++i) out[i] = static_cast<uint8_t>(noise_());
}

Utime YdlidarEmulator::next_event() const {
  const Utime next = output_.next_event();
  return scanning_ ? std::min(next, sample_time(next_sample_ + next_count())) : next;
}

}  // namespace marco::drivers::ydlidar
